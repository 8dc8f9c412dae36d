/* `linkwright simulate` from outside. */
#include "tests/cli_run.h"

#define PENDULUM "examples/pendulum.json"

static void rows_and_report(void)
{
    expect("$P simulate " PENDULUM " --to 10 -n 2 --tolerance 1e-13 --explain", 0, "t,A.input,A.rate,A.drive,P.x,P.y,P.vx",
           "reduced: one freedom");
    expect("$P simulate " PENDULUM " --to 10 -n 2 --tolerance 1e-13 | tail -1", 0, "10,4.43370830681", "energy error");
    expect("$P simulate " PENDULUM " --to 10 -n 2 --json | python3 -c 'import json,sys; d = json.load(sys.stdin); "
           "i = d[\"columns\"].index(\"P.x\"); print(len(d[\"rows\"]), abs(d[\"rows\"][-1][i] + 0.27508746257612) < 1e-7, "
           "d[\"complete\"])'", 0, "3 True True", NULL);
}

/* A mass of 2 kg hangs on a pin: it rests below, and the pin carries its weight. */
static void rest(void)
{
    expect("sed 's/\"mass\": 1/\"mass\": 2/' " PENDULUM " > $D/m.json; $P simulate $D/m.json -a static --json | python3 -c '"
           "import json,sys; d = json.load(sys.stdin); r = dict(zip(d[\"columns\"], d[\"rows\"][0])); "
           "print(abs(r[\"P.y\"] + 1) < 1e-9, abs(r[\"P.x\"]) < 1e-6, abs(r[\"A.fy\"] - 2*9.81) < 1e-9)'", 0,
           "True True True", "stable");
}

/* A crank driven at constant speed with its mass off the pin: torque m g r cos, reaction m (r w^2 + g). */
static void driven(void)
{
    expect("$P simulate " PENDULUM " --speed 2 --to 1 -n 4 --json | python3 -c 'import json,sys,math; d = json.load(sys.stdin)\n"
           "ok = True\n"
           "for row in d[\"rows\"]:\n"
           "  r = dict(zip(d[\"columns\"], row)); a = math.pi + 2*r[\"t\"]\n"
           "  ok = ok and abs(r[\"A.drive\"] - 9.81*math.cos(a)) < 1e-9 and abs(r[\"A.fx\"] + 4*math.cos(a)) < 1e-9\n"
           "  ok = ok and abs(r[\"A.fy\"] - 9.81 + 4*math.sin(a)) < 1e-9 and abs(r[\"shaking.fx\"] - 4*math.cos(a)) < 1e-9\n"
           "print(ok)'", 0, "True", NULL);
    expect("$P simulate " PENDULUM " --speed 2 --balance", 0, "\"balanced\": true", NULL);
}

static void wrong(void)
{
    expect("$P simulate " PENDULUM " --from 2 --to 1", 2, NULL, "less than");
    expect("$P simulate " PENDULUM " -a kinematic", 3, NULL, "1 more freedom would have to be driven");
    expect("sed 's/\"mass\": 1/\"mass\": -1/' " PENDULUM " > $D/m.json; $P simulate $D/m.json", 3, NULL, "negative");
    expect("sed 's/\"mass\": 1/\"mass\": 0/' " PENDULUM " > $D/m.json; $P simulate $D/m.json", 3, NULL, "link \"bob\" can move");
    expect("$P simulate " PENDULUM " --to 1e6 -n 2 --max-steps 100", 5, "# incomplete", "rows so far are kept");
    expect("$P simulate " PENDULUM " --plot $D/x.svg -c nothing", 3, NULL, "no column");
    expect("$P simulate examples/jansen.json -f reduced", 3, NULL, NULL);
}

static void pictures(void)
{
    expect("$P simulate " PENDULUM " --plot $D/x.svg --gif $D/x.gif -n 10 -o $D/x.csv && head -c 6 $D/x.gif && grep -c svg $D/x.svg",
           0, "GIF89a", NULL);
}

int main(void)
{
    RUN(rows_and_report);
    RUN(rest);
    RUN(driven);
    RUN(wrong);
    RUN(pictures);
    return check_end();
}
