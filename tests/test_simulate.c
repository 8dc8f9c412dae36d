/* `linkwright simulate` from outside. */
#include "tests/cli_run.h"

#define PENDULUM "examples/pendulum.json"

TEST(rows_and_report)
{
    expect("$P simulate " PENDULUM " --to 10 -n 2 --tolerance 1e-13 --explain", 0, "t,A.input,A.rate,A.drive,P.x,P.y,P.vx",
           "quadrature: one freedom");
    expect("$P simulate " PENDULUM " --to 10 -n 2 --tolerance 1e-13 | tail -1", 0, "10,4.43370830681", "energy error");
    expect("$P simulate " PENDULUM " --to 10 -n 2 --json | python3 -c 'import json,sys; d = json.load(sys.stdin); "
           "i = d[\"columns\"].index(\"P.x\"); print(len(d[\"rows\"]), abs(d[\"rows\"][-1][i] + 0.27508746257612) < 1e-7, "
           "d[\"complete\"])'", 0, "3 True True", NULL);
}

/* A mass of 2 kg hangs on a pin: it rests below, and the pin carries its weight. */
/* The backward differences of CVODE lose energy in every step, those of the order 8 hardly any.  Steps of alpha are of second order. */
TEST(errors_that_add_up_are_said)
{
    expect("$P simulate " PENDULUM " --to 2100 -n 1 --formulation cvode --tolerance 1e-6", 0, NULL, "times the error allowed a step");
    OWN(ran) r = run("$P simulate " PENDULUM " --to 300 -n 1 --tolerance 1e-6");
    CHECK(r.code == 0 && !strstr(r.err, "allowed a step"));
    ran_free(&r);
    expect("sed 's/\"mass\": 1/\"mass\": 1, \"inertia\": 1/' " PENDULUM " > $D/m.json; $P simulate $D/m.json --to 20 -n 1 --formulation alpha --tolerance 1e-7", 0,
           NULL, "errors of all steps of alpha add up to");
    r = run("$P simulate $D/m.json --to 20 -n 1 --formulation radau --tolerance 1e-7");
    CHECK(r.code == 0 && !strstr(r.err, "add up"));
}

TEST(rest)
{
    expect("sed 's/\"mass\": 1/\"mass\": 2/' " PENDULUM " > $D/m.json; $P simulate $D/m.json -a static --json | python3 -c '"
           "import json,sys; d = json.load(sys.stdin); r = dict(zip(d[\"columns\"], d[\"rows\"][0])); "
           "print(abs(r[\"P.y\"] + 1) < 1e-9, abs(r[\"P.x\"]) < 1e-6, abs(r[\"A.fy\"] - 2*9.81) < 1e-9)'", 0,
           "True True True", "stable");
}

/* Friction takes no part in an equilibrium, which is said.  A spring folds two equal bars: the folded posture is singular, so it has no reactions. */
TEST(rest_with_friction_and_in_a_singular_posture)
{
    expect("sed 's/\"at\": \\[0, 0\\]}/\"at\": [0, 0], \"friction\": {\"coefficient\": 0.1, \"radius\": 0.01}}/' " PENDULUM " > $D/m.json; "
           "$P simulate $D/m.json -a static | tail -1", 0, "# assumed: equilibria without friction", "equilibria are those without friction");
    expect("echo '{\"links\": [\"ground\", {\"name\": \"a\", \"mass\": 1, \"centre\": [3, 4]}, {\"name\": \"b\", \"mass\": 1, \"centre\": [9, 4]}, "
           "{\"name\": \"s\", \"mass\": 1, \"centre\": [12, 0]}], \"joints\": [{\"name\": \"O\", \"links\": [\"ground\", \"a\"], \"at\": [0, 0]}, "
           "{\"name\": \"K\", \"links\": [\"a\", \"b\"], \"at\": [6, 8]}, {\"name\": \"B\", \"links\": [\"b\", \"s\"], \"at\": [12, 0]}, "
           "{\"name\": \"S\", \"kind\": \"t\", \"links\": [\"ground\", \"s\"], \"at\": [12, 0], \"along\": [1, 0]}], \"input\": {\"joint\": \"O\"}, "
           "\"springs\": [{\"joint\": \"S\", \"stiffness\": 5, \"free\": -12}], \"tracers\": [{\"name\": \"P\", \"link\": \"s\", \"at\": [12, 0]}], "
           "\"linkwright\": 1}' > $D/m.json; $P simulate $D/m.json -a static --json | python3 -c 'import json,sys; d = json.load(sys.stdin); "
           "r = dict(zip(d[\"columns\"], d[\"rows\"][0])); print(abs(r[\"P.x\"]) < 1e-6, r[\"O.fx\"])'", 0, "True None", "singular posture");
}

/* A crank driven at constant speed with its mass off the pin: torque m g r cos, whose work lifts it, reaction m (r w^2 + g). */
TEST(driven)
{
    expect("$P simulate " PENDULUM " --speed 2 --to 1 -n 4 --json | python3 -c 'import json,sys,math; d = json.load(sys.stdin)\n"
           "ok = True\n"
           "for row in d[\"rows\"]:\n"
           "  r = dict(zip(d[\"columns\"], row)); a = math.pi + 2*r[\"t\"]\n"
           "  ok = ok and abs(r[\"A.drive\"] - 9.81*math.cos(a)) < 1e-9 and abs(r[\"A.fx\"] + 4*math.cos(a)) < 1e-9\n"
           "  ok = ok and abs(r[\"A.fy\"] - 9.81 + 4*math.sin(a)) < 1e-9 and abs(r[\"shaking.fx\"] - 4*math.cos(a)) < 1e-9\n"
           "  ok = ok and abs(r[\"work\"] - 9.81*math.sin(a)) < 1e-9\n"
           "print(ok)'", 0, "True", NULL);
    expect("$P simulate " PENDULUM " --speed 2 --balance", 0, "\"balanced\": true", NULL);
}

/* A parallelogram driven for a turn: two rows on the flat posture, where the joints' forces have no limit. */
TEST(through_flat_postures)
{
    expect("cat > $D/flat.json <<'EOF'\n"
           "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"a\", \"mass\": 1, \"centre\": [0, 0.5]},\n"
           "{\"name\": \"b\", \"mass\": 2, \"centre\": [2, 1], \"inertia\": 0.3}, {\"name\": \"c\", \"mass\": 1.5, \"centre\": "
           "[4, 0.5]}],\n"
           "\"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"a\"], \"at\": [0, 0]}, {\"name\": \"B\", \"links\": [\"a\", "
           "\"b\"], \"at\": [0, 1]},\n"
           "{\"name\": \"C\", \"links\": [\"b\", \"c\"], \"at\": [4, 1]}, {\"name\": \"D\", \"links\": [\"ground\", \"c\"], \"at\": "
           "[4, 0]}],\n\"input\": {\"joint\": \"A\"}, \"gravity\": [0, -9.81]}\nEOF\n"
           "for n in 36 97 100 400; do $P simulate $D/flat.json --speed 6.283185307179586 -n $n --json | python3 -c '\n"
           "import json, math, sys\n"
           "d = json.load(sys.stdin); rows = [dict(zip(d[\"columns\"], r)) for r in d[\"rows\"]]\n"
           "off = max(abs(r[\"A.drive\"] - 9.81*3.25*math.cos(r[\"A.input\"])) for r in rows)\n"
           "print(len(rows), d[\"complete\"], d[\"rows_without_forces\"], max(abs(r[\"b.turn\"]) for r in rows) < 1e-9, "
           "off < 1e-8, [r[\"t\"] for r in rows if r[\"B.fx\"] is None])'; done", 0,
           "37 True 2 True True [0.25, 0.75]\n98 True 0 True True []\n101 True 2 True True [0.25, 0.75]\n"
           "401 True 2 True True [0.25, 0.75]\n", "without a limit");
    expect("$P simulate $D/flat.json --speed 6.283185307179586 -n 4 | tail -1", 0, "# singular posture in 2 rows, first at t = 0.25", NULL);
    expect("$P simulate $D/flat.json --speed 6.283185307179586 -n 97", 0, NULL, "at t = 0.25 s the motion passes a singular posture");
    /* Friction in all pins: next to the flat posture rigid links have no forces, or several, and the motion goes on.  Else the drive is that without
     * friction and the friction at the reactions.  Equilibria are without friction, however near. */
    expect("sed 's/, \"at\"/, \"friction\": {\"coefficient\": 0.3, \"radius\": 0.2}, \"at\"/g' $D/flat.json > $D/rub.json\n"
           "for a in kinematic quasistatic; do for n in 36 97; do $P simulate $D/rub.json -a $a --speed 6.283185307179586 -n $n --json | python3 -c '\n"
           "import json, math, sys\n"
           "d = json.load(sys.stdin); rows = [dict(zip(d[\"columns\"], r)) for r in d[\"rows\"]]\n"
           "known = [r for r in rows if r[\"B.fx\"] is not None]; mu = 0.06 if sys.argv[1] == \"kinematic\" else 0\n"
           "rub = lambda r: mu*sum(math.hypot(r[j + \".fx\"], r[j + \".fy\"]) for j in \"ABCD\")\n"
           "off = max(abs(r[\"A.drive\"] - 9.81*3.25*math.cos(r[\"A.input\"]) - rub(r)) for r in known)\n"
           "print(len(rows), len(known), max(abs(r[\"b.turn\"]) for r in rows) < 1e-9, off < 1e-8)' $a; done; done", 0,
           "37 35 True True\n98 91 True True\n37 35 True True\n98 98 True True\n", "friction of rigid links leaves no forces or several");
}

/* Times whose digits or whose phase are used up are refused; what is assumed is printed; 10 km are travelled at 100 m/s. */
TEST(far_away)
{
    expect("$P simulate " PENDULUM " --to 1e100 -n 4", 4, "# incomplete", "less than one digit");
    expect("$P simulate " PENDULUM " --to 1e16 -n 4", 4, "# incomplete", "too few digits");
    expect("$P simulate " PENDULUM " --to 1e16 -n 4 --speed 1", 3, "# incomplete", "too few digits");
    expect("$P simulate " PENDULUM " --to 1e9 -n 4", 0, "# assumed: inputs without a speed start at rest: A", "its phase good to");
    expect("cat > $D/cart.json <<'EOF'\n"
           "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"cart\", \"mass\": 1, \"centre\": [0, 0]},\n"
           "{\"name\": \"p\", \"mass\": 1, \"centre\": [0, -1], \"inertia\": 0.1}],\n"
           "\"joints\": [{\"name\": \"S\", \"kind\": \"t\", \"links\": [\"ground\", \"cart\"], \"at\": [0, 0], \"along\": [1, 0]},\n"
           "{\"name\": \"A\", \"links\": [\"cart\", \"p\"], \"at\": [0, 0]}],\n"
           "\"inputs\": [{\"joint\": \"S\", \"speed\": 100}, {\"joint\": \"A\"}], \"gravity\": [0, -9.81]}\nEOF\n"
           "$P simulate $D/cart.json --to 100 -n 10 | tail -1", 0, "100,", NULL);
}

/* Counterweights by --balance, put on the links: no shaking force is left.  Six-bars with two and three links at the ground
 * and Jansen's leg, half as many weights as links, also on links that float. */
TEST(balanced)
{
    expect("cat > $D/b.py <<'EOF'\n"
           "import json, math, subprocess, sys\n"
           "prog, dir, jansen = sys.argv[1:]\n"
           "J = lambda n, a, b, x, y: dict(name=n, links=[a, b], at=[x, y])\n"
           "links = lambda: ['ground', 'crank', 'coupler', 'rocker', 'arm', 'stay']\n"
           "watt = dict(linkwright=1, links=links(), input=dict(joint='A'), joints=[J('A', 'ground', 'crank', 0, 0),\n"
           "  J('B', 'crank', 'coupler', .1, 0), J('C', 'coupler', 'rocker', .4, .4), J('D', 'rocker', 'ground', .5, 0),\n"
           "  J('E', 'coupler', 'arm', .3, .6), J('F', 'arm', 'stay', .7, .8), J('G', 'rocker', 'stay', .75, .45)])\n"
           "stephenson = dict(linkwright=1, links=links(), input=dict(joint='A'), joints=[J('A', 'ground', 'crank', 0, 0),\n"
           "  J('B', 'crank', 'coupler', .05, .08), J('C', 'coupler', 'rocker', .26, .21), J('D', 'ground', 'rocker', .3, 0),\n"
           "  J('E', 'coupler', 'arm', .11, .24), J('F', 'arm', 'stay', -.04, .52), J('G', 'ground', 'stay', -.3, .25)])\n"
           "def run(m, *o):\n"
           "  json.dump(m, open(dir + '/b.json', 'w'))\n"
           "  return subprocess.run([prog, 'simulate', dir + '/b.json', '--speed', '3', '--to', '2.0943951', '-n', '60', '-q', *o],\n"
           "                        capture_output=True, text=True).stdout\n"
           "def shaking(m):\n"
           "  d = json.loads(run(m, '--json'))\n"
           "  i = d['columns'].index('shaking.fx')\n"
           "  return max(math.hypot(r[i], r[i + 1]) for r in d['rows'])\n"
           "def legs(m, n):\n"                       /* all on one crank */
           "  own = lambda l, i: l if l in ('ground', 'crank') else l + str(i)\n"
           "  k = dict(linkwright=1, links=['ground', 'crank'], joints=m['joints'][:1], input=m['input'])\n"
           "  for i in range(n):\n"
           "    k['links'] += [own(l, i) for l in m['links'] if own(l, i) != l]\n"
           "    k['joints'] += [dict(j, name=j['name'] + str(i), links=[own(l, i) for l in j['links']]) for j in m['joints'][1:]]\n"
           "  return k\n"
           "leg = json.load(open(jansen))\n"
           "for m in watt, stephenson, leg, legs(json.load(open(jansen)), 8):\n"
           "  for k, l in enumerate(m['links'][1:], 1):\n"
           "    at = [j['at'] for j in m['joints'] if l in j['links']]\n"
           "    m['links'][k] = dict(name=l, mass=.5 + .3*k, inertia=.01, centre=[sum(x)/len(at) + .01*k for x in zip(*at)])\n"
           "  before, out = shaking(m), run(m, '--balance')\n"
           "  w = json.JSONDecoder().raw_decode(out[out.index('{'):])[0]\n"
           "  for c in w['counterweights']:\n"
           "    l = next(l for l in m['links'][1:] if l['name'] == c['link'])\n"
           "    all = l['mass'] + c['mass']\n"
           "    l['centre'] = [(l['mass']*a + c['mass']*b)/all for a, b in zip(l['centre'], c['at'])]\n"
           "    l['mass'] = all\n"
           "  print(len(w['counterweights']), w['balanced'], before > 1e-2, shaking(m) < 1e-10*before)\n"
           "EOF\npython3 $D/b.py $P $D examples/jansen.json", 0, "3 True True True\n3 True True True\n4 True True True\n18 True True True\n", NULL);
}

TEST(wrong)
{
    expect("$P simulate " PENDULUM " --from 2 --to 1", 2, NULL, "less than");
    expect("$P simulate " PENDULUM " -a kinematic", 3, NULL, "1 more freedom would have to be driven");
    expect("sed 's/\"mass\": 1/\"mass\": -1/' " PENDULUM " > $D/m.json; $P simulate $D/m.json", 3, NULL, "negative");
    expect("sed 's/\"mass\": 1/\"mass\": 0/' " PENDULUM " > $D/m.json; $P simulate $D/m.json", 3, NULL, "link \"bob\" can move");
    expect("sed 's/{\"joint\": \"A\"}/{\"joint\": \"A\", \"motion\": \"sqrt(t)\"}/' " PENDULUM " > $D/m.json; $P simulate $D/m.json", 4, NULL,
           "the motion of input \"A\", its rate or its acceleration is not a number at t = 0 s");
    expect("sed 's/{\"joint\": \"A\"}/{\"joint\": \"A\", \"motion\": \"1\\/(1.01-t)\"}/' " PENDULUM " > $D/m.json; $P simulate $D/m.json --to 2", 3, "# incomplete",
           "the motion of input \"A\" is so fast near t = 1.0099999");
    expect("$P trace $D/m.json --time-range 0:2:0.1", 3, NULL, "as near a pole");
    expect("$P simulate " PENDULUM " --to 1e6 -n 2 --max-steps 10", 5, "# incomplete", "rows so far are kept");
    expect("$P simulate " PENDULUM " --plot $D/x.svg --columns nothing", 3, NULL, "no column");
    expect("$P simulate examples/jansen.json --formulation reduced", 3, NULL, NULL);
}

/* Two cranks of a square that are to turn with 1 and 2 rad/s are an error. */
TEST(starts_that_do_not_fit)
{
    expect("cat > $D/s.json << 'END'\n{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"a\", \"mass\": 1, "
           "\"centre\": [0, 0.5]}, {\"name\": \"b\", \"mass\": 1, \"centre\": [0.5, 1]}, {\"name\": \"c\", "
           "\"mass\": 1, \"centre\": [1, 0.5]}], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"a\"], "
           "\"at\": [0, 0]}, {\"name\": \"B\", \"links\": [\"a\", \"b\"], \"at\": [0, 1]}, {\"name\": \"C\", "
           "\"links\": [\"b\", \"c\"], \"at\": [1, 1]}, {\"name\": \"D\", \"links\": [\"ground\", \"c\"], "
           "\"at\": [1, 0]}], \"inputs\": [{\"joint\": \"A\", \"speed\": 1}, {\"joint\": \"D\", \"speed\": 2}]}\n"
           "END\n$P simulate $D/s.json --to 0.1 -n 1", 3, "",
           "the speeds and velocities given contradict each other or the posture at \"A\": they are off by 0.5 (of 2)");
    expect("sed 's/\"speed\": 2/\"speed\": 1/' $D/s.json > $D/t.json && $P simulate $D/t.json --to 0.1 -n 1", 0, NULL, NULL);
}

TEST(pictures)
{
    expect("$P simulate " PENDULUM " --plot $D/x.svg --gif $D/x.gif -n 10 -o $D/x.csv && head -c 6 $D/x.gif && grep -c svg $D/x.svg",
           0, "GIF89a", NULL);
}
