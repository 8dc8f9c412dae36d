/* tests/points_linkage.h - linkages through a notation of points and back: what must stay the same. */
#ifndef LW_TESTS_POINTS_LINKAGE_H
#define LW_TESTS_POINTS_LINKAGE_H

#include "mbs/constraints/newton.h"
#include "tests/check.h"
#include "tests/mbs_random.h"

typedef lw_status points_read(const char *text, size_t size, const char *file, const lw_units *units, lw_assembly *k, lw_error *e);

/* What was read fits a linkage. */
static inline lw_status read_small(points_read *read, const char *text, const lw_units *units, lw_linkage *k, lw_error *e)
{
    lw_assembly a;
    lw_status s = read(text, strlen(text), "t", units, &a, e);
    if (s == LW_OK)
        s = lw_assembly_linkage(&a, k, e);
    lw_assembly_free(&a);
    return s;
}
typedef char *points_write(const lw_assembly *k, lw_error *e);

/* A four-bar as text; and a driven slider at 20 mm, 30 degrees, whose file is in millimetres. */
static inline char *fourbar_text(points_write *write)
{
    const double dim[9] = { 4, 1, 3, 3.5, 1, 1, 0, 0, 0 };
    lw_linkage k;
    lw_error e;
    fourbar_linkage(&k, dim, 1, 1.5707963267948966);
    return write(LW_VIEW(&k), &e);
}

static inline char *slide_text(points_write *write)
{
    lw_linkage k;
    lw_error e;
    blank_linkage(&k, 2);
    add_slide(&k, 0, 1, lw_v2(0.02, 0), LW_PI/6);
    add_input(&k, 0, 0);
    lw_units_set_length(&k.units, "mm");
    return write(LW_VIEW(&k), &e);
}

/* Written and read; false, and a failed check, when one of them does not work. */
static inline bool there_and_back(points_write *write, points_read *read, const lw_linkage *k, lw_linkage *back)
{
    lw_error e = { 0 };
    char *text = write(LW_VIEW(k), &e);
    lw_status s = text ? read_small(read, text, &k->units, back, &e) : e.status;
    if (s != LW_OK)
        fprintf(stderr, "    %ld:%ld: %s\n%s", e.line, e.column, e.text, text ? text : "");
    CHECK_INT(s, LW_OK);
    free(text);
    return s == LW_OK;
}

static inline void same_parts(const lw_linkage *a, const lw_linkage *b)
{
    CHECK_INT(b->n_link, a->n_link);
    CHECK_INT(b->n_joint, a->n_joint);
    CHECK_INT(b->n_input, a->n_input);
    CHECK_INT(b->n_tracer, a->n_tracer);
    CHECK_INT(lw_linkage_mobility(b), lw_linkage_mobility(a));
    for (int i = 0; i < a->n_tracer && i < b->n_tracer; i++) {
        CHECK_NEAR(b->tracer[i].at.x, a->tracer[i].at.x, 0, 0x1p-52);   /* the unit costs one rounding */
        CHECK_NEAR(b->tracer[i].at.y, a->tracer[i].at.y, 0, 0x1p-52);
    }
}

/* Both are moved by the same step of the input: their tracers go the same way. */
static inline void same_motion(const lw_linkage *a, const lw_linkage *b)
{
    const lw_linkage *const both[2] = { a, b };
    lw_newton *n[2] = { NULL, NULL };
    lw_status s[2];
    for (int i = 0; i < 2; i++) {
        s[i] = lw_newton_create(both[i], &n[i], NULL);
        if (s[i] == LW_OK)
            s[i] = lw_newton_move(n[i], both[i]->input[0].value + 0.03, NULL);
    }
    CHECK_INT(s[1], s[0]);
    for (int i = 0; s[0] == LW_OK && s[1] == LW_OK && i < a->n_tracer; i++) {
        lw_vec2 p = lw_newton_tracer(n[0], i), q = lw_newton_tracer(n[1], i);
        CHECK_POINT(q, p.x, p.y, 1e-8, 0);
    }
    lw_newton_free(n[0]);
    lw_newton_free(n[1]);
}

static inline void random_round_trips(points_write *write, points_read *read)
{
    lw_rng r = check_rng(0);
    for (int trial = 0; trial < 60; trial++) {
        lw_linkage k, back, again;
        random_grown(&r, 1 + trial%5, &k);
        if (trial%3 == 0)                                  /* a third link on a pin, with a free end */
            for (int j = 0; j < k.n_joint; j++)
                if (k.joint[j].kind == LW_JOINT_REVOLUTE) {
                    snprintf(k.link_name[k.n_link], LW_NAME_SIZE, "hung");
                    add_pin(&k, k.joint[j].link[trial%2], k.n_link++, k.joint[j].at);
                    break;
                }
        lw_units_set_length(&k.units, trial%2 ? "mm" : "in");
        if (!there_and_back(write, read, &k, &back))
            continue;
        same_parts(&k, &back);
        if (trial%3)
            same_motion(&k, &back);
        if (there_and_back(write, read, &back, &again))
            same_parts(&back, &again);
    }
}

/* Two of them are one point: three links on a pin in a slot; a slider with a link welded to it. */
static inline void points_of_several_joints(points_write *write, points_read *read)
{
    lw_linkage k, back;
    blank_linkage(&k, 6);
    add_pin(&k, 0, 1, lw_v2(0, 0));
    add_pin(&k, 1, 2, lw_v2(0, 1));
    add_joint(&k, LW_JOINT_SLOT, 3, 2, lw_v2(0, 1), 1.5);
    add_joints(&k, JOINTS(PIN(3, 0, 0, -2), PIN(2, 4, 0, 1), SLIDE(0, 4, 3, 0.1, 0.7)));
    add_joint(&k, LW_JOINT_FIXED, 5, 4, lw_v2(3, 0.1), 0);
    k.joint[6].along = lw_v2(0, 0);
    add_tracer(&k, 5, lw_v2(4, 4));
    add_input(&k, 0, 0);
    if (!there_and_back(write, read, &k, &back))
        return;
    same_parts(&k, &back);
    int n[256] = { 0 };
    for (int j = 0; j < back.n_joint; j++)
        n[back.joint[j].kind]++;
    CHECK_INT(n[LW_JOINT_REVOLUTE], 4);
    CHECK_INT(n[LW_JOINT_SLOT], 1);
    CHECK_INT(n[LW_JOINT_SLIDER], 1);
    CHECK_INT(n[LW_JOINT_FIXED], 1);
    for (int j = 0; j < back.n_joint; j++)
        if (back.joint[j].kind == LW_JOINT_SLIDER)
            CHECK_POINT(back.joint[j].along, cos(0.7), sin(0.7), 1e-15, 0);
}

static inline void names_are_made_fit(points_write *write, points_read *read)
{
    static const char *const names[] = { "base", "R", "rp", "a link, long", "a_link__long", "2", "GROUND", "gnd" };
    lw_linkage k, back;
    blank_linkage(&k, 8);
    for (int i = 0; i < 8; i++)
        snprintf(k.link_name[i], LW_NAME_SIZE, "%s", names[i]);
    for (int i = 0; i < 8; i++)
        add_pin(&k, i, (i + 1)%8, lw_v2(i, i*i));
    if (!there_and_back(write, read, &k, &back))
        return;
    CHECK_INT(back.n_link, 8);
    CHECK_TEXT(back.link_name[back.ground], "ground");
    for (int i = 0; i < 8; i++)
        CHECK(back.joint[i].link[0] == i);                 /* nothing mixed up */
}

static inline void what_cannot_be_written(points_write *write)
{
    lw_linkage k;
    lw_error e = { 0 };
    blank_linkage(&k, 3);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(0, 2, 3, 0), GEAR(1, 2, 1, 0, -0.5)));
    CHECK(write(LW_VIEW(&k), &e) == NULL);
    CHECK_INT(e.status, LW_E_KIND);
    CHECK_HAS(e.text, "gear");
    k.joint[2] = (lw_joint){ .name = "W", .kind = LW_JOINT_FIXED, .link = { 1, 2 } };
    CHECK(write(LW_VIEW(&k), &e) == NULL);
    CHECK_HAS(e.text, "weld");
    blank_linkage(&k, 4);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, 0), PIN(2, 3, 1, 0)));
    add_input(&k, 2, 0);
    CHECK(write(LW_VIEW(&k), &e) == NULL);
    CHECK_HAS(e.text, "two moving links");
    k.n_link = 1;
    CHECK(write(LW_VIEW(&k), &e) == NULL);
    CHECK_INT(e.status, LW_E_ARG);
}

typedef struct fault_row { const char *text; long line, column; const char *part; } fault_row;

static inline void check_faults(points_read *read, const fault_row *row, size_t n)
{
    lw_units u = lw_units_si();
    for (size_t i = 0; i < n; i++) {
        lw_assembly k;
        lw_error e = { 0 };
        CHECK_INT(read(row[i].text, strlen(row[i].text), "f", &u, &k, &e), LW_E_NOTATION);
        CHECK_TEXT(e.file, "f");
        CHECK_INT(e.line, row[i].line);
        CHECK_INT(e.column, row[i].column);
        CHECK_HAS(e.text, row[i].part);
        if (e.line != row[i].line || e.column != row[i].column)
            fprintf(stderr, "    %s: %s\n", row[i].text, e.text);
    }
}

#endif
