/* Forces and constraint rows in space: their derivatives against differences. */
#include "mbs/equations/equations_space.h"
#include "tests/space_run.h"

typedef struct matrix { int n; double *by_q, *by_v; } matrix;

static void add_entry(void *context, int row, int column, double by_q, double by_v)
{
    matrix *m = context;
    m->by_q[row*m->n + column] += by_q;
    m->by_v[row*m->n + column] += by_v;
}

/* A state of the model of derivatives_of_forces_and_rows, and the greatest differences of its derivatives from central differences. */
enum { SLOPES_N = 18, SLOPES_ALL = 19, SLOPES_ROWS = 40 };        /* velocities; these and the states; rows */
static const double slopes_h = 1e-5;

typedef struct slopes {
    lw_space s;
    lw_space_forces f;
    double by_q[SLOPES_ALL*SLOPES_ALL], by_v[SLOPES_ALL*SLOPES_ALL], q[21], v[SLOPES_N];
    double force[2][SLOPES_ALL], phi[SLOPES_ROWS], jac[2][SLOPES_ROWS*LW_SPACE_ROW];
    lw_space_frame frame[4];
    lw_space_bend bend[4*LW_SPACE_BENDS];
    double off_q, off_v, off_rows, off_couplings, rest[2];
} slopes;

/* Place the bodies at q, moved along coordinate i to one side; i < 0: at q. */
static void place_aside(slopes *g, int i, int side)
{
    double at[21], by[SLOPES_N] = { 0 };
    memcpy(at, g->q, sizeof at);
    if (i >= 0) {
        by[i] = side ? slopes_h : -slopes_h;
        lw_space_move(&g->s, at, by);
    }
    lw_space_place(&g->s, at, g->frame);
}

/* Forces and rates of states where the bodies are placed, at velocities v. */
static void force_aside(slopes *g, const double *v, int side)
{
    lw_space_forces_apply(&g->f, 0.3, g->frame, v, g->force[side], NULL, NULL);
    lw_space_state_rates(&g->f, 0.3, g->frame, v, g->force[side] + SLOPES_N);
}

static void compare_slopes(const slopes *g, const double *by, int i, double *off)
{
    for (int a = 0; a < SLOPES_ALL; a++)
        *off = fmax(*off, fabs((g->force[1][a] - g->force[0][a])/(2*slopes_h) - by[a*SLOPES_ALL + i]));
}

/* Second derivatives of the rows of joints by coordinate i. */
static void compare_rows(slopes *g, int i)
{
    for (int j = 0; j < g->s.n_joint; j++)
        for (int r = 0; r < lw_spatial_kind_of(g->s.joint[j].kind)->rows; r++) {
            double change[SLOPES_N] = { 0 };
            int n = lw_space_row_bends(&g->s, g->frame, j, r, g->bend), row = g->s.joint[j].row + r;
            for (int b = 0; b < n; b++)
                if (g->bend[b].b == i)
                    change[g->bend[b].a] += g->bend[b].h;
            for (int c = 0; c < LW_SPACE_ROW; c++) {
                int body = g->s.joint[j].body[c/6];
                double d = (g->jac[1][row*LW_SPACE_ROW + c] - g->jac[0][row*LW_SPACE_ROW + c])/(2*slopes_h);
                if (body >= 0)
                    g->off_rows = fmax(g->off_rows, fabs(d - change[6*body + c%6]));
            }
        }
}

/* First derivatives of couplings by coordinate i, and what their second ones add to the bias. */
static void compare_couplings(slopes *g, int i)
{
    double sum[3], of_sum[24], turns[6] = { 0 };
    for (int j = 0; j < g->s.n_coupling; j++) {
        const lw_space_coupling *c = &g->s.coupling[j];
        double change[SLOPES_N] = { 0 }, first = 0;
        for (int b = lw_space_coupling_bends(&g->s, g->frame, j, g->bend) - 1; b >= 0; b--)
            if (g->bend[b].b == i)
                change[g->bend[b].a] += g->bend[b].h;
        for (int side = 0; side < 3; side++) {
            place_aside(g, side < 2 ? i : -1, side);
            lw_space_coupling_row(&g->s, j, g->frame, turns, &sum[side], of_sum);
        }
        for (int a = 0; a < 6*c->n_side; a++)
            if (c->body[a/6] >= 0) {
                first += 6*c->body[a/6] + a%6 == i ? of_sum[a] : 0;
                g->rest[j] += g->v[6*c->body[a/6] + a%6]*change[6*c->body[a/6] + a%6]*g->v[i];
            }
        g->off_couplings = fmax(g->off_couplings, fabs((sum[1] - sum[0])/(2*slopes_h) - first));
    }
}

static void compare_at(slopes *g, int i)
{
    for (int side = 0; side < 2; side++) {
        place_aside(g, i, side);
        force_aside(g, g->v, side);
        lw_space_rows(&g->s, g->frame, g->phi, g->jac[side]);
    }
    compare_slopes(g, g->by_q, i, &g->off_q);
    place_aside(g, -1, 0);
    compare_rows(g, i);
    compare_couplings(g, i);
    for (int side = 0; side < 2; side++) {
        double w[SLOPES_N];
        memcpy(w, g->v, sizeof w);
        w[i] += side ? slopes_h : -slopes_h;
        force_aside(g, w, side);
    }
    compare_slopes(g, g->by_v, i, &g->off_v);
}

/* Forces of every kind, and rows of every joint, at a random posture: derivatives against central differences along the
 * motions of the bodies. */
TEST(derivatives_of_forces_and_rows)
{
    static const char text[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1.2, 'centre': [0.3, 0.1, 0.2], 'inertia': [0.02, 0.03, 0.04, 0.002, -0.003, "
        "0.001]}, {'name': 'b', 'mass': 0.7, 'centre': [0.6, 0.4, 0.1], 'inertia': [0.01, 0.02, 0.02, 0.001, 0.002, -0.003]}, {'name': 'c', 'mass': 0.9, "
        "'centre': [0.9, 0.2, 0.5], 'inertia': [0.03, 0.02, 0.025]}], 'couplings': [{'name': 'rack', 'terms': [{'joint': 'T', 'factor': -1.3}, {'joint': "
        "'C', 'coordinate': 'slide', 'factor': 0.4}, {'joint': 'C', 'coordinate': 'turn', 'factor': 0.7}]}, {'name': 'mesh', 'terms': [{'joint': 'H', "
        "'coordinate': 'turn', 'factor': 3}, {'joint': 'E', 'factor': -2}]}], 'joints': [{'name': 'C', 'kind': 'cylindrical', 'links': ['ground', 'a'], "
        "'at': [0, 0, 0], 'axis': [1, 2, -1], 'stop': {'least': -1e-9, 'greatest': 1e-9, 'stiffness': 7, 'damping': 0.3}}, {'name': 'H', 'kind': 'screw', "
        "'links': ['a', 'b'], 'at': [0.4, 0.2, 0.1], 'axis': [0.3, -1, 0.5], 'lead': 0.4}, {'name': 'U', 'kind': 'universal', 'links': ['b', 'c'], 'at': "
        "[0.7, 0.3, 0.3], 'axis': [1, 0.2, 0.1], 'second_axis': [0.3, 1, 0.4]}, {'name': 'E', 'kind': 'planar', 'links': ['a', 'c'], 'at': [1, 0.4, 0.4], "
        "'axis': [0.2, 0.3, 1]}, {'name': 'T', 'kind': 'prismatic', 'links': ['a', 'c'], 'at': [1.3, 0.3, 0.2], 'axis': [1, -1, 0.3]}, {'name': 'F', "
        "'kind': 'fixed', 'links': ['b', 'c']}], 'states': [{'name': 'w', 'rate': 'x(P)*vy(P) + length(S)*rate(S) - 2*state(w)*q(H)', 'start': 0.4}], "
        "'springs': [{'joint': 'H', 'coordinate': 'turn', 'law': 'rate*displacement - 2*displacement^2'}, {'joint': 'C', 'coordinate': 'slide', "
        "'stiffness': 40, 'damping': 2}, {'joint': 'H', 'coordinate': 'turn', 'stiffness': 2, 'damping': 0.5}, {'name': 'S', 'links': ['c', 'b'], 'at': "
        "[[0.9, 0.4, 0.5], [1.2, 0.5, 0.2]], 'stiffness': 50, 'damping': 3}, {'links': ['ground', 'a'], 'at': [[1.5, 0.5, 1], [1.9, 0.2, 0.3]], 'law': "
        "'3*length^2 + rate*length'}], 'forces': [{'link': 'c', 'at': [1, 1, 0], 'fx': 'x(P)*vy(P)', 'fz': '3 + state(w)*length(S) + rate(S)', 'ty': "
        "'q(H)'}, {'link': 'b', 'at': [0, 1, 0.5], 'frame': 'link', 'fy': '4 + y(P)', 'tx': 2}], 'gravity': [0.5, -1, -9.81], 'tracers': [{'name': 'P', "
        "'link': 'c', 'at': [2, 0.2, 0.1]}]}";
    OWN(lw_spatial) m = { 0 };
    static slopes g;
    double by[SLOPES_N], most = 0;
    lw_rng rng = check_rng(0);
    read_spatial(text, "derivatives", &m);
    CHECK_OK(lw_space_make(&m, &g.s, &check_error));
    CHECK_OK(lw_space_forces_make(&g.s, &g.f, &check_error));
    CHECK(g.s.n_v == SLOPES_N && g.s.n_row <= SLOPES_ROWS);
    lw_vec3 turn = lw_v3_scale(m.joint[0].axis, 0.5);
    lw_space_place(&g.s, g.s.start, g.frame);
    for (int i = 0; i < SLOPES_N; i++) {     /* all turn about C: angles have their derivatives where axes are parallel */
        lw_vec3 own = lw_m3_unapply(&g.frame[i/6 + 1].turn, turn);
        by[i] = i%6 < 3 ? 0.2*lw_rng_normal(&rng) : i%3 == 0 ? own.x : i%3 == 1 ? own.y : own.z;
        g.v[i] = lw_rng_normal(&rng);
    }
    memcpy(g.q, g.s.start, sizeof g.q);
    lw_space_move(&g.s, g.q, by);
    place_aside(&g, -1, 0);
    lw_space_state_start(&g.f, 0.3, g.frame, g.v, g.force[0]);
    CHECK_NEAR(g.force[0][0], 0.4, 0, 0);
    lw_space_forces_apply(&g.f, 0.3, g.frame, g.v, g.force[0], NULL, &(lw_space_sink){ &(matrix){ SLOPES_ALL, g.by_q, g.by_v }, add_entry, add_entry });
    for (int i = 0; i < SLOPES_N; i++)
        compare_at(&g, i);
    for (int side = 0; side < 2; side++) {           /* by the state */
        g.f.z[0] = 0.4 + (side ? slopes_h : -slopes_h);
        force_aside(&g, g.v, side);
    }
    compare_slopes(&g, g.by_q, SLOPES_N, &g.off_q);
    for (int i = 0; i < SLOPES_ALL*SLOPES_ALL; i++)
        most = i%SLOPES_ALL < SLOPES_N ? fmax(most, fabs(g.by_q[i])) : most;
    CHECK(most > 1);
    CHECK_NEAR(g.off_q, 0, 1e-7*most, 0);
    CHECK_NEAR(g.off_v, 0, 1e-7*most, 0);
    CHECK_NEAR(g.off_rows, 0, 1e-7, 0);
    CHECK_INT(g.s.n_coupling, 2);
    CHECK_NEAR(g.off_couplings, 0, 1e-8, 0);
    for (int j = 0; j < 2; j++) {
        CHECK_NEAR(lw_space_coupling_bias(&g.s, j, g.frame, g.v), -g.rest[j], 1e-9, 0);
        CHECK(fabs(g.rest[j]) > 1e-2);
    }
    lw_space_forces_free(&g.f);
    lw_space_free(&g.s);
}
