/* A servo whose controller runs in this program: the model has the motor, the program sets its voltage every
 * millisecond, drops a weight on the arm, and goes back in time.
 *
 *     cc stepping.c $(pkg-config --cflags --libs linkwright) -lm -o stepping
 *     ./stepping > servo.csv                                                                             */
#include <linkwright.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The state `voltage` has the rate 0: it is what the program sets it to. */
static const char text[] =
    "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"arm\", \"mass\": 2, \"centre\": [0.3, 0], \"inertia\": 0.02}],"
    " \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"arm\"], \"at\": [0, 0]}],"
    " \"input\": {\"joint\": \"A\", \"speed\": 0}, \"gravity\": [0, -9.81],"
    " \"states\": [{\"name\": \"voltage\", \"rate\": 0}],"
    " \"motors\": [{\"name\": \"M\", \"joint\": \"A\", \"voltage\": \"state(voltage)\", \"resistance\": 0.8,"
    " \"inductance\": 1e-3, \"torque_constant\": 0.05, \"inertia\": 1e-4, \"ratio\": 20}]}";

static const double sample_time = 1e-3;                /* of the controller [s] */

typedef struct controller { double sum; } controller;  /* what must be saved with the run */

static double limited(double x, double most) { return x > most ? most : x < -most ? -most : x; }

/* PI on the angle, damping by the speed: the voltage for the next millisecond. */
static double control(controller *c, const lw_simulation_sample *s, double wanted)
{
    double off = wanted - s->link[1].angle;
    c->sum = limited(c->sum + 800*off*sample_time, 20);
    return limited(300*off + c->sum - 10*s->link[1].angular_velocity, 24);
}

/* Go on by n milliseconds. */
static lw_status go(lw_stepper *stepper, const lw_model *model, controller *c, int n, lw_error *error)
{
    lw_status status = LW_OK;
    for (int k = 0; k < n && status == LW_OK; k++) {
        const lw_simulation_sample *s = lw_stepper_sample(stepper);
        status = lw_stepper_set_state(stepper, lw_model_find_state(model, "voltage"), control(c, s, 1));
        if (status == LW_OK)
            status = lw_stepper_advance(stepper, s->t + sample_time, error);
        if (status == LW_OK && k % 10 == 0)
            printf("%g,%g,%g,%g\n", s->t, s->link[1].angle, s->state[lw_model_find_state(model, "M.current")],
                   s->state[lw_model_find_state(model, "M.heat")]);
    }
    return status;
}

int main(void)
{
    static const lw_link_load weight = { .force = { 0, -5 } }, none = { .torque = 0 };
    lw_simulation_options options = lw_simulation_options_default();
    lw_model *model = NULL;
    lw_stepper *stepper = NULL;
    lw_error error = { LW_OK, "", 0, 0, "" };
    controller c = { 0 }, saved_controller;
    char *saved = NULL;
    size_t size;
    double reached = 0, again = -1;

    puts("t [s],angle [rad],current [A],heat [J]");
    lw_status status = lw_model_parse(text, strlen(text), "servo", &model, &error);
    if (status == LW_OK)
        status = lw_stepper_create(model, &options, &stepper, &error);
    if (status == LW_OK)
        status = go(stepper, model, &c, 1000, &error);                 /* lift the arm */
    if (status == LW_OK)
        status = lw_stepper_save(stepper, &saved, &size);
    saved_controller = c;
    for (int trial = 0; trial < 2 && status == LW_OK; trial++) {       /* the same second twice */
        status = lw_stepper_restore(stepper, saved, size, &error);
        c = saved_controller;
        if (status == LW_OK)
            status = lw_stepper_set_load(stepper, 1, weight);
        if (status == LW_OK)
            status = go(stepper, model, &c, 500, &error);
        if (status == LW_OK)
            status = lw_stepper_set_load(stepper, 1, none);
        if (status == LW_OK)
            status = go(stepper, model, &c, 500, &error);
        if (status == LW_OK)
            *(trial ? &again : &reached) = lw_stepper_sample(stepper)->link[1].angle;
    }
    if (status == LW_OK)
        fprintf(stderr, "angle %.6f rad after 2 s; the second trial has %s bits\n", reached,
                reached == again ? "the same" : "other");
    else
        fprintf(stderr, "%s\n", error.text);
    lw_free(saved);
    lw_stepper_destroy(stepper);
    lw_model_destroy(model);
    return status == LW_OK && reached == again && fabs(reached - 1) < 0.02 ? 0 : 1;
}
