/* Linkages in JSON: read, written, read again; every fault with its place. */
#include "base/file.h"
#include "grammar/linkage/linkage.h"
#include "tests/check.h"

/* The example of docs/notation.md. */
static const char example[] =
    "{\n"
    "  \"linkwright\": 1,\n"
    "  \"name\": \"offset slider-crank\",\n"
    "  \"units\": {\"length\": \"mm\", \"angle\": \"deg\"},\n"
    "  \"links\": [\"ground\", \"crank\", \"coupler\", \"slider\"],\n"
    "  \"ground\": \"ground\",\n"
    "  \"joints\": [\n"
    "    {\"name\": \"A\", \"kind\": \"r\", \"links\": [\"ground\", \"crank\"], \"at\": [0, 0]},\n"
    "    {\"name\": \"B\", \"kind\": \"r\", \"links\": [\"crank\", \"coupler\"], \"at\": [0, 30]},\n"
    "    {\"name\": \"C\", \"kind\": \"r\", \"links\": [\"coupler\", \"slider\"], \"at\": [80, 10]},\n"
    "    {\"name\": \"D\", \"kind\": \"t\", \"links\": [\"ground\", \"slider\"], \"at\": [80, 10], \"along\": [1, 0]}\n"
    "  ],\n"
    "  \"input\": {\"joint\": \"A\", \"value\": 90, \"first\": 0, \"last\": 180},\n"
    "  \"tracers\": [\n"
    "    {\"name\": \"P\", \"link\": \"coupler\", \"at\": [40, 45], \"angle\": -14}\n"
    "  ]\n"
    "}\n";

static lw_status read(const char *text, lw_linkage *k, lw_error *e)
{
    size_t n = strlen(text);
    FREED char *copy = malloc(n + 1);                       /* exact size, no terminator: a step beyond it shows */
    memcpy(copy, text, n);
    memset(e, 0, sizeof *e);
    lw_status s = lw_linkage_read(copy, n, "k.json", k, e);
    return s;
}

TEST(the_example)
{
    lw_linkage k;
    CHECK_OK(read(example, &k, &check_error));
    CHECK_TEXT(k.name, "offset slider-crank");
    CHECK_INT(k.n_link, 4);
    CHECK_INT(k.n_joint, 4);
    CHECK_TEXT(k.link_name[3], "slider");
    CHECK_TEXT(k.joint[3].name, "D");
    CHECK_INT(k.joint[3].kind, LW_JOINT_SLIDER);
    CHECK_INT(k.joint[3].link[1], 3);
    CHECK_NEAR(k.joint[2].at.x, 0.08, 0, 1e-15);
    CHECK_NEAR(k.joint[3].along.x, 1, 0, 0);
    CHECK_NEAR(k.input[0].value, LW_PI/2, 0, 1e-15);
    CHECK_NEAR(k.input[0].last, LW_PI, 0, 1e-15);
    CHECK_NEAR(k.tracer[0].angle, -14*LW_PI/180, 0, 1e-15);
    CHECK_INT(k.tracer[0].link, 2);
    CHECK_TEXT(k.units.length, "mm");
    CHECK_INT(lw_linkage_mobility(&k), 1);
}

TEST(the_example_is_written_as_it_was)
{
    lw_linkage k;
    CHECK_OK(read(example, &k, &check_error));
    FREED char *text = lw_linkage_write(&k, 2);
    CHECK_TEXT(text, example);
}

TEST(the_manual_shows_it)
{
    FREED char *manual = NULL;
    size_t size;
    CHECK_INT(lw_file_read("docs/notation.md", &manual, &size, NULL), LW_OK);
    CHECK_HAS(manual, example);
}

TEST(what_may_be_left_out)
{
    lw_linkage k;
    CHECK_INT(read("{\"linkwright\":1,\"joints\":[{\"name\":\"A\",\"links\":[\"bar\",\"ground\"],\"at\":[1,2]}],"
                   "\"x-mine\":[1,{\"a\":null}],\"fit\":{\"anything\":{\"error\":1e-3}},\"$schema\":\"s\"}", &k, &check_error),
              LW_OK);
    CHECK_INT(k.n_link, 2);
    CHECK_INT(k.ground, 1);
    CHECK_TEXT(k.link_name[0], "bar");
    CHECK_INT(k.joint[0].kind, LW_JOINT_REVOLUTE);
    CHECK_INT(k.n_input, 0);
    CHECK_INT(k.n_tracer, 0);
    CHECK_TEXT(k.units.length, "");
    CHECK_TEXT(k.units.angle, "rad");
    CHECK_NEAR(k.joint[0].at.y, 2, 0, 0);
}

TEST(links_without_a_list_follow_the_joints)
{
    lw_linkage k;
    CHECK_OK(read("{\"linkwright\":1,\"ground\":\"frame\",\"joints\":[{\"name\":\"A\",\"links\":[\"a\",\"b\"],\"at\":[1,2]},"
                  "{\"name\":\"B\",\"links\":[\"frame\",\"a\"],\"at\":[1,2]}]}", &k, &check_error));
    CHECK_TEXT(k.link_name[0], "frame");
    CHECK_TEXT(k.link_name[1], "a");
    CHECK_TEXT(k.link_name[2], "b");
    CHECK_INT(k.ground, 0);
}

TEST(links_may_be_objects)
{
    lw_linkage k;
    CHECK_OK(read("{\"linkwright\":1,\"links\":[{\"name\":\"a\",\"x-mass\":2},\"ground\"],\"joints\":["
                  "{\"name\":\"A\",\"links\":[\"a\",\"ground\"],\"at\":[1,2]}]}", &k, &check_error));
    CHECK_TEXT(k.link_name[0], "a");
    CHECK_INT(k.ground, 1);
}

TEST(other_kinds_and_several_inputs)
{
    lw_linkage k;
    CHECK_INT(read("{\"linkwright\":1,\"units\":{\"angle\":\"deg\",\"length\":\"cm\"},\"joints\":["
                   "{\"name\":\"A\",\"links\":[\"ground\",\"a\"],\"at\":[0,0]},"
                   "{\"name\":\"B\",\"kind\":\"p\",\"links\":[\"a\",\"b\"],\"at\":[3,4],\"along\":[3,4]},"
                   "{\"name\":\"C\",\"kind\":\"t\",\"links\":[\"ground\",\"b\"],\"at\":[0,0],\"angle\":90},"
                   "{\"name\":\"D\",\"kind\":\"g\",\"links\":[\"a\",\"b\"],\"at\":[1,1],\"ratio\":-2.5}],"
                   "\"inputs\":[{\"joint\":\"A\"},{\"joint\":\"C\",\"value\":5,\"first\":-1,\"last\":2}]}", &k, &check_error),
              LW_OK);
    CHECK_POINT(k.joint[1].along, 0.6, 0.8, 0, 0);
    CHECK_NEAR(k.joint[2].along.x, 0, 1e-16, 0);
    CHECK_NEAR(k.joint[2].along.y, 1, 0, 0);
    CHECK_NEAR(k.joint[3].ratio, -0.025, 0, 1e-15);              /* b is a rack: cm per rad */
    CHECK_INT(k.n_input, 2);
    CHECK_NEAR(k.input[0].value, atan2(0.8, 0.6), 0, 1e-15);     /* along the slot that the link carries */
    CHECK_NEAR(k.input[1].value, 0.05, 0, 1e-15);
    CHECK_NEAR(k.input[1].first, -0.01, 0, 1e-15);
}

/* The contact of gears and the place of a weld may be left out. */
TEST(gears_and_welds_find_their_place)
{
    lw_linkage k;
    CHECK_SILENT(read("{\"linkwright\":1,\"units\":{\"length\":\"mm\"},\"joints\":["
                      "{\"name\":\"A\",\"links\":[\"ground\",\"a\"],\"at\":[10,0]},"
                      "{\"name\":\"B\",\"links\":[\"ground\",\"b\"],\"at\":[40,0]},"
                      "{\"name\":\"G\",\"kind\":\"g\",\"links\":[\"a\",\"b\"],\"ratio\":-0.5},"
                      "{\"name\":\"C\",\"kind\":\"t\",\"links\":[\"ground\",\"rack\"],\"at\":[0,0],\"angle\":0},"
                      "{\"name\":\"H\",\"kind\":\"g\",\"links\":[\"b\",\"rack\"],\"ratio\":20},"
                      "{\"name\":\"W\",\"kind\":\"f\",\"links\":[\"rack\",\"tool\"]}],\"input\":{\"joint\":\"A\"}}", &k, &check_error));
    CHECK_NEAR(k.joint[2].at.x, 0.02, 0, 1e-15);             /* w_b = -w_a/2: radii 10 and 20 */
    CHECK_NEAR(k.joint[2].at.y, 0, 1e-18, 0);
    CHECK_NEAR(k.joint[4].ratio, 0.02, 0, 1e-15);
    CHECK_NEAR(k.joint[4].at.x, 0.04, 0, 1e-15);             /* below the pinion the rack goes with it */
    CHECK_NEAR(k.joint[4].at.y, -0.02, 0, 1e-15);
    CHECK_NEAR(k.joint[5].at.x, 0, 1e-18, 0);
    CHECK_INT(lw_linkage_mobility(&k), 1);
    FREED char *text = lw_linkage_write(&k, 0);
    CHECK_HAS(text, "\"ratio\": 20}");
}

/* ---- round trips ------------------------------------------------------------------------------ */

static double any_number(lw_rng *r)
{
    return lw_rng_normal(r)*pow(10, floor(lw_rng_range(r, -9, 10)));
}

/* A random tree of links with random joints: not a mechanism that moves, but one that can be written. */
static void draw_linkage(lw_rng *r, lw_linkage *k)
{
    static const char kinds[] = "rtpg";
    *k = (lw_linkage){ .units = lw_units_si() };
    snprintf(k->name, sizeof k->name, "\"q\\uote\" / %g", lw_rng_uniform(r));
    k->n_link = 2 + (int)(lw_rng_bits(r)%(LW_LINK_MAX - 1));
    k->ground = (int)(lw_rng_bits(r)%(uint64_t)k->n_link);
    k->n_joint = k->n_link - 1 + (int)(lw_rng_bits(r)%(uint64_t)(LW_JOINT_MAX - k->n_link + 2));
    for (int i = 0; i < k->n_link; i++)
        snprintf(k->link_name[i], LW_NAME_SIZE, i%2 ? "link \xc3\xa9 %d" : "a\"b\\%d", i);
    for (int i = 0; i < k->n_joint; i++) {
        lw_joint *j = &k->joint[i];
        int a = i < k->n_link - 1 ? i + 1 : 1, b = (int)(lw_rng_bits(r)%(uint64_t)a);
        *j = (lw_joint){ .kind = (lw_joint_kind)kinds[i == 0 ? 0 : lw_rng_bits(r)%4], .link = { a, b },
                         .at = { any_number(r), any_number(r) } };
        if (j->kind == LW_JOINT_SLIDER || j->kind == LW_JOINT_SLOT)
            j->along = lw_v2_polar(1, lw_rng_range(r, -4, 4));
        if (j->kind == LW_JOINT_GEAR)
            j->ratio = any_number(r);
        snprintf(j->name, LW_NAME_SIZE, "J%d", i);
        if (k->n_input < LW_INPUT_MAX && strchr("rt", (char)j->kind))
            k->input[k->n_input++] = (lw_input){ .joint = i, .value = any_number(r), .first = any_number(r),
                                                   .last = any_number(r) };
    }
    k->n_tracer = (int)(lw_rng_bits(r)%(LW_TRACER_MAX + 1));
    for (int i = 0; i < k->n_tracer; i++) {
        k->tracer[i] = (lw_tracer){ .link = i%k->n_link, .at = { any_number(r), any_number(r) },
                                    .angle = any_number(r) };
        snprintf(k->tracer[i].name, LW_NAME_SIZE, "T%d", i);
    }
}

/* Fields compared by ==: the structures have padding.  allowed: relative error of the numbers. */
static void check_same(const lw_linkage *a, const lw_linkage *b, double allowed)
{
    CHECK_TEXT(a->name, b->name);
    CHECK(a->n_link == b->n_link && a->n_joint == b->n_joint && a->n_input == b->n_input &&
          a->n_tracer == b->n_tracer && a->ground == b->ground);
    for (int i = 0; i < a->n_link; i++)
        CHECK_TEXT(a->link_name[i], b->link_name[i]);
    for (int i = 0; i < a->n_joint; i++) {
        const lw_joint *p = &a->joint[i], *q = &b->joint[i];
        CHECK_TEXT(p->name, q->name);
        CHECK(p->kind == q->kind && p->link[0] == q->link[0] && p->link[1] == q->link[1]);
        CHECK(p->along.x == q->along.x && p->along.y == q->along.y && p->ratio == q->ratio);
        CHECK_POINT(p->at, q->at.x, q->at.y, 0, allowed);
    }
    for (int i = 0; i < a->n_input; i++) {
        CHECK_INT(a->input[i].joint, b->input[i].joint);
        CHECK_NEAR(a->input[i].value, b->input[i].value, 0, allowed);
        CHECK_NEAR(a->input[i].first, b->input[i].first, 0, allowed);
        CHECK_NEAR(a->input[i].last, b->input[i].last, 0, allowed);
    }
    for (int i = 0; i < a->n_tracer; i++) {
        CHECK_TEXT(a->tracer[i].name, b->tracer[i].name);
        CHECK_INT(a->tracer[i].link, b->tracer[i].link);
        CHECK_NEAR(a->tracer[i].at.x, b->tracer[i].at.x, 0, allowed);
        CHECK_NEAR(a->tracer[i].angle, b->tracer[i].angle, 0, allowed);
    }
}

static void round_trip(const lw_linkage *k, double allowed)
{
    lw_linkage back;
    for (int indent = 0; indent <= 4; indent += 2) {
        FREED char *text = lw_linkage_write(k, indent);
        CHECK(text != NULL);
        CHECK_SILENT(read(text, &back, &check_error));
        check_same(k, &back, allowed);
        CHECK(indent > 0 || !strchr(text, '\n'));
    }
}

TEST(in_si_the_bits_come_back)
{
    lw_linkage k;
    lw_rng r = check_rng(0);
    for (int trial = 0; trial < 200; trial++) {
        draw_linkage(&r, &k);
        round_trip(&k, 0);
        lw_units_set_length(&k.units, "m");
        round_trip(&k, 0);
    }
}

/* In other units one rounding by the division and one by the product: 2 units in the last place. */
TEST(in_other_units_to_rounding)
{
    static const char *const lengths[] = { "mm", "um", "in", "ft", "km" }, *const angles[] = { "deg", "turn" };
    lw_linkage k;
    lw_rng r = check_rng(1);
    for (int trial = 0; trial < 100; trial++) {
        draw_linkage(&r, &k);
        lw_units_set_length(&k.units, lengths[trial%5]);
        lw_units_set_angle(&k.units, angles[trial%2]);
        round_trip(&k, 0x1p-51);
    }
}

/* ---- faults ------------------------------------------------------------------------------------ */

/* The example with `from` replaced by `to`, in which '^' is left out and marks a place. */
static const char *changed(const char *from, const char *to, long *line, long *column)
{
    static char text[4096];
    const char *at = strstr(example, from), *mark = strchr(to, '^');
    CHECK(at != NULL && mark != NULL);
    if (!at || !mark)
        return "";
    int n = snprintf(text, sizeof text, "%.*s%.*s", (int)(at - example), example, (int)(mark - to), to);
    *line = *column = 1;
    for (int i = 0; i < n; i++) {
        ++*column;
        if (text[i] == '\n') {
            ++*line;
            *column = 1;
        }
    }
    snprintf(text + n, sizeof text - (size_t)n, "%s%s", mark + 1, at + strlen(from));
    return text;
}

TEST(every_fault_has_its_place)
{
    static const struct { const char *from, *to, *part; } faults[] = {
        { "{\n  \"linkwright\": 1,\n", "^{\n", "\"linkwright\": 1 is missing" },
        { "\"linkwright\": 1", "\"linkwright\": ^2", "notation 2 is not known" },
        { "\"linkwright\": 1", "\"linkwright\": ^\"1\"", "a number is expected here" },
        { "\"ground\": \"ground\"", "\"ground\": ^\"Ground\"", "did you mean \"ground\"" },
        { "\"ground\": \"ground\",", "^\"gruond\": \"ground\",", "did you mean \"ground\"" },
        { "\"mm\"", "^\"furlong\"", "known are m, mm" },
        { "\"deg\"", "^\"mm\"", "known are rad, deg" },
        { "\"units\": {\"length\"", "\"units\": {^\"lenght\"", "units.lenght: this key is not known" },
        { "\"coupler\", \"slider\"],\n", "\"coupler\", \"slider\", ^\"crank\"],\n", "links 2 and 5 are both called" },
        { "\"slider\"],\n", "^\"\"],\n", "links[3]: an empty name" },
        { "\"slider\"],\n", "^7],\n", "links[3]: a text \"...\" is expected here, this is a number" },
        { "\"slider\"],\n", "\"slider\", ^\"loose\"],\n", "ties link \"loose\" to the ground" },
        { "[\"crank\", \"coupler\"]", "[\"crank\", ^\"copuler\"]", "joints[1].links[1]: there is no link" },
        { "{\"name\": \"B\", \"kind\": \"r\", \"links\": [\"crank\", \"coupler\"]",
          "^{\"name\": \"B\", \"kind\": \"r\", \"links\": [\"crank\", \"crank\"]", "joins link \"crank\" to itself" },
        { "[\"crank\", \"coupler\"]", "^[\"crank\"]", "a list of 2 is expected here, this one has 1" },
        { "\"kind\": \"t\"", "\"kind\": ^\"s\"", "unknown kind \"s\"" },
        { ", \"along\": [1, 0]", ", \"ratio\": ^1, \"along\": [1, 0]", "only gears" },
        { "\"kind\": \"t\", \"links\": [\"ground\", \"slider\"], \"at\": [80, 10], \"along\": ",
          "\"kind\": \"r\", \"links\": [\"ground\", \"slider\"], \"at\": [80, 10], \"along\": ^", "has no direction" },
        { "{\"name\": \"D\", \"kind\": \"t\", \"links\": [\"ground\", \"slider\"], \"at\": [80, 10], \"along\": [1, 0]}",
          "^{\"name\": \"D\", \"kind\": \"t\", \"links\": [\"ground\", \"slider\"], \"at\": [80, 10]}",
          "slides: give \"along\"" },
        { "\"along\": [1, 0]", "\"along\": ^[0, 0]", "a direction needs a length" },
        { "\"along\": [1, 0]", "\"along\": [1, 0], \"angle\": ^0", "given twice" },
        { "\"at\": [0, 30]", "\"at\": ^[0, 30, 1]", "list of 2 is expected here, this one has 3" },
        { "\"at\": [0, 30]", "\"at\": [0, ^\"30\"]", "joints[1].at[1]: a number is expected" },
        { "\"at\": [0, 30]", "\"at\": [0, ^1e200]", "too large" },
        { "\"at\": [0, 30]", "\"at\": [0, 30], \"ratio\": ^2", "only gears" },
        { "{\"name\": \"B\", \"kind\": \"r\"", "^{\"name\": \"B\", \"kind\": \"g\"", "gear \"B\" has no ratio" },
        { "\"kind\": \"r\", \"links\": [\"crank\", \"coupler\"]",
          "\"kind\": \"g\", \"ratio\": ^0, \"links\": [\"coupler\", \"ground\"]", "other than 0" },
        { "{\"name\": \"B\", \"kind\": \"r\", \"links\": [\"crank\", \"coupler\"], \"at\": [0, 30]}",
          "^{\"name\": \"B\", \"kind\": \"g\", \"ratio\": 1, \"links\": [\"crank\", \"coupler\"]}", "no link carries both" },
        { "{\"name\": \"B\"", "^{\"x-name\": \"B\"", "\"name\" is missing" },
        { "{\"name\": \"B\"", "^{\"name\": \"A\"", "joints 1 and 2 are both called \"A\"" },
        { "\"name\": \"B\"", "\"name\": ^\"0123456789012345678901234567890B\"", "has 32 bytes; at most 31" },
        { "{\"joint\": \"A\"", "{\"joint\": ^\"Q\"", "input.joint: there is no joint \"Q\"" },
        { "{\"joint\": \"A\"", "{^\"join\": \"A\"", "did you mean \"joint\"" },
        { "\"value\": 90", "\"value\": ^null", "a number is expected here, this is true, false or null" },
        { "{\"joint\": \"A\", \"value\": 90, \"first\": 0, \"last\": 180", "^{\"joint\": \"A\", \"first\": 0",
          "\"first\" and \"last\" bound the motion together" },
        { "\"input\": {\"joint\"", "\"inputs\": ^[], \"input\": {\"joint\"", "keep one" },
        { "\"input\": {", "\"inputs\": [{\"joint\": \"A\"}, ^{\"joint\": \"A\"}], \"x-\": {", "driven twice" },
        { "\"link\": \"coupler\"", "\"link\": ^\"couple\"", "tracers[0].link: there is no link" },
        { "\"name\": \"P\"", "\"name\": \"P\", ^\"mass\": 1", "tracers[0].mass: this key is not known" },
        { "\"name\": \"offset",
          "\"name\": ^\"an exceedingly long title that nobody could ever want to type for an offset", "at most 63" },
        { "\"joints\": [", "\"joints\": [^[],", "an object { ... } is expected here, this is a list" },
        { "\"joints\": [", "\"joints\": ^3, \"x-\": [", "a list [ ... ] is expected" },
    };
    for (size_t i = 0; i < sizeof faults/sizeof *faults; i++) {
        lw_linkage k;
        lw_error e;
        long line = 0, column = 0;
        CHECK_INT(read(changed(faults[i].from, faults[i].to, &line, &column), &k, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, faults[i].part);
        CHECK_TEXT(e.file, "k.json");
        CHECK_INT(e.line, line);
        CHECK_INT(e.column, column);
    }
}

TEST(what_is_no_json)
{
    static const struct { const char *text; long line; const char *part; } cases[] = {
        { "", 1, "nothing is in this file" }, { " \n\t", 1, "nothing is in this file" },
        { "x", 1, "not JSON" }, { "{\n\"a\": NaN}", 2, "not JSON" }, { "{\n\n\"a\": Infinity}", 3, "not JSON" },
        { "[1, 2", 1, "not JSON" }, { "{\"linkwright\": 1} {}", 1, "not JSON" },
        { "{\"a\": 1,\n \"a\": 2}", 2, "duplicate" }, { "{\"a\": 1e999}", 1, "too large" },
        { "{\"a\": \"b\\u0000c\"}", 1, "not JSON" }, { "{\"a\": \"\xff\"}", 1, "no part of UTF-8" },
        { "{\"linkwright\": 1,\n\"name\": \"a\\u007fb\"}", 2, "a control character" },
        { "[]", 1, "an object { ... } is expected" }, { "null", 1, "'{' or '[' is expected" },
        { "{\"linkwright\": 1}", 1, "\"joints\" is missing" },
        { "{\"linkwright\": 1, \"joints\": []}", 1, "list of at least 1" },
        { "{\"linkwright\": 1, \"joints\": [{\"name\":\"A\",\"links\":[\"a\",\"b\"],\"at\":[0,0]}]}", 1,
          "\"ground\" is missing" },
    };
    for (size_t i = 0; i < sizeof cases/sizeof *cases; i++) {
        lw_linkage k;
        lw_error e;
        CHECK_INT(read(cases[i].text, &k, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, cases[i].part);
        CHECK_INT(e.line, cases[i].line);
        CHECK(e.column >= 1);
    }
}

/* The place is the first byte of what cannot stand there. */
TEST(faults_of_syntax_have_their_place)
{
    static const struct { const char *text; long line, column; } cases[] = {
        { "{\"a\": NaN}", 1, 7 }, { "{\n  \"a\" 1}", 2, 7 }, { "{\n\"a\": [1,\n ]}", 3, 2 },
        { "{\"a\": 1,\n   \"a\": 2}", 2, 4 }, { "\xef\xbb\xbf{\"a\": x}", 1, 10 }, { "{\"a\": tru}", 1, 7 },
        { "{\"a\": 1}\n x", 2, 2 }, { "{\"a\": 01}", 1, 7 }, { "{\"a\": [", 1, 8 },
    };
    for (size_t i = 0; i < sizeof cases/sizeof *cases; i++) {
        lw_linkage k;
        lw_error e;
        CHECK_INT(read(cases[i].text, &k, &e), LW_E_NOTATION);
        CHECK_INT(e.line, cases[i].line);
        CHECK_INT(e.column, cases[i].column);
    }
}

TEST(too_many_of_everything)
{
    FREED char *text = malloc(100000);
    lw_linkage k;
    int n = sprintf(text, "{\"linkwright\":1,\"joints\":[");
    for (int i = 0; i < 40; i++)
        n += sprintf(text + n, "%s{\"name\":\"J%d\",\"links\":[\"ground\",\"l%d\"],\"at\":[0,0]}", i ? "," : "", i, i);
    sprintf(text + n, "]}");
    CHECK_FAILS(read(text, &k, &check_error), LW_E_NOTATION, "41 links, 40 joints, 0 inputs and 0 tracers are too many here: at most 32, 64, 8 and 16");
    n = sprintf(text, "{\"linkwright\":1,\"joints\":[");
    for (int i = 0; i < 65; i++)
        n += sprintf(text + n, "%s{\"name\":\"J%d\",\"links\":[\"ground\",\"l\"],\"at\":[0,0]}", i ? "," : "", i);
    sprintf(text + n, "]}");
    CHECK_FAILS(read(text, &k, &check_error), LW_E_NOTATION, "2 links, 65 joints");
    memset(text, '[', 99999);
    text[99999] = '\0';
    CHECK_FAILS(read(text, &k, &check_error), LW_E_NOTATION, "more than 2048");
}

TEST(a_byte_order_mark_is_skipped)
{
    static char text[sizeof example + 8];
    lw_linkage k;
    lw_error e;
    snprintf(text, sizeof text, "\xef\xbb\xbf%s", example);
    CHECK_INT(read(text, &k, &e), LW_OK);
    text[strlen(text) - 5] = '!';
    CHECK_INT(read(text, &k, &e), LW_E_NOTATION);
    CHECK_INT(e.line, 16);
}

/* No cut and no changed byte may do more harm than an error; what is read passes the check. */
TEST(any_bytes_are_survived)
{
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 20000; trial++) {
        char text[sizeof example];
        lw_linkage k;
        lw_error e = { 0 };
        size_t n = trial%4 ? sizeof example - 1 : (size_t)(lw_rng_bits(&r)%sizeof example);
        memcpy(text, example, sizeof example);
        for (int i = 0; i < trial%4; i++)
            text[lw_rng_bits(&r)%(sizeof example - 1)] = i%2 ? (char)lw_rng_bits(&r)
                                                             : example[lw_rng_bits(&r)%sizeof example];
        lw_status s = lw_linkage_read(text, n, "k.json", &k, &e);
        CHECK(s == LW_OK || s == LW_E_NOTATION);
        CHECK(s == LW_OK ? lw_linkage_check(&k, NULL) == LW_OK : e.text[0] && e.line > 0 && e.column > 0);
    }
}
