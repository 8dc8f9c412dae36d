/* A pendulum in air: forward dynamics with a force of the caller's own, which takes energy away.
 *
 *     cc own_force.c $(pkg-config --cflags --libs linkwright) -lm -o own_force
 *     ./own_force > swing.csv                                                                            */
#include <linkwright.h>
#include <math.h>
#include <stdio.h>

typedef struct air { double drag; } air;                       /* [N s^2/m^2] */
typedef struct run { int samples; double first, last; } run;   /* energies [J] */

/* Drag grows with the square of the speed of the bob, link 1. */
static void drag(void *context, double t, const lw_link_motion *link, lw_link_load *load)
{
    const air *a = context;
    lw_vec2 v = link[1].velocity;
    double speed = hypot(v.x, v.y);
    (void)t;
    load[1].force.x = -a->drag*speed*v.x;
    load[1].force.y = -a->drag*speed*v.y;
}

static lw_status print_row(void *context, const lw_simulation_sample *s)
{
    run *r = context;
    double energy = s->kinetic + s->potential;
    if (r->samples++ == 0)
        r->first = energy;
    r->last = energy;
    printf("%g,%g,%g,%g\n", s->t, s->input[0], energy, hypot(s->joint[0].force.x, s->joint[0].force.y));
    return LW_OK;
}

int main(void)
{
    static const lw_joint_info pin = { .name = "A", .kind = 'r', .link = { 0, 1 }, .at = { 0, 0 } };
    static const lw_input_info angle = { .joint = 0 };
    air a = { .drag = 0.2 };
    run r = { 0 };
    lw_linkage *linkage = NULL;
    lw_model *model = NULL;
    lw_simulation *simulation = NULL;
    lw_simulation_report report;
    lw_error error = { LW_OK, "", 0, 0, "" };

    lw_status status = lw_linkage_create(2, 0, 1, &pin, 1, &angle, 0, NULL, &linkage, &error);
    if (status == LW_OK)
        status = lw_model_create(linkage, &model);
    if (status == LW_OK) {
        lw_vec2 bob = { 1, 0 }, gravity = { 0, -9.81 };
        lw_model_set_mass(model, 1, 1, bob, 0);               /* 1 kg, 1 m from the pin, let go from the side */
        lw_model_set_gravity(model, gravity);

        lw_simulation_options options = lw_simulation_options_default();
        options.to = 10;
        options.force.apply = drag;
        options.force.context = &a;
        status = lw_simulation_create(model, &options, &simulation, &error);
    }
    puts("t [s],angle [rad],energy [J],force at the pin [N]");
    if (status == LW_OK)
        status = lw_simulation_run(simulation, print_row, &r, &report, &error);
    if (status == LW_OK)
        fprintf(stderr, "%s; energy balance within %.1e J\n", report.formulation, report.energy_error);
    else
        fprintf(stderr, "%s\n", error.text);
    lw_simulation_destroy(simulation);
    lw_model_destroy(model);
    lw_linkage_destroy(linkage);
    return status == LW_OK && r.samples == 101 && r.last < r.first - 1 && report.energy_error < 1e-6 ? 0 : 1;
}
