/* Mobility, the check, and what a posture says about its inputs. */
#include "grammar/linkage/assembly.h"
#include "tests/check.h"

static void add_link(lw_linkage *k, const char *name) { strcpy(k->link_name[k->n_link++], name); }

static void add_joint(lw_linkage *k, lw_joint_kind kind, int a, int b, double x, double y)
{
    lw_joint *j = &k->joint[k->n_joint];
    bool slides = kind == LW_JOINT_SLIDER || kind == LW_JOINT_SLOT;
    *j = (lw_joint){ .kind = kind, .link = { a, b }, .at = { x, y }, .along = { slides ? 1 : 0, 0 },
                     .ratio = kind == LW_JOINT_GEAR ? -2 : 0 };
    snprintf(j->name, sizeof j->name, "J%d", ++k->n_joint);
}

/* A four-bar with pins at (0,0) (0,1) (3,2) (4,0) and its tracer on the coupler. */
static lw_linkage four_bar(void)
{
    lw_linkage k = { .units = lw_units_si() };
    add_link(&k, "ground");
    add_link(&k, "crank");
    add_link(&k, "coupler");
    add_link(&k, "rocker");
    add_joint(&k, LW_JOINT_REVOLUTE, 0, 1, 0, 0);
    add_joint(&k, LW_JOINT_REVOLUTE, 1, 2, 0, 1);
    add_joint(&k, LW_JOINT_REVOLUTE, 2, 3, 3, 2);
    add_joint(&k, LW_JOINT_REVOLUTE, 3, 0, 4, 0);
    k.n_input = k.n_tracer = 1;
    strcpy(k.tracer[0].name, "P");
    k.tracer[0].link = 2;
    k.tracer[0].at = lw_v2(1, 3);
    return k;
}

/* F = 3 (P - 1) - 2 n1 - n2.  Chains and their freedoms: Makkonen 1999, section 3.2. */
TEST(mobility_of_known_chains)
{
    static const struct { int n_link, n_pin, n_slider, n_slot, n_gear, freedom; } known[] = {
        { 4, 4, 0, 0, 0, 1 }, { 4, 3, 1, 0, 0, 1 }, { 3, 2, 0, 1, 0, 1 }, { 6, 7, 0, 0, 0, 1 },
        { 5, 5, 0, 0, 0, 2 }, { 3, 2, 0, 0, 1, 1 }, { 3, 3, 0, 0, 0, 0 }, { 2, 1, 0, 0, 0, 1 },
        { 8, 9, 1, 0, 0, 1 }, { 2, 0, 0, 1, 1, 1 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_linkage k = { .n_link = known[i].n_link };
        for (int n = 0; n < known[i].n_pin; n++)
            add_joint(&k, LW_JOINT_REVOLUTE, 0, 1, 0, 0);
        for (int n = 0; n < known[i].n_slider; n++)
            add_joint(&k, LW_JOINT_SLIDER, 0, 1, 0, 0);
        for (int n = 0; n < known[i].n_slot; n++)
            add_joint(&k, LW_JOINT_SLOT, 0, 1, 0, 0);
        for (int n = 0; n < known[i].n_gear; n++)
            add_joint(&k, LW_JOINT_GEAR, 0, 1, 0, 0);
        CHECK_INT(lw_linkage_mobility(&k), known[i].freedom);
    }
}

TEST(good_linkages_pass)
{
    lw_linkage k = four_bar();
    CHECK_OK(lw_linkage_check(&k, &check_error));
    CHECK_INT(lw_linkage_check(&k, NULL), LW_OK);
    k.n_input = k.n_tracer = 0;
    CHECK_OK(lw_linkage_check(&k, &check_error));
    add_link(&k, "wheel");
    add_joint(&k, LW_JOINT_GEAR, 0, 4, 5, 5);
    add_joint(&k, LW_JOINT_SLOT, 3, 4, 5, 6);
    CHECK_OK(lw_linkage_check(&k, &check_error));
}

/* One fault a function; the text must name what is wrong. */
static void two_links_one_name(lw_linkage *k)   { strcpy(k->link_name[2], "crank"); }
static void link_without_name(lw_linkage *k)    { k->link_name[1][0] = '\0'; }
static void name_without_end(lw_linkage *k)     { memset(k->link_name[1], 'x', LW_NAME_SIZE); }
static void two_joints_one_name(lw_linkage *k)  { strcpy(k->joint[3].name, "J1"); }
static void two_tracers_one_name(lw_linkage *k) { k->tracer[k->n_tracer++] = k->tracer[0]; }
static void joint_to_itself(lw_linkage *k)      { k->joint[1].link[1] = 1; }
static void joint_to_nowhere(lw_linkage *k)     { k->joint[1].link[1] = 4; }
static void link_with_escape(lw_linkage *k)     { strcpy(k->link_name[1], "a\xc2\x9b" "b"); }
static void joint_below_zero(lw_linkage *k)     { k->joint[1].link[0] = -1; }
static void joint_of_no_kind(lw_linkage *k)     { k->joint[1].kind = (lw_joint_kind)'q'; }
static void joint_at_nan(lw_linkage *k)         { k->joint[2].at.y = NAN; }
static void joint_too_far(lw_linkage *k)        { k->joint[2].at.x = 1e101; }
static void slider_without_direction(lw_linkage *k) { k->joint[2].kind = LW_JOINT_SLIDER; }
static void slider_not_unit(lw_linkage *k)
{
    k->joint[2].kind = LW_JOINT_SLIDER;
    k->joint[2].along = lw_v2(1, 1);
}
static void pin_with_direction(lw_linkage *k)   { k->joint[2].along = lw_v2(1, 0); }
static void pin_with_ratio(lw_linkage *k)       { k->joint[2].ratio = 1; }
static void gear_without_ratio(lw_linkage *k)   { k->joint[2].kind = LW_JOINT_GEAR; }
static void no_ground(lw_linkage *k)            { k->ground = 4; }
static void too_many_links(lw_linkage *k)       { k->n_link = LW_LINK_MAX + 1; }
static void no_joints(lw_linkage *k)            { k->n_joint = 0; }
static void loose_link(lw_linkage *k)           { add_link(k, "lost"); }
static void loose_pair(lw_linkage *k)
{
    add_link(k, "lost");
    add_link(k, "found");
    add_joint(k, LW_JOINT_REVOLUTE, 4, 5, 1, 1);
}
static void input_at_no_joint(lw_linkage *k)    { k->input[0].joint = 4; }
static void input_at_slot(lw_linkage *k)
{
    add_joint(k, LW_JOINT_SLOT, 0, 1, 1, 1);
    k->input[0].joint = 4;
}
static void input_twice(lw_linkage *k)          { k->n_input = 2; }
static void input_nan(lw_linkage *k)            { k->input[0].value = NAN; }
static void tracer_on_no_link(lw_linkage *k)    { k->tracer[0].link = -1; }
static void tracer_nan(lw_linkage *k)           { k->tracer[0].angle = INFINITY; }
static void unit_zero(lw_linkage *k)            { k->units.metre = 0; }
static void title_without_end(lw_linkage *k)    { memset(k->name, 'x', sizeof k->name); }

TEST(every_fault_is_named)
{
    static const struct { void (*spoil)(lw_linkage *); const char *part; } faults[] = {
        { two_links_one_name, "links 2 and 3 are both called \"crank\"" },
        { link_with_escape, "the name of link 2 holds a control character" }, { link_without_name, "link 2 has no name" }, { name_without_end, "link 2 is not terminated" },
        { two_joints_one_name, "joints 1 and 4 are both called \"J1\"" },
        { two_tracers_one_name, "tracers 1 and 2 are both called \"P\"" },
        { joint_to_itself, "\"J2\" joins link \"crank\" to itself" },
        { joint_to_nowhere, "\"J2\" joins links number 1 and 4" }, { joint_below_zero, "\"J2\"" },
        { joint_of_no_kind, "\"J2\" is of no known kind" }, { joint_at_nan, "\"J3\" is not finite" },
        { joint_too_far, "\"J3\" is not finite or beyond" },
        { slider_without_direction, "\"J3\" slides" }, { slider_not_unit, "it has length 1.41" },
        { pin_with_direction, "\"J3\" of kind 'r' has no direction" },
        { pin_with_ratio, "\"J3\" of kind 'r' has no ratio" },
        { gear_without_ratio, "\"J3\" is a gear" }, { no_ground, "the ground is link number 4" },
        { too_many_links, "at most 32 links" }, { no_joints, "at least 1 joints" },
        { loose_link, "ties link \"lost\"" }, { loose_pair, "ties link \"lost\"" },
        { input_at_no_joint, "joint number 4" }, { input_at_slot, "\"J5\" of kind 'p' cannot be driven" },
        { input_twice, "\"J1\" is driven twice" }, { input_nan, "\"J1\" has a number that is not finite" },
        { tracer_on_no_link, "\"P\" sits on link number -1" }, { tracer_nan, "\"P\" has a number" },
        { unit_zero, "units" }, { title_without_end, "the linkage is not terminated" },
    };
    for (size_t i = 0; i < sizeof faults/sizeof *faults; i++) {
        lw_linkage k = four_bar();
        lw_error e = { 0 };
        faults[i].spoil(&k);
        CHECK_INT(lw_linkage_check(&k, &e), LW_E_ARG);
        CHECK_INT(e.status, LW_E_ARG);
        CHECK_HAS(e.text, faults[i].part);
    }
}

TEST(pin_input_is_the_direction_of_its_link)
{
    lw_linkage k = four_bar();
    CHECK_NEAR(lw_linkage_posture_input(&k, 0), LW_PI/2, 0, 1e-15);             /* crank up            */
    CHECK_NEAR(lw_linkage_posture_input(&k, 3), atan2(2, -1), 0, 1e-15);        /* rocker, ground last */
    /* between moving links: coupler (0,1)-(3,2) less crank (0,1)-(0,0) */
    CHECK_NEAR(lw_linkage_posture_input(&k, 1), atan2(1, 3) + LW_PI/2, 0, 1e-15);
    k.joint[1].at = k.joint[0].at;                  /* crank of length 0: its next joint decides */
    CHECK_NEAR(lw_linkage_posture_input(&k, 0), 0, 0, 0);
    add_joint(&k, LW_JOINT_GEAR, 1, 2, 9, 9);       /* a contact moves on the link: passed over */
    add_joint(&k, LW_JOINT_REVOLUTE, 1, 2, -1, 0);
    CHECK_NEAR(lw_linkage_posture_input(&k, 0), LW_PI, 0, 0);
}

TEST(slide_lines_give_the_direction_too)
{
    lw_linkage k = four_bar();
    k.joint[1].kind = LW_JOINT_SLIDER;
    k.joint[1].along = lw_v2(0.6, -0.8);
    CHECK_NEAR(lw_linkage_posture_input(&k, 0), atan2(-0.8, 0.6), 0, 0);
    CHECK_NEAR(lw_linkage_posture_input(&k, 1), 0, 0, 0);                       /* a slider: 0         */
    k.joint[1].kind = LW_JOINT_SLOT;                /* the crank carries the slot ...                  */
    CHECK_NEAR(lw_linkage_posture_input(&k, 0), atan2(-0.8, 0.6), 0, 0);
    k.joint[1].link[0] = 2;                         /* ... or the pin in it                            */
    k.joint[1].link[1] = 1;
    CHECK_NEAR(lw_linkage_posture_input(&k, 0), LW_PI/2, 0, 1e-15);
}

TEST(a_link_with_one_joint_points_to_its_tracer)
{
    lw_linkage k = { .units = lw_units_si() };
    add_link(&k, "ground");
    add_link(&k, "pendulum");
    add_joint(&k, LW_JOINT_REVOLUTE, 1, 0, 1, 1);
    CHECK_NEAR(lw_linkage_posture_input(&k, 0), 0, 0, 0);
    k.n_tracer = 1;
    k.tracer[0].link = 1;
    k.tracer[0].at = lw_v2(1, 0);
    CHECK_NEAR(lw_linkage_posture_input(&k, 0), -LW_PI/2, 0, 1e-15);
}

/* 300 pendulums of pins, sliders and slots, some with a second joint or tracers: all inputs at once are those asked one by one. */
TEST(many_inputs_at_once)
{
    enum { N = 300 };
    OWN(lw_assembly) a = { .n_link = N + 1, .n_joint = 2*N, .n_input = N, .n_tracer = N, .units = lw_units_si() };
    bool given[N];
    lw_rng r = check_rng(0);
    a.link_name = calloc(a.n_link, sizeof *a.link_name);
    a.joint = calloc(a.n_joint, sizeof *a.joint);
    a.input = calloc(a.n_input, sizeof *a.input);
    a.tracer = calloc(a.n_tracer, sizeof *a.tracer);
    for (int i = 0; i < 2*N; i++) {
        lw_joint *j = &a.joint[i];
        bool slides = i >= N && lw_rng_bits(&r)%2;
        snprintf(j->name, sizeof j->name, "J%d", i);
        j->kind = slides ? lw_rng_bits(&r)%2 ? LW_JOINT_SLIDER : LW_JOINT_SLOT : LW_JOINT_REVOLUTE;
        j->link[0] = i < N ? (int)(lw_rng_bits(&r)%(unsigned)(i + 1)) : (int)(lw_rng_bits(&r)%N);
        j->link[1] = i < N ? i + 1 : j->link[0] + 1 + (int)(lw_rng_bits(&r)%(unsigned)(N - j->link[0]));
        j->at = lw_v2(lw_rng_normal(&r), lw_rng_normal(&r));
        j->along = slides ? lw_v2_polar(1, lw_rng_normal(&r)) : lw_v2(0, 0);
    }
    for (int i = 0; i <= N; i++)
        snprintf(a.link_name[i], sizeof a.link_name[i], "L%d", i);
    for (int i = 0; i < N; i++) {
        given[i] = i % 5 == 0;
        a.input[i] = (lw_input){ .joint = i, .value = 99 };
        snprintf(a.tracer[i].name, sizeof a.tracer[i].name, "P%d", i);
        a.tracer[i].link = (int)(lw_rng_bits(&r)%(N + 1));
        a.tracer[i].at = lw_v2(lw_rng_normal(&r), lw_rng_normal(&r));
    }
    CHECK_OK(lw_assembly_check(&a, &check_error));
    CHECK_INT(lw_assembly_set_inputs(&a, given), LW_OK);
    for (int i = 0; i < N; i++)
        CHECK_NEAR(a.input[i].value, given[i] ? 99 : lw_assembly_posture_input(&a, i), 0, 0);
    a.input[N - 1].joint = 17;
    CHECK_FAILS(lw_assembly_check(&a, &check_error), LW_E_ARG, "joint \"J17\" is driven twice");
}
