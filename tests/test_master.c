/* test_master.c - master files: units, formulas, parts, repeats, ports, views; models against hand-written ones; what
 * is refused, with its place. */
#include "base/file.h"
#include "base/vec2.h"
#include "grammar/family/master.h"
#include "grammar/model/model.h"
#include "tests/json_text.h"

static lw_error error;

static lw_variant *variant_of(const char *text, lw_master **m)
{
    lw_variant *v = NULL;
    error = (lw_error){ 0 };
    char *json = json_quotes(strdup(text));
    lw_status s = lw_master_read(json, strlen(json), "f", m, &error);
    free(json);
    if (s != LW_OK) {
        printf("%ld:%ld: %s\n", error.line, error.column, error.text);
        CHECK(!"the master is read");
        return NULL;
    }
    CHECK_INT(lw_variant_create(*m, &v), LW_OK);
    return v;
}

static void done(lw_variant *v, lw_master *m)
{
    lw_variant_free(v);
    lw_master_free(m);
}

/* ---- units and formulas -------------------------------------------------------------------------- */

static const char plain_master[] =
    "{'linkwright': 1, 'parameters': {'l': {'value': 350, 'unit': 'mm'}, 'n': 3, 'q': {'value': 30, 'unit': 'deg'},\n 'name': 'long', 'load': true, 'm': "
    "{'value': 2, 'unit': 'kg'}}, 'model': {}}";

/* Values worked out by hand; exact, because factors of units are kept as whole numbers. */
TEST(values)
{
    static const struct { const char *formula; double value; const char *unit; } rows[] = {
        { "l", 0.35, "m" }, { "l as mm", 350, "mm" }, { "2*l + 50 mm as mm", 750, "mm" }, { "l/2 as cm", 17.5, "cm" },
        { "l^2 as mm^2", 122500, "mm^2" }, { "q", LW_PI/6, "rad" }, { "4*q as deg", 120, "deg" }, { "1 in as mm", 25.4,
             "mm" },
        { "n^2 - 1", 8, "1" }, { "-2^2", -4, "1" }, { "2^-1", 0.5, "1" }, { "2^3^2", 512, "1" }, { "10 %", 0.1, "1" },
        { "7850 [kg/m^3]*l^3 as kg", 7850*0.35*0.35*0.35, "kg" }, { "sqrt(l^2 + l^2)/l", 1.4142135623730951, "1" },
        { "min(l, 20 cm, 1 m) as mm", 200, "mm" }, { "standard(33 mm, 25 mm, 40 mm, 32 mm, 50 mm) as mm", 40, "mm" },
        { "if(n > 2 and not load, 1, 2)", 2, "1" }, { "if(name == 'long', 5, 6)", 5, "1" }, { "if(l < 35.1 cm, 1, 0)",
             1, "1" },
        { "floor(2.7) + ceil(2.1) + round(2.5)", 8, "1" }, { "mod(-1, 3)", 2, "1" }, { "hypot(3 m, 400 cm)", 5, "m" },
        { "atan2(l, l) as deg", 45, "deg" }, { "sin(30 deg)", 0.5, "1" }, { "l*q", 0.35*LW_PI/6, "m rad" },
        { "60 rpm as rad/s", 2*LW_PI, "rad/s" }, { "9.81 [m/s^2]*m", 19.62, "N" }, { "2 kN/(1 [m^2]) as kPa", 2,
             "kPa" },
        { "1 bar as Pa", 1e5, "Pa" }, { "(m*l)/m as mm", 350, "mm" }, { "abs(-l) + 0*l as mm", 350, "mm" } };
    lw_master *m;
    lw_variant *v = variant_of(plain_master, &m);
    for (size_t i = 0; v && i < sizeof rows/sizeof *rows; i++) {
        double x = NAN;
        char unit[64] = "";
        CHECK_INT(lw_variant_quantity(v, rows[i].formula, &x, unit, &error), LW_OK);
        if (fabs(x - rows[i].value) > 4e-16*fabs(rows[i].value) || strcmp(unit, rows[i].unit) != 0)
            printf("%s\n", rows[i].formula);
        CHECK_NEAR(x, rows[i].value, 4e-16*fabs(rows[i].value), 0);
        CHECK_TEXT(unit, rows[i].unit);
    }
    done(v, m);
}

TEST(wrong_formulas)
{
    static const struct { const char *formula, *says; long column; } rows[] = {
        { "l + m", "[m] and [kg] cannot be added", 3 }, { "l + 5", "[m] and [plain number] cannot be added", 3 },
        { "l < m", "[m] and [kg] cannot be compared", 3 }, { "sin(l)", "a plain number or an angle is expected", 1 },
        { "exp(m)", "a plain number is expected", 1 }, { "sqrt(l)", "[m] has no power 0.5", 1 }, { "2^l",
             "plain number", 2 },
        { "q + 1", "[rad] and [plain number]", 3 }, { "l as kg", "the units do not fit", 1 }, { "ll + 1",
             "did you mean l?", 1 },
        { "squrt(2)", "did you mean sqrt?", 1 }, { "2 mn", "did you mean", 3 }, { "(1 + 2", "')' is expected", 7 },
        { "1/0", "no finite number", 1 }, { "if(n, 1, 2)", "if needs a condition", 1 }, { "n and load",
             "a condition is expected", 3 },
        { "hypot(1)", "something is missing", 8 }, { "abs(1, 2)", "one too many", 8 }, { "'text", "no closing '", 1 },
        { "name + 1", "[text] and [plain number]", 6 }, { "2 [kg", "no ]", 3 }, { "1 + ", "a number, a word", 5 },
        { "standard(1 m, 2 mm)", "no standard size", 1 }, { "round(l)", "divide it by a unit", 1 } };
    lw_master *m;
    lw_variant *v = variant_of(plain_master, &m);
    for (size_t i = 0; v && i < sizeof rows/sizeof *rows; i++) {
        double x;
        error = (lw_error){ 0 };
        CHECK_INT(lw_variant_quantity(v, rows[i].formula, &x, NULL, &error), LW_E_NOTATION);
        CHECK_HAS(error.text, rows[i].says);
        if (error.column != rows[i].column)
            printf("%s: %s\n", rows[i].formula, error.text);
        CHECK_INT(error.column, rows[i].column);
    }
    done(v, m);
}

/* ---- models ------------------------------------------------------------------------------------------ */

/* A chain of three bars, each laid on the hand of the one before, with a turn; a hand-written model beside. */
TEST(parts)
{
    static const char text[] =
        "{'linkwright': 1, 'family': 'chains',\n"
        " 'parameters': {'n': {'value': 3, 'whole': true}, 'l': {'value': 100, 'unit': 'mm'}, 'held': true},\n"
        " 'parts': {'bar': {'parameters': {'length': {'value': 50, 'unit': 'mm'}, 'on': 'ground'},\n"
        "   'ports': {'foot': {'at': [0, 0]}, 'hand': {'at': ['=length', 0], 'angle': 90}},\n"
        "   'links': [{'name': '{self}', 'mass': '=length/(1 m)*10 kg', 'centre': ['=length/2', 0]}],\n"
        "   'joints': [{'name': 'pin of {self}', 'links': ['{on}', '{self}'], 'at': [0, 0]}]}},\n"
        " 'model': {'name': '{n} bars', 'units': {'length': 'mm', 'angle': 'deg'}, 'links': ['ground'],\n"
        "   'use': [{'part': 'bar', 'name': 'bar 1', 'at': [10, 20], 'with': {'length': '=l'}},\n"
        "     {'repeat': {'i': {'from': 2, 'to': '=n'}}, 'part': 'bar', 'name': 'bar {i}', 'attach': 'foot',\n"
        "      'to': 'bar {i - 1}.hand', 'with': {'length': '=l/i', 'on': 'bar {i - 1}'}}],\n"
        "   'input': {'joint': 'pin of bar 1', 'motion': '{l}*sin(t)', 'when': 'held'},\n"
        "   'springs': [{'when': 'n > 5', 'joint': 'pin of bar 1', 'stiffness': 5}],\n"
        "   'tracers': [{'name': 'tip', 'link': 'bar {n}', 'at': {'port': 'bar {n}.hand'}}]}}";
    static char want[] =
        "{\n  'linkwright': 1,\n  'name': '3 bars',\n  'units': {'length': 'mm', 'angle': 'deg'},\n"
        "  'links': [\n    'ground',\n"
        "    {'name': 'bar 1', 'mass': 1, 'centre': [60, 20]},\n"
        "    {'name': 'bar 2', 'mass': 0.5, 'centre': [110, 45]},\n"
        "    {'name': 'bar 3', 'mass': 0.333333333333333, 'centre': [93.3333333333333, 70]}\n  ],\n"
        "  'input': {'joint': 'pin of bar 1', 'motion': '0.1*sin(t)', 'when': 'held'},\n"
        "  'tracers': [\n    {'name': 'tip', 'link': 'bar 3', 'at': [76.6666666666667, 70]}\n  ],\n"
        "  'joints': [\n"
        "    {'name': 'pin of bar 1', 'links': ['ground', 'bar 1'], 'at': [10, 20]},\n"
        "    {'name': 'pin of bar 2', 'links': ['bar 1', 'bar 2'], 'at': [110, 20]},\n"
        "    {'name': 'pin of bar 3', 'links': ['bar 2', 'bar 3'], 'at': [110, 70]}\n  ]\n}\n";
    lw_master *m;
    lw_variant *v = variant_of(text, &m);
    lw_expansion x;
    if (v && lw_variant_expand(v, &x, &error) == LW_OK) {
        CHECK_TEXT(x.text, json_quotes(want));
        lw_expansion_free(&x);
    } else
        CHECK_TEXT(error.text, "");
    done(v, m);
}

/* Random frames in frames: the place of a point and the direction of a slider against complex numbers. */
TEST(turned_parts)
{
    static const char form[] =
        "{'linkwright': 1, 'parts': {\n"
        "'inner': {'links': ['{self} a'], 'joints': [{'name': '{self} s', 'kind': 't', 'links': ['ground', '{self} a'], 'at': [%.17g, %.17g], 'angle': "
        "%.17g}],\n"
        "  'tracers': [{'name': '{self} p', 'link': '{self} a', 'at': [%.17g, %.17g], 'angle': %.17g}]},\n"
        "'outer': {'use': [{'part': 'inner', 'name': 'x', 'at': [%.17g, %.17g], 'angle': %.17g}]}},\n"
        "'model': {'units': {'angle': 'deg'}, 'links': ['ground'], 'joints': [], 'use': [{'part': 'outer', 'at': [%.17g, %.17g], 'angle': %.17g}]}}";
    static char text[2000];
    lw_rng rng = check_rng(0);
    for (int trial = 0; trial < 200; trial++) {
        double r[12];
        for (int i = 0; i < 12; i++)
            r[i] = (i%3 == 2 ? 400 : 4)*(lw_rng_uniform(&rng) - 0.5);
        if (trial%4 == 0)
            for (int i = 2; i < 12; i += 3)
                r[i] = 30*round(r[i]/30);
        snprintf(text, sizeof text, form, r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8], r[9], r[10], r[11]);
        lw_master *m;
        lw_variant *v = variant_of(text, &m);
        OWN(lw_expansion) x = { 0 };
        OWN(lw_model) model = { 0 };
        if (!v || lw_variant_expand(v, &x, &error) != LW_OK
            || lw_model_read(x.text, x.size, "m", &model, &error) != LW_OK) {
            CHECK_TEXT(error.text, "");
            done(v, m);
            return;
        }
        double a = r[8]*LW_PI/180, b = r[11]*LW_PI/180;
        for (int k = 0; k < 2; k++) {
            double px = r[3*k], py = r[3*k + 1], qx = cos(a)*px - sin(a)*py + r[6], qy = sin(a)*px + cos(a)*py + r[7];
            lw_vec2 at = k ? model.linkage.tracer[0].at : model.linkage.joint[0].at;
            CHECK_POINT(at, cos(b)*qx - sin(b)*qy + r[9], sin(b)*qx + cos(b)*qy + r[10], 1e-13, 0);
        }
        double turn = remainder(model.linkage.tracer[0].angle - (r[5]*LW_PI/180 + a + b), 2*LW_PI);
        CHECK_NEAR(turn, 0, 1e-12, 0);
        done(v, m);
    }
}

/* Spatial parts: only the numbers are looked at.  A turn by 120 degrees about (1, 1, 1) maps x to y, y to z, z to x. */
TEST(spatial_parts)
{
    static const char text[] =
        "{'linkwright': 1, 'parts': {'p': {'links': [{'name': 'a', 'mass': 1, 'centre': [1, 2, 3], 'inertia': [1, 2, 3, 0.1, 0.2, 0.3]}],\n 'joints': "
        "[{'kind': 'r', 'at': [[1, 0, 0]], 'axis': [0, 0, 1]}]}},\n"
        "'model': {'use': [{'part': 'p', 'at': [10, 20, 30], 'axis': [1, 1, 1], 'angle': '=120 deg'}]}}";
    lw_master *m;
    lw_variant *v = variant_of(text, &m);
    lw_expansion x;
    if (v && lw_variant_expand(v, &x, &error) == LW_OK) {
        CHECK_HAS(x.text, "\"centre\": [13, 21, 32]");
        CHECK_HAS(x.text, "\"inertia\": [3, 1, 2, 0.2, 0.3, 0.1]");
        CHECK_HAS(x.text, "\"at\": [[10, 21, 30]]");
        lw_expansion_free(&x);
    } else
        CHECK(!"expands");
    done(v, m);
}

/* The tree is read, the default is the stored model, byte for byte; a place of the model leads back. */
TEST(loaders)
{
    char *text = NULL, *want = NULL;
    size_t size, n;
    lw_master *m = NULL;
    lw_variant *v = NULL;
    OWN(lw_expansion) x = { 0 };
    CHECK_INT(lw_file_read("examples/families/loader.json", &text, &size, &error), LW_OK);
    CHECK_INT(lw_file_read("tests/data/family/loader.json", &want, &n, &error), LW_OK);
    CHECK_INT(lw_master_read(text, size, "loader", &m, &error), LW_OK);
    CHECK_INT(lw_variant_create(m, &v), LW_OK);
    CHECK_INT(lw_variant_expand(v, &x, &error), LW_OK);
    CHECK_TEXT(x.text, want);
    long line = 0, column = 0;
    const char *eye = strstr(x.text, "\"lift eye\"");
    long at = 1, start = 0;
    for (const char *c = x.text; c < eye; c++)
        if (*c == '\n') {
            at++;
            start = c + 1 - x.text;
        }
    CHECK(lw_expansion_place(&x, at, eye - x.text - start + 1, &line, &column));
    const char *source = text;
    for (long k = 1; k < line; k++)
        source = strchr(source, '\n') + 1;
    CHECK(strncmp(source + column - 1, "\"{self} eye\"", 12) == 0);
    double mass, reach;
    CHECK_INT(lw_variant_configure(v, "large", &error), LW_OK);
    CHECK_INT(lw_variant_set(v, "reach", "300 cm", &error), LW_OK);
    CHECK_INT(lw_variant_number(v, "reach", &reach, &error), LW_OK);
    CHECK_NEAR(reach, 3, 0, 0);
    lw_model *model = NULL;                                      /* dynamic, kinematic: with and without masses */
    CHECK_INT(lw_variant_number(v, "boom_mass", &mass, &error), LW_OK);
    CHECK_INT(lw_variant_model(v, &model, &error), LW_OK);
    CHECK_NEAR(model->body[1].mass, mass, 1e-12*mass, 0);
    lw_model_destroy(model);
    CHECK_INT(lw_variant_look(v, "kinematic", &error), LW_OK);
    CHECK_INT(lw_variant_model(v, &model, &error), LW_OK);
    CHECK(!model->body[1].given && model->linkage.joint[2].at.x > 0);
    lw_model_destroy(model);
    free(text);
    free(want);
    done(v, m);
}

/* ---- what is refused ------------------------------------------------------------------------------- */

#define HEAD "{'linkwright': 1,\n"
#define BODY "'model': {'links': ['ground']"

TEST(refused)
{
    /* @ marks the place, and is not part of the text */
    static const struct { const char *text, *says; } rows[] = {
        { "@[1]", "an object" },
        { "{'linkwright': @2, 'model': {}}", "version 2" },
        { HEAD "@'parametres': {}, 'model': {}}", "did you mean \"parameters\"" },
        { HEAD "'parameters': {'a': @'=b', 'b': '=2*c',\n 'c': '=a + 1'}, 'model': {}}",
          "a -> b -> c -> a" },
        { HEAD "'parameters': {'a': 1}, 'let': {'b': @'b + a'}, 'model': {}}", "b -> b" },
        { HEAD "'parameters': {'width': 1}, 'let': {'b': '@widht + 1'}, 'model': {}}",
          "did you mean width" },
        { HEAD "'parameters': {'a': {'value': 1, 'unit': '@mn'}}, 'model': {}}", "no unit \"mn\"" },
        { HEAD "'parameters': {'a': {'value': 1, 'range': @[3, 2]}}, 'model': {}}", "must be less" },
        { HEAD "'parameters': {'2a': @1}, 'model': {}}", "cannot be a name" },
        { HEAD "'parameters': {'a': 1}, 'let': {'a': @'2'}, 'model': {}}", "given twice" },
        { HEAD "'parts': {'p': @{'use': [{'part': 'q'}]},\n 'q': {'use': [{'part': 'p'}]}}, 'model': {}}",
          "p -> q -> p" },
        { HEAD "'parts': {'arm': {}}, 'model': {'use': [{'part': @'amr'}]}}", "did you mean \"arm\"" },
        { HEAD "'parts': {'arm': {'parameters': {'len': 1}}}, 'model': {'use': [{'part': 'arm', 'with': {'lne': @2}}]}}",
          "did you mean \"len\"" },
        { HEAD "'parts': {'arm': {'gravity': @5}}, 'model': {}}", "a part holds" },
        { HEAD BODY ", 'joints': [{'at': [@'=2 kg', 0]}]}}", "[m] is expected, this is [kg]" },
        { HEAD BODY ", 'joints': [{'at': [@'=2', 0]}]}}", "[m] is expected, this is [plain number]" },
        { HEAD BODY ", 'x': [@'=2 kg']}}", "write the unit of the number" },
        { HEAD BODY ", 'joints': [{'name': '{@x}'}]}}", "no parameter or function x" },
        { HEAD BODY ", 'joints': [{'name': 'a@} b'}]}}", "closes nothing" },
        { HEAD BODY ", 'joints': [{'repeat': {'i': @1e8}}]}}", "at most 100000" },
        { HEAD BODY ", 'joints': [{'repeat': {'i': @2.5}}]}}", "a whole number" },
        { HEAD BODY ", 'joints': [{'repeat': {'i': @-1}}]}}", "at least 0" },
        { HEAD BODY ", 'joints': [{'repeat': {'i': @{'from': 1}}}]}}", "both \"from\" and \"to\"" },
        { HEAD BODY ", 'joints': [@{'repeat': {'i': 1000, 'j': 1000, 'k': 1000}, 'at': [0, 0]}]}}",
          "elements" },
        { HEAD "'parts': {'p': {'links': ['a']}}, " BODY ", 'use': [@{'part': 'p', 'repeat': {'i': 3}}]}}",
          "give each use a \"name\"" },
        { HEAD "'parts': {'p': {'forces': [{'fx': @5}]}}, " BODY
          ", 'use': [{'part': 'p', 'angle': 3}]}}",
          "needs \"frame\": \"link\"" },
        { HEAD "'parts': {'p': {'ports': {'hand': {'at': [0, 0]}}}}, " BODY
          ", 'use': [{'part': 'p'}, {'part': 'p', 'name': 'x', 'attach': 'hand', 'to': @'p.hnad'}]}}", "did you mean \"hand\"" },
        { HEAD "'views': {'rigid': {@'omitt': []}}, 'model': {}}", "did you mean \"omit\"" },
        { HEAD "'view': @'elastik', 'model': {}}", "did you mean \"elastic\"" },
        { HEAD "'parameters': {'size': 1}, 'configurations': {'a': {'set': {'sise': @1}}}, 'model': {}}",
          "did you mean \"size\"" },
        { HEAD "'checks': [{'require': '1 @< 2 m'}], 'model': {}}", "cannot be compared" },
        { HEAD "'checks': [{'require': @'3 < 2', 'text': 'three is small'}], 'model': {}}",
          "three is small (3 against 2)" },
        { HEAD "'checks': [{'require': @'3 + 2'}], 'model': {}}", "this is no condition" },
        { HEAD "'parameters': {'a': {'value': @5, 'range': [1, 2]}}, 'model': {}}",
          "outside its range 1 to 2" },
        { HEAD "'parameters': {'a': {'value': @1.5, 'whole': true}}, 'model': {}}", "no whole number" },
        { HEAD "'parameters': {'a': {'value': @3, 'choices': [1, 2]}}, 'model': {}}", "none of its choices" },
        { HEAD BODY ", 'joints': [{'when': @'3'}]}}", "a condition is expected" },
        /* by its reader */
        { HEAD "'model': {'links': ['ground', 'a']" ", 'joints': [{'name': 'j', 'kind': @'y', 'links': ['ground', 'a'], 'at': [0, 0]}]}}",
                                                                "kind" },
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_master *m = NULL;
        lw_variant *v = NULL;
        OWN(lw_expansion) x = { 0 };
        lw_model model;
        char text[400];
        json_format(text, sizeof text, "%s", rows[i].text);
        char *mark = strchr(text, '@'), *line = memrchr(text, '\n', (size_t)(mark - text));
        memmove(mark, mark + 1, strlen(mark));
        error = (lw_error){ 0 };
        lw_status s = lw_master_read(text, strlen(text), "f", &m, &error);
        if (s == LW_OK && (s = lw_variant_create(m, &v)) == LW_OK && (s = lw_variant_hold_checks(v, &error)) == LW_OK
            && (s = lw_variant_expand(v, &x, &error)) == LW_OK
            && (s = lw_model_read(x.text, x.size, "model", &model, &error)) != LW_OK)
            lw_expansion_fault(&x, &error);
        CHECK_INT(s, LW_E_NOTATION);
        CHECK_HAS(error.text, rows[i].says);
        long want_line = 1, want_column = mark - (line ? line + 1 : text) + 1;
        for (const char *c = text; c < mark; c++)
            want_line += *c == '\n';
        if (error.line != want_line || error.column != want_column)
            printf("row %zu: %ld:%ld: %s\n", i, error.line, error.column, error.text);
        CHECK_INT(error.line, want_line);
        CHECK_INT(error.column, want_column);
        CHECK_TEXT(error.file, "f");
        done(v, m);
    }
}

TEST(wrong_choices)
{
    lw_master *m;
    lw_variant *v = variant_of(plain_master, &m);
    static const struct { const char *name, *value, *says; } rows[] = {
        { "ll", "3", "did you mean \"l\"" }, { "l", "3 kx", "no unit" }, { "load", "3", "true or false" }, { "n", "x",
             "x" } };
    for (size_t i = 0; v && i < sizeof rows/sizeof *rows; i++) {
        error = (lw_error){ 0 };
        CHECK_INT(lw_variant_set(v, rows[i].name, rows[i].value, &error), LW_E_ARG);
        CHECK_HAS(error.text, rows[i].says);
    }
    CHECK_INT(lw_variant_set(v, "l", "3 kg", &error), LW_OK);              /* its unit is looked at when it is used */
    double x;
    CHECK_INT(lw_variant_number(v, "l", &x, &error), LW_E_NOTATION);
    CHECK_HAS(error.text, "its unit is [mm]");
    CHECK_INT(lw_variant_look(v, "dynamik", &error), LW_E_ARG);
    CHECK_HAS(error.text, "did you mean \"dynamic\"");
    CHECK_INT(lw_variant_configure(v, "big", &error), LW_E_ARG);
    done(v, m);
}
