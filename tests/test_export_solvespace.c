/* Sketches of SolveSpace: every constraint holds where the points stand, and as many freedoms are left as the linkage
 * has.  (SolveSpace 3.1 itself brings points that were disturbed back to these constraints.) */
#include "catalogues/exchange/export.h"

#include "tests/example_linkage.h"

typedef struct sketch { int n_value; unsigned handle[800]; double value[800]; } sketch;

/* The hexadecimal number behind a key in this block of text; 0: it is not there. */
static unsigned handle_of(const char *block, const char *end, const char *key)
{
    const char *at = strstr(block, key);
    return at && at < end ? (unsigned)strtoul(at + strlen(key), NULL, 16) : 0;
}

static double real_of(const char *block, const char *end, const char *key)
{
    const char *at = strstr(block, key);
    return at && at < end ? strtod(at + strlen(key), NULL) : 0;
}

static double value_of(const sketch *s, unsigned handle)
{
    for (int i = 0; i < s->n_value; i++)
        if (s->handle[i] == handle)
            return s->value[i];
    CHECK(!"a parameter that is there");
    return NAN;
}

/* A point entity: number 0 of a point's request, 1 or 2 of a line's. */
static lw_vec2 point_of(const sketch *s, unsigned entity)
{
    unsigned first = (entity & 0xffff0000u) | (0x10 + 3*((entity & 0xffff) == 2));
    return lw_v2(value_of(s, first), value_of(s, first + 1));
}

static void read_sketch(const char *text, sketch *s)
{
    memset(s, 0, sizeof *s);
    for (const char *at = text; (at = strstr(at, "Param.h.v.=")) && s->n_value < 800; at++) {
        s->handle[s->n_value] = (unsigned)strtoul(at + 11, NULL, 16);
        s->value[s->n_value++] = real_of(at, at + 200, "Param.val=");
    }
}

/* How far a constraint is from holding [mm]; *rows: its equations. */
static double off_by(const sketch *s, const char *block, const char *end, int *rows)
{
    int type = (int)real_of(block, end, "Constraint.type=");
    double want = real_of(block, end, "Constraint.valA=");
    lw_vec2 a = point_of(s, handle_of(block, end, "Constraint.ptA.v="));
    unsigned b = handle_of(block, end, "Constraint.ptB.v="), line = handle_of(block, end, "Constraint.entityA.v=");
    *rows = type == 20 || type == 200 ? 2 : 1;
    if (type == 200)
        return 0;
    if (type == 20 || type == 30)
        return fabs(lw_v2_norm(lw_v2_sub(a, point_of(s, b))) - want);
    CHECK(type == 32 || type == 42);
    lw_vec2 u = point_of(s, line | 1), d = lw_v2_sub(point_of(s, line | 2), u);
    return fabs(lw_v2_cross(d, lw_v2_sub(a, u))/lw_v2_norm(d) + (type == 32 ? want : 0));
}

static void constraints_hold(const lw_linkage *k)
{
    static sketch s;
    OWN(lw_bytes) b = { 0 };
    int rows = 0, n = 0;
    CHECK_SILENT(lw_export_solvespace(LW_VIEW(k), NULL, &b, &check_error));
    CHECK(memcmp(b.data, "\xb1\xb2\xb3SolveSpaceREVa\n", 18) == 0);
    read_sketch(b.data, &s);
    for (const char *at = b.data; (at = strstr(at, "Constraint.h.v=")); at++, n++) {
        int own;
        CHECK_NEAR(off_by(&s, at, strstr(at, "AddConstraint"), &own), 0, 1e-9*1000*lw_export_size(LW_VIEW(k)), 0);
        rows += own;
    }
    CHECK(n > k->n_joint);
    CHECK_INT(s.n_value - rows, lw_linkage_mobility(k));
}

TEST(examples_hold)
{
    for (int i = 0; i < N_EXAMPLE; i++) {
        lw_linkage k = example(example_names[i]);
        if (strcmp(example_names[i], "geared-five-bar") != 0)
            constraints_hold(&k);
    }
    for (int order = 0; order < 4; order++) {
        lw_linkage k = scotch_yoke(order);
        constraints_hold(&k);
    }
}

TEST(refusals)
{
    lw_linkage k = example("geared-five-bar");
    lw_bytes b = { 0 };
    CHECK_FAILS(lw_export_solvespace(LW_VIEW(&k), NULL, &b, &check_error), LW_E_KIND, "gears and welds");
    CHECK(b.data == NULL);
}

/* Its handles count 32767 points and lines: n bars on the ground need 2 n - 1. */
TEST(as_many_points_as_it_can_number)
{
    static const int n[] = { 10800, 16400 };
    for (int i = 0; i < 2; i++) {
        OWN(lw_assembly) a = { .n_link = n[i] + 1, .n_joint = n[i], .n_tracer = n[i], .units = lw_units_si() };
        OWN(lw_bytes) b = { 0 };
        lw_error e = { 0 };
        a.link_name = calloc(a.n_link, sizeof *a.link_name);
        a.joint = calloc(a.n_joint, sizeof *a.joint);
        a.input = calloc(1, sizeof *a.input);
        a.tracer = calloc(a.n_tracer, sizeof *a.tracer);
        for (int k = 0; k < n[i]; k++) {
            a.joint[k] = (lw_joint){ .kind = LW_JOINT_REVOLUTE, .link = { 0, k + 1 }, .at = { 2*(k % 100), 2*(k/100) } };
            a.tracer[k] = (lw_tracer){ .link = k + 1, .at = { 2*(k % 100), 2*(k/100) + 1 } };
            snprintf(a.joint[k].name, sizeof a.joint[k].name, "J%d", k);
            snprintf(a.tracer[k].name, sizeof a.tracer[k].name, "P%d", k);
            snprintf(a.link_name[k + 1], sizeof a.link_name[k], "L%d", k);
        }
        strcpy(a.link_name[0], "ground");
        CHECK_INT(lw_export_solvespace(&a, NULL, &b, &e), i ? LW_E_KIND : LW_OK);
        CHECK(i ? b.data == NULL : strstr((char *)b.data, "AddConstraint") != NULL);
        if (i)
            CHECK_HAS(e.text, "up to 32767 points and lines");
    }
}
