/* tests/test_clearance_tree.c - tree coordinates against differences, accelerations against the equations of all bodies
 * written out. */
#include <stdlib.h>
#include "mbs/clearance/clearance_internal.h"
#include "tests/check.h"
#include "tests/clearance_models.h"

typedef struct scene {
    lw_linkage k;
    lw_model   m;
    lw_clearance_scene *c;
    lw_clearance_work w;
    int pin, n;
    double u[LW_SYSTEM_Q_MAX], du[LW_SYSTEM_Q_MAX];
} scene;

/* A random linkage with one pin opened, away from its posture, moving */
static scene *make(lw_rng *rng, int trial)
{
    scene *s = calloc(1, sizeof *s);
    lw_clearance_options o = lw_clearance_options_default();
    random_grown(rng, 1 + trial%4, &s->k);
    s->pin = random_pin(rng, &s->k);
    if (trial%5 == 4) {                              /* a weld somewhere */
        int j = (s->pin + 1)%s->k.n_joint;
        s->k.joint[j].kind = LW_JOINT_FIXED;
        s->k.joint[j].along = lw_v2(0, 0);
        s->k.input[0].joint = s->pin;
    }
    give_masses(rng, &s->k, s->pin, &s->m);
    s->m.clearance[s->pin].model = (lw_clearance_model)(LW_CLEARANCE_MLSD + trial%2);
    s->m.clearance[s->pin].damping = trial%3 ? 20 : 0;
    s->m.clearance[s->pin].friction = trial%2 ? 0.3 : 0;
    s->m.clearance[s->pin].friction_speed = 0.5;
    s->m.friction[s->pin].radius = 0.2;
    CHECK_INT(lw_clearance_make(&s->m, &s->c, NULL), LW_OK);
    CHECK_INT(lw_clearance_work_make(s->c, &o, &s->w), LW_OK);
    double q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX] = { 0 };
    s->n = s->c->tree.n_u;
    lw_system_posture(&s->c->s, q);
    lw_tree_read(&s->c->tree, q, v, s->u, s->du);
    for (int k = 0; k < s->n; k++) {
        s->u[k] += lw_rng_range(rng, -0.01, 0.01);
        s->du[k] = lw_rng_range(rng, -1, 1);
    }
    lw_row_choice none = { 0 };
    CHECK_INT(lw_clearance_project(&s->w, &none, 0, s->u, s->du), LW_OK);
    s->w.phase[0] = LW_CONTACT_FULL;
    s->w.struck[0] = 1;
    return s;
}

static void drop(scene *s)
{
    lw_clearance_work_free(&s->w);
    lw_clearance_free(s->c);
    lw_model_free(&s->m);
    free(s);
}

static void bodies(scene *s, const double *u, const double *du, double *q, double *v)
{
    lw_tree_place(&s->c->tree, u, du, &s->w.state);
    lw_tree_write(&s->c->tree, &s->w.state, du, q, v);
}

/* v and bias are the first and second differences of q along u + du h; reading gives back the values written */
TEST(rates_by_differences)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 100; trial++) {
        scene *s = make(&rng, trial);
        double q[3][LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX], trash[LW_SYSTEM_Q_MAX], u[LW_SYSTEM_Q_MAX],
        du[LW_SYSTEM_Q_MAX];
        const double h = 1e-4;
        for (int e = -1; e <= 1; e++) {
            for (int k = 0; k < s->n; k++)
                u[k] = s->u[k] + e*h*s->du[k];
            bodies(s, u, s->du, q[e + 1], e ? trash : v);
            if (e == 0) {
                lw_vec2 bias[LW_LINK_MAX];
                memcpy(bias, s->w.state.bias, sizeof bias);
                lw_tree_read(&s->c->tree, q[1], v, u, du);
                for (int k = 0; k < s->n; k++) {
                    CHECK_NEAR(u[k], s->u[k], 1e-13, 0);
                    CHECK_NEAR(du[k], s->du[k], 1e-12, 0);
                }
                memcpy(s->w.state.bias, bias, sizeof bias);
            }
        }
        bodies(s, s->u, s->du, q[1], v);
        for (int i = 0; i < s->c->s.n_q; i++) {
            double bias = i%3 == 0 ? s->w.state.bias[i/3 + 1].x : i%3 == 1 ? s->w.state.bias[i/3 + 1].y : 0;
            CHECK_NEAR((q[2][i] - q[0][i])/(2*h), v[i], 1e-6, 1e-6);
            CHECK_NEAR((q[2][i] - 2*q[1][i] + q[0][i])/(h*h), bias, 1e-5, 1e-5);
        }
        drop(s);
    }
}

/* The tree's joints hold in every state, the others after projection; rates too */
TEST(joints_hold)
{
    lw_rng rng = check_rng(4);
    for (int trial = 0; trial < 100; trial++) {
        scene *s = make(&rng, trial);
        const lw_system *y = &s->c->s;
        double q[3*LW_SYSTEM_Q_MAX] = { 0 }, phi[3*LW_SYSTEM_ROW_MAX];
        bodies(s, s->u, s->du, q, q + y->n_q);
        lw_system_series(y, 1, q, phi);
        for (int r = 0; r < y->n_row; r++)
            if (y->row[r].joint != s->pin) {
                CHECK_NEAR(phi[r], 0, 1e-12, 0);
                CHECK_NEAR(phi[y->n_row + r], 0, 1e-10, 0);
            }
        drop(s);
    }
}

/* Forces on all bodies: weight, contact with friction, from points of the plane [m, N] */
static void push_bodies(scene *s, const double *q, const double *v, double *force)
{
    const lw_system *y = &s->c->s;
    const lw_clearance *c = &s->m.clearance[s->pin];
    lw_vec2 at[2], rate[2], arm[2];
    double spin[2], unit = y->unit, ground[3] = { 0 };
    memcpy(force, s->c->f.weight, sizeof(double)*(size_t)y->n_q);
    for (int end = 0; end < 2; end++) {
        int b = y->joint[s->pin].body[end];
        const double *place = b < 0 ? ground : q + 3*b, *speed = b < 0 ? ground : v + 3*b;
        arm[end] = lw_v2_scale(lw_v2_turn(y->joint[s->pin].arm[end], lw_v2_polar(1, place[2])), unit);
        at[end] = lw_v2_add(lw_v2_scale(lw_v2(place[0], place[1]), unit), arm[end]);
        spin[end] = speed[2];
        rate[end] = lw_v2_add(lw_v2_scale(lw_v2(speed[0], speed[1]), unit), lw_v2_scale(lw_v2_perp(arm[end]), spin[end]));
    }
    lw_vec2 d = lw_v2_sub(at[1], at[0]), n = lw_v2_scale(d, 1/lw_v2_norm(d)), along = lw_v2_perp(n);
    lw_vec2 dv = lw_v2_sub(rate[1], rate[0]);
    double r = lw_v2_norm(d), press = lw_contact_force(c, s->w.phase[0], r - c->gap, lw_v2_dot(n, dv), s->w.struck[0]);
    double slip = lw_v2_dot(along, dv) + 0.2*spin[1] - (0.2 + r)*spin[0];
    double drag = c->friction*fabs(press)*tanh(slip/c->friction_speed);
    lw_vec2 f = lw_v2_sub(lw_v2_scale(n, -press), lw_v2_scale(along, drag));
    /* the force acts where the surfaces meet, 0.2 m out from the pin's centre, on both links */
    lw_vec2 contact = lw_v2_add(at[1], lw_v2_scale(n, 0.2));
    for (int end = 0; end < 2; end++) {
        int b = y->joint[s->pin].body[end];
        if (b < 0)
            continue;
        lw_vec2 on = end ? f : lw_v2_scale(f, -1), centre = lw_v2_scale(lw_v2(q[3*b], q[3*b + 1]), unit);
        force[3*b] += on.x*unit;
        force[3*b + 1] += on.y*unit;
        force[3*b + 2] += lw_v2_cross(lw_v2_sub(contact, centre), on);
    }
}

/* M a - J^T l = Q, J a = c for all bodies, by least squares */
static void accelerate_bodies(scene *s, const double *q, const double *v, double *a)
{
    const lw_system *y = &s->c->s;
    int n = y->n_q, rows = y->n_row, all = n + rows;
    double *jac = calloc((size_t)(rows*n), sizeof *jac), *phi = calloc(3*(size_t)rows, sizeof *phi);
    double *series = calloc(3*(size_t)n, sizeof *series), *b = calloc((size_t)all, sizeof *b),
    *x = calloc((size_t)all, sizeof *x);
    double *memory = calloc(lw_rank_doubles(all, all), sizeof *memory), force[LW_SYSTEM_Q_MAX];
    double *matrix = calloc((size_t)(all*all), sizeof *matrix), *rest = calloc(3*(size_t)all, sizeof *rest);
    double *right = rest + all, *step = right + all;
    int *ints = calloc(lw_rank_ints(all, all), sizeof *ints);
    lw_rank k;
    lw_rank_place(&k, all, all, memory, ints);
    memcpy(series, q, sizeof(double)*(size_t)n);
    memcpy(series + n, v, sizeof(double)*(size_t)n);
    lw_system_rows(y, q, phi, jac);
    lw_system_series(y, 2, series, phi);
    push_bodies(s, q, v, force);
    for (int i = 0; i < n; i++) {
        k.a[i + all*i] = s->c->f.mass[i];
        b[i] = force[i];
    }
    for (int r = 0; r < rows; r++) {
        if (y->row[r].joint == s->pin)
            continue;
        for (int i = 0; i < n; i++)
            k.a[n + r + all*i] = k.a[i + all*(n + r)] = jac[r*n + i];
        b[n + r] = -2*phi[2*rows + r];
    }
    memcpy(matrix, k.a, sizeof(double)*(size_t)(all*all));
    memcpy(rest, b, sizeof(double)*(size_t)all);
    lw_rank_factor(&k, 1e-13);
    for (int pass = 0; pass < 3; pass++) {                   /* with the residual solved for again */
        memcpy(right, rest, sizeof(double)*(size_t)all);
        lw_rank_solve(&k, right, step);
        for (int i = 0; i < all; i++)
            x[i] += step[i];
        memcpy(rest, b, sizeof(double)*(size_t)all);
        for (int c = 0; c < all; c++)
            for (int i = 0; i < all; i++)
                rest[i] -= matrix[i + all*c]*x[c];
    }
    memcpy(a, x, sizeof(double)*(size_t)n);
    free(matrix), free(rest);
    free(jac), free(phi), free(series), free(b), free(x), free(memory), free(ints);
}

TEST(accelerations_of_all_bodies)
{
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 120; trial++) {
        scene *s = make(&rng, trial);
        int n_q = s->c->s.n_q;
        double q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX], a[LW_SYSTEM_Q_MAX], ddu[LW_SYSTEM_Q_MAX], scale = 1;
        CHECK_INT(lw_clearance_accelerate(&s->w, 0, s->u, s->du, ddu), LW_OK);
        bodies(s, s->u, s->du, q, v);
        accelerate_bodies(s, q, v, a);
        for (int i = 0; i < n_q; i++)
            scale = fmax(scale, fabs(a[i]));
        for (int b = 0; b < s->c->s.n_body; b++) {
            lw_vec2 rate = lw_tree_velocity(&s->c->tree, &s->w.state, b, lw_v2(0, 0), ddu);
            int turn = s->c->tree.hang[b].turn;
            CHECK_NEAR(rate.x + s->w.state.bias[b + 1].x, a[3*b], 1e-8*scale, 0);
            CHECK_NEAR(rate.y + s->w.state.bias[b + 1].y, a[3*b + 1], 1e-8*scale, 0);
            CHECK_NEAR(turn < 0 ? 0 : ddu[turn], a[3*b + 2], 1e-8*scale, 0);
        }
        drop(s);
    }
}

/* The rate of a reaction along the motion is its difference in time */
TEST(rate_of_reaction)
{
    OWN(lw_model) m = { 0 };
    lw_clearance_scene *c;
    OWN(lw_clearance_work) w = { 0 };
    lw_clearance_options o = lw_clearance_options_default();
    CHECK_OK(paper_c("m", 1, 0, false, &m, &check_error));
    m.clearance[2].model = LW_CLEARANCE_ZERO;
    CHECK_INT(lw_clearance_make(&m, &c, NULL), LW_OK);
    CHECK_INT(lw_clearance_work_make(c, &o, &w), LW_OK);
    int n = w.n_u;
    double y[2*LW_SYSTEM_Q_MAX], a[LW_SYSTEM_Q_MAX];
    w.rows.hold[0] = true;
    CHECK_INT(lw_clearance_begin(&w, y, y + n, NULL), LW_OK);
    lw_vec2 f, rate, side[2];
    CHECK_INT(lw_clearance_reaction_rate(&w, 0, y, 0, &f, &rate), LW_OK);
    const double h = 1e-4;
    for (int end = 0; end < 2; end++) {          /* Euler-Richardson steps of h/200 either way */
        double z[2*LW_SYSTEM_Q_MAX], half[2*LW_SYSTEM_Q_MAX], d = (end ? h : -h)/200;
        memcpy(z, y, sizeof(double)*2*(size_t)n);
        for (int i = 0; i < 200; i++) {
            lw_clearance_accelerate(&w, 0, z, z + n, a);
            for (int k = 0; k < n; k++) {
                half[k] = z[k] + 0.5*d*z[n + k];
                half[n + k] = z[n + k] + 0.5*d*a[k];
            }
            lw_clearance_accelerate(&w, 0, half, half + n, a);
            for (int k = 0; k < n; k++) {
                z[k] += d*half[n + k];
                z[n + k] += d*a[k];
            }
        }
        lw_clearance_accelerate(&w, 0, z, z + n, a);
        side[end] = lw_clearance_reaction(&w, 0);
    }
    CHECK_NEAR((side[1].x - side[0].x)/(2*h), rate.x, 1e-3, 1e-5);
    CHECK_NEAR((side[1].y - side[0].y)/(2*h), rate.y, 1e-3, 1e-5);
    CHECK(lw_v2_norm(rate) > 1);
    lw_clearance_free(c);
}
