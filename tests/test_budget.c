/* The error budget of a robot's tool beside joints that are really moved, drives that are really turned, and elastic links at
 * rest under the same load. */
#include "mbs/analysis/budget.h"
#include "mbs/formulations/formulations.h"
#include "tests/spatial_models.h"

static const lw_budget_source *source_of(const lw_budget *b, lw_budget_kind kind, int index)
{
    for (int i = 0; i < b->n; i++)
        if (b->source[i].kind == kind && b->source[i].index == index)
            return &b->source[i];
    return NULL;
}

static lw_vec3 random_direction(lw_rng *r)
{
    lw_vec3 v;
    do
        v = lw_v3(lw_rng_range(r, -1, 1), lw_rng_range(r, -1, 1), lw_rng_range(r, -1, 1));
    while (!(lw_v3_norm(v) > 0.1) || lw_v3_norm(v) > 1);
    return lw_v3_scale(v, 1/lw_v3_norm(v));
}

static lw_vec3 tool_of(lw_robot *r, const double *q)
{
    lw_space_place(&r->space, q, r->follow.z.frame);
    return lw_space_point_at(r->follow.z.frame, r->space.tracer[r->tool]);
}

/* The tool when the second links' points lie off those of the first ones by these vectors, drives held. */
static lw_vec3 strayed(lw_robot *r, const lw_vec3 *off)
{
    lw_space_rows_set *z = &r->follow.z;
    double *q = malloc(((size_t)r->space.n_q + (size_t)z->n_row)*sizeof *q), *target = q + r->space.n_q;
    memcpy(q, r->follow.q, (size_t)r->space.n_q*sizeof *q);
    lw_space_rows_fill(z, q, NULL);
    for (int i = r->space.n_row; i < z->n_row; i++)
        target[i - r->space.n_row] = i < r->space.n_row + r->follow.n_idle ? 0 : z->phi[i];
    for (int j = 0; j < r->space.n_joint; j++)
        r->space.joint[j].arm[0] = lw_v3_add(r->space.joint[j].arm[0],
                                             lw_m3_unapply(&z->frame[r->space.joint[j].body[0] + 1].turn, off[j]));
    CHECK_INT(lw_space_rows_close(z, q, target, 0), LW_OK);
    lw_space_place(&r->space, r->follow.q, z->frame);
    for (int j = 0; j < r->space.n_joint; j++)
        r->space.joint[j].arm[0] = lw_v3_sub(r->space.joint[j].arm[0],
                                             lw_m3_unapply(&z->frame[r->space.joint[j].body[0] + 1].turn, off[j]));
    lw_vec3 place = tool_of(r, q);
    free(q);
    return place;
}

TEST(joints_that_are_moved)
{
    static const char *const file[] = { "delta", "stewart", "arm" };
    const double gap = 1e-5;
    lw_rng rng = check_rng(1);
    for (int f = 0; f < 3; f++) {
        OWN(lw_spatial) m = { 0 };
        OWN(lw_robot) r = { 0 };
        OWN(lw_budget) b = { 0 };
        lw_budget_options o = { .clearance = gap };
        load_spatial(file[f], &m);
        CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
        if (f == 0)
            CHECK_OK(lw_robot_move(&r, lw_v3(0.2, 0, -0.65), NULL, &check_error));
        CHECK_OK(lw_budget_make(&r, NULL, &o, &b, &check_error));
        lw_vec3 home = tool_of(&r, r.follow.q), off[32];
        double squares = 0, n_trial = f ? 100 : 400;
        for (int trial = 0; trial < n_trial; trial++) {
            lw_vec3 linear = { 0, 0, 0 };
            for (int j = 0; j < m.n_joint; j++) {
                const lw_budget_source *s = source_of(&b, LW_BUDGET_CLEARANCE, j);
                bool pin = m.joint[j].kind == LW_SPATIAL_REVOLUTE;
                off[j] = lw_v3(0, 0, 0);
                if (!s)
                    continue;
                lw_space_place(&r.space, r.follow.q, r.follow.z.frame);
                lw_vec3 d = random_direction(&rng), z = lw_m3_apply(&r.follow.z.frame[r.space.joint[j].body[0] + 1].turn, r.space.joint[j].z[0]);
                lw_vec3 x = lw_v3_across(z), y = lw_v3_cross(z, x);
                if (pin) {                           /* across the axis; by: along x and y */
                    double turn = lw_rng_range(&rng, 0, 2*LW_PI);
                    d = trial == 0 ? lw_m3_unapply(&s->by, b.direction) : lw_v3(cos(turn), sin(turn), 0);
                } else if (trial == 0)
                    d = lw_m3_unapply(&s->by, b.direction);
                double size = lw_v3_norm(d);         /* the first trial is the worst case */
                d = size > 0 ? lw_v3_scale(d, 1/size) : d;
                linear = lw_v3_add(linear, lw_m3_apply(&s->by, d));
                off[j] = lw_v3_scale(pin ? lw_v3_add(lw_v3_scale(x, d.x), lw_v3_scale(y, d.y)) : d, gap);
            }
            lw_vec3 way = lw_v3_sub(strayed(&r, off), home);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(way, linear)), 0, 1e-3*b.worst, 0);
            CHECK(lw_v3_norm(way) <= 1.001*b.worst);
            if (trial == 0)
                CHECK_NEAR(lw_v3_norm(way), b.worst, 0, 1e-3);
            else
                squares += lw_v3_dot(linear, linear)/(n_trial - 1);
        }
        CHECK_NEAR(sqrt(squares), b.rms, 0, 0.15);
    }
}

TEST(drives_that_are_turned)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    OWN(lw_budget) b = { 0 };
    lw_robot_pose p;
    lw_budget_options o = { .play = { 1e-5, 1e-5 } };
    load_spatial("delta", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    CHECK_OK(lw_robot_move(&r, lw_v3(-0.1, 0.2, -0.7), NULL, &check_error));
    CHECK_OK(lw_robot_measure(&r, &p, &check_error));
    CHECK_OK(lw_budget_make(&r, NULL, &o, &b, &check_error));
    CHECK_INT(b.n, 3);
    double worst = 0;
    for (int k = 0; k < 8; k++) {
        double value[3];
        lw_robot_pose at;
        for (int i = 0; i < 3; i++)
            value[i] = p.drive[i] + (k >> i & 1 ? 1e-5 : -1e-5);
        CHECK_OK(lw_robot_drive(&r, value, &check_error));
        CHECK_OK(lw_robot_measure(&r, &at, &check_error));
        worst = fmax(worst, lw_v3_norm(lw_v3_sub(at.place, p.place)));
    }
    CHECK_NEAR(b.worst, worst, 0, 1e-4);
}

typedef struct rest { lw_dynamics *d; lw_vec3 tool; } rest;

static lw_status keep_tool(void *context, const lw_moment *moment)
{
    rest *r = context;
    lw_space_moment o;
    lw_error e;
    lw_status s = lw_dynamics_space_moment(r->d, moment, &o, &e);
    r->tool = lw_space_point_at(o.frame, lw_dynamics_space(r->d)->tracer[0]);
    return s;
}

/* Where the tool rests: elastic links, with a force on the tool. */
static lw_vec3 tool_at_rest(lw_spatial *m, bool rigid)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics_report q;
    lw_rest at;
    rest r = { NULL, { 0, 0, 0 } };
    o.analysis = LW_ANALYSIS_STATIC, o.hold_inputs = true, o.rigid = rigid, o.intervals = 1;
    CHECK_OK(lw_dynamics_make_spatial(m, &o, &r.d, &check_error));
    CHECK_OK(lw_dynamics_analyse(r.d, keep_tool, &r, &q, &at, &check_error));
    lw_dynamics_free(r.d);
    return r.tool;
}

TEST(links_that_bend)
{
    OWN(lw_spatial) m = { 0 };
    OWN(lw_robot) r = { 0 };
    OWN(lw_budget) b = { 0 };
    OWN(lw_budget_stiffness) s = { 0 };
    lw_budget_options o = { .load = { 3, -2, -5 }, .weight = true };
    load_spatial("delta-elastic", &m);
    CHECK_OK(lw_robot_make(&m, NULL, &r, &check_error));
    CHECK_OK(lw_budget_stiffness_make(&m, &o, &s, &check_error));
    CHECK_OK(lw_budget_make(&r, &s, &o, &b, &check_error));
    CHECK_INT(b.n, 9);
    lw_vec3 home = tool_of(&r, r.follow.q);
    lw_force force = { .link = m.tracer[0].link, .at = m.tracer[0].at };
    for (int i = 0; i < 3; i++) {
        lw_expression_words words = { .context = NULL };
        const char *const text[] = { "3", "-2", "-5" };
        CHECK_OK(lw_expression_parse_words(text[i], strlen(text[i]), &words, &force.force[i], &check_error));
    }
    lw_force *own = m.force;
    m.force = &force, m.n_force = 1;
    lw_vec3 bent = lw_v3_sub(tool_at_rest(&m, false), home);
    m.force = own, m.n_force = 0;
    for (int i = 0; i < 3; i++)
        lw_expression_free(force.force[i]);
    CHECK(lw_v3_norm(bent) > 1e-5);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(bent, b.bent)), 0, 0.01*lw_v3_norm(bent), 0);
    CHECK_NEAR(b.worst, lw_v3_norm(b.bent), 0, 1e-9);
}
