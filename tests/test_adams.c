/* Datasets of ADAMS: what is written is looked at statement by statement, and read back as the same linkage. */
#include "catalogues/exchange/adams.h"

#include "catalogues/exchange/export.h"
#include "mbs/constraints/newton.h"
#include "tests/dynamics_run.h"
#include "tests/example_linkage.h"
#include "tests/loaded_models.h"

static lw_bytes dataset(const lw_linkage *k)
{
    lw_bytes b = { 0 };
    CHECK_SILENT(lw_export_adams(LW_VIEW(k), NULL, &b, &check_error));
    return b;
}

/* ---- statement by statement --------------------------------------------------------------------------- */

typedef struct seen {
    const lw_linkage *k;
    int n_part, n_marker, n_joint, n_coupler, n_motion, n_request, n_units, n_other;
    struct { int id, part; double x, y; } marker[400];
} seen;

static int part_of(const seen *w, const lw_adams_statement *s, const char *key, double *x, double *y)
{
    const lw_adams_argument *a = lw_adams_find(s, key);
    CHECK(a && a->n == 1);
    for (int i = 0; a && i < w->n_marker; i++)
        if (w->marker[i].id == a->value[0]) {
            *x = w->marker[i].x;
            *y = w->marker[i].y;
            return w->marker[i].part - 1;
        }
    CHECK(!"marker found");
    return -1;
}

static void look_at_joint(seen *w, const lw_adams_statement *s)
{
    const lw_joint *p = &w->k->joint[s->id - 1];
    double x[2] = { 0 }, y[2] = { 0 };
    int i = part_of(w, s, "I", &x[0], &y[0]), j = part_of(w, s, "J", &x[1], &y[1]);
    bool turned = p->kind == LW_JOINT_REVOLUTE && p->link[1] == w->k->ground;
    w->n_joint++;
    CHECK_TEXT(s->name, p->name);
    CHECK_INT(i, p->link[turned ? 0 : 1]);
    CHECK_INT(j, p->link[turned ? 1 : 0]);
    for (int m = 0; m < 2; m++) {
        CHECK_NEAR(x[m], p->at.x, 0, 1e-14);
        CHECK_NEAR(y[m], p->at.y, 0, 1e-14);
    }
    CHECK_TEXT(s->argument[0].key, p->kind == LW_JOINT_REVOLUTE ? "REVOLUTE" : p->kind == LW_JOINT_SLIDER
               ? "TRANSLATIONAL" : p->kind == LW_JOINT_SLOT ? "INPLANE" : "FIXED");
    CHECK_TEXT(s->keyword, p->kind == LW_JOINT_SLOT ? "JPRIM" : "JOINT");
}

static void look_at_marker(seen *w, const lw_adams_statement *s)
{
    const lw_adams_argument *part = lw_adams_find(s, "PART"), *at = lw_adams_find(s, "QP");
    CHECK(part && at && at->n == 3);
    CHECK_INT(s->id/100, part->value[0]);              /* as PLASMA numbers them */
    CHECK_NEAR(at->value[2], 0, 0, 0);
    w->marker[w->n_marker].id = s->id;
    w->marker[w->n_marker].part = (int)part->value[0];
    w->marker[w->n_marker].x = at->value[0];
    w->marker[w->n_marker++].y = at->value[1];
}

static lw_status look(void *context, const lw_adams_statement *s, lw_error *e)
{
    seen *w = context;
    (void)e;
    if (strcmp(s->keyword, "PART") == 0) {
        CHECK_INT(s->id, ++w->n_part);
        CHECK_TEXT(s->name, w->k->link_name[s->id - 1]);
        CHECK_INT(lw_adams_find(s, "GROUND") != NULL, s->id - 1 == w->k->ground);
    } else if (strcmp(s->keyword, "MARKER") == 0) {
        look_at_marker(w, s);
    } else if (strcmp(s->keyword, "JOINT") == 0 || strcmp(s->keyword, "JPRIM") == 0) {
        look_at_joint(w, s);
    } else if (strcmp(s->keyword, "COUPLER") == 0) {
        w->n_coupler++;
    } else if (strcmp(s->keyword, "MOTION") == 0) {
        const lw_adams_argument *of = lw_adams_find(s, "JOINT"), *f = lw_adams_find(s, "FUNCTION");
        bool slider = w->k->joint[w->k->input[w->n_motion].joint].kind == LW_JOINT_SLIDER;
        CHECK_INT(of->value[0] - 1, w->k->input[w->n_motion++].joint);
        CHECK(f && f->text[0]);
        CHECK(lw_adams_find(s, slider ? "TRANSLATION" : "ROTATION") != NULL);
    } else if (strcmp(s->keyword, "REQUEST") == 0) {
        const lw_tracer *t = &w->k->tracer[w->n_request/3];
        double x = 0, y = 0;
        CHECK_INT(part_of(w, s, "I", &x, &y), t->link);
        CHECK_NEAR(x, t->at.x, 0, 1e-14);
        CHECK_NEAR(y, t->at.y, 0, 1e-14);
        CHECK_TEXT(s->name, t->name);
        CHECK_INT(part_of(w, s, "J", &x, &y), w->k->ground);
        w->n_request++;
    } else if (strcmp(s->keyword, "UNITS") == 0) {
        w->n_units++;
        CHECK_TEXT(lw_adams_find(s, "LENGTH")->text, "METER");
    } else {
        w->n_other++;
    }
    return LW_OK;
}

/* ---- there and back -------------------------------------------------------------------------------------- */

/* Driven alike, all tracers go the same way. */
static void move_alike(const lw_linkage *a, const lw_linkage *b)
{
    lw_newton *s[2] = { NULL, NULL };
    CHECK_OK(lw_newton_create(a, &s[0], &check_error));
    CHECK_OK(lw_newton_create(b, &s[1], &check_error));
    for (int i = 0; s[0] && s[1] && i <= 10; i++) {
        double way = (a->joint[a->input[0].joint].kind == LW_JOINT_SLIDER ? 0.01*lw_export_size(LW_VIEW(a)) : 0.05)*i;
        CHECK_INT(lw_newton_move(s[0], a->input[0].value + way, NULL), LW_OK);
        CHECK_INT(lw_newton_move(s[1], b->input[0].value + way, NULL), LW_OK);
        for (int t = 0; t < a->n_tracer; t++)
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(lw_newton_tracer(s[0], t), lw_newton_tracer(s[1], t))), 0, 1e-9*lw_export_size(LW_VIEW(a)), 0);
    }
    lw_newton_free(s[0]);
    lw_newton_free(s[1]);
}

static lw_status read_back(const char *text, size_t size, lw_linkage *k, lw_error *e)
{
    OWN(lw_assembly) a = { 0 };
    lw_status s = lw_adams_read(text, size, "t", &a, e);
    if (s == LW_OK)
        s = lw_assembly_linkage(&a, k, e);
    return s;
}

static void there_and_back(const lw_linkage *k)
{
    static lw_linkage back;
    static seen w;
    OWN(lw_bytes) b = dataset(k);
    int gears = 0;
    w = (seen){ .k = k };
    CHECK_OK(lw_adams_scan(b.data, b.size, "t", look, &w, &check_error));
    for (int j = 0; j < k->n_joint; j++)
        gears += k->joint[j].kind == LW_JOINT_GEAR;
    CHECK_INT(w.n_part, k->n_link);
    CHECK_INT(w.n_joint, k->n_joint - gears);
    CHECK_INT(w.n_coupler, gears);
    CHECK_INT(w.n_motion, k->n_input);
    CHECK_INT(w.n_request, 3*k->n_tracer);
    CHECK_INT(w.n_marker, 2*(k->n_joint - gears) + k->n_tracer + 1);
    CHECK_INT(w.n_units, 1);
    CHECK_INT(w.n_other, 1);                           /* RESULTS */
    CHECK_SILENT(read_back(b.data, b.size, &back, &check_error));
    CHECK_INT(back.n_joint, k->n_joint);
    CHECK_INT(back.ground, k->ground);
    CHECK_TEXT(back.name, k->name);
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].kind == LW_JOINT_GEAR)
            CHECK_NEAR(back.joint[j].ratio, k->joint[j].ratio, 0, 1e-14);
        else
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(back.joint[j].along, k->joint[j].along)), 0, 1e-14, 0);
    move_alike(k, &back);
}

TEST(examples_there_and_back)
{
    for (int i = 0; i < N_EXAMPLE; i++) {
        lw_linkage k = example(example_names[i]);
        there_and_back(&k);
    }
    for (int order = 0; order < 4; order++) {
        lw_linkage k = scotch_yoke(order);
        there_and_back(&k);
    }
}

/* ---- text -------------------------------------------------------------------------------------------------- */

TEST(as_plasma_writes)
{
    lw_linkage k = example("hoeken");
    OWN(lw_bytes) b = dataset(&k);
    CHECK_HAS(b.data, "ADAMS/View model name: Hoeken straight-line linkage\n");
    CHECK_HAS(b.data, "PART/01, GROUND\n");
    CHECK_HAS(b.data, "MARKER/0201, PART = 02, QP = 0, 0, 0\n");
    CHECK_HAS(b.data, "JOINT/01, REVOLUTE, I = 0201, J = 0101\n");
    CHECK_HAS(b.data, "FUNCTION = 2*PI*TIME\n");
    lw_bytes_free(&b);
    CHECK_INT(lw_export_adams_commands(LW_VIEW(&k), NULL, &b, NULL), LW_OK);
    CHECK_HAS(b.data, "Hoeken_straight_line_linkage.adm\n");
    CHECK_HAS(b.data, "SIMULATE/KINEMATICS, END = 1.0, STEPS = 100\n");
    lw_bytes_free(&b);
    k = example("chebyshev");                          /* rocks: there and back within its way */
    b = dataset(&k);
    CHECK_HAS(b.data, "*SIN(2*PI*TIME + ");
}

/* As other programs write: continued lines, part frames, degrees, millimetres, floating words. */
TEST(written_by_others)
{
    static const char text[] =
        "some model\r\n!\nUNITS/\n, FORCE = NEWTON\n! between\n, LENGTH = MILLIMETER\nMATERIAL/1, NAME = steel, "
        "DENSITY = 7.8E-06\n! adams_view_name='ground'\nPART/1, GROUND, MATERIAL = steel\nMARKER/1, PART = 1\n"
        "PART/2, QG = 10, 0, 0, REULER = 90D, 0D, 0D, MASS = 1\nMARKER/2, PART = 2, QP = 0, 10, 0\n"
        "MARKER/3, PART = 2, QP = 20, 0, 0\n, REULER = 0D, 0D\n, 30D\njoint/4, revolute\n, i = 2, j = 1\n"
        "MOTION/1, ROTATION, JOINT = 4, FUNCTION = 30D*time\n,  + 1\nREQUEST/1, DISPLACEMENT, I = 3, J = 1\nEND\n"
        "rest /";
    static lw_linkage k;
    CHECK_SILENT(read_back(text, sizeof text - 1, &k, &check_error));
    CHECK_TEXT(k.name, "some model");
    CHECK_TEXT(k.units.length, "mm");
    CHECK_INT(k.n_link, 2);
    CHECK_TEXT(k.link_name[0], "ground");
    CHECK_TEXT(k.link_name[1], "part2");
    CHECK_INT(k.joint[0].link[1], 1);
    CHECK_NEAR(k.joint[0].at.x, 0, 1e-15, 0);
    CHECK_POINT(k.tracer[0].at, 0.01, 0.02, 1e-15, 0);
    CHECK_NEAR(k.tracer[0].angle, 2*LW_PI/3, 1e-15, 0);
    CHECK_INT(k.n_input, 1);
}

TEST(faults)
{
    static const struct { const char *text; int line, column; const char *why; } rows[] = {
        { "", 1, 1, "no PART" },
        { "t\nPART 1\n", 2, 6, "'/' is expected" },
        { "t\nPART/1, GROUND = \n", 2, 18, "a value is expected" },
        { "t\nPART/1\nMARKER/1, PART = 2\n", 3, 1, "must name a part" },
        { "t\nPART/1\nPART/1\n", 3, 1, "was there already" },
        { "t\nPART/1\nMARKER/1, PART = 1, QP = 1, 2\n", 3, 1, "three numbers" },
        { "t\nPART/1\nMARKER/1, PART = 1, QP = 1, 2, 3x\n", 3, 33, "a comma is expected" },
        { "t\nPART/1\nMARKER/1, PART = 1, QP = 1, 2, .\n", 3, 32, "a number is expected" },
        { "t\nPART/1\nMARKER/1, PART = 1, QP = 1, 2, 1e200\n", 3, 32, "a number is expected" },
        { "t\nPART/1\nMARKER/1, PART = 1\nJOINT/1, SPHERICAL, I=1, J=1\n", 4, 1, "REVOLUTE, TRANSLATIONAL or FIXED" },
        { "t\nPART/1\nMARKER/1, PART = 1\nJOINT/1, REVOLUTE, I=1, J=2\n", 4, 1, "J = must name a marker" },
        { "t\nPART/1\nMARKER/1, PART = 1, REULER=0,90D,0\nJOINT/1, REVOLUTE, I=1, J=1\n", 4, 1, "across the x-y" },
        { "t\nPART/1\nMARKER/1, PART = 1\nJOINT/1, TRANSLATIONAL, I=1, J=1\n", 4, 1, "lie in the x-y plane" },
        { "t\nPART/1\nMOTION/1, JOINT=1\n", 3, 1, "must name a pin" },
        { "t\nUNITS/LENGTH = PARSEC\n", 2, 1, "not known" },
        { "t\nPART/1, GROUND\nCOUPLER/1, JOINTS=1,2, SCALES=1\n", 3, 1, "must name joints" }
    };
    static lw_linkage k;
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_error e = { 0 };
        CHECK_INT(read_back(rows[i].text, strlen(rows[i].text), &k, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, rows[i].why);
        CHECK_INT(e.line, rows[i].line);
        CHECK_INT(e.column, rows[i].column);
    }
}

/* Masses and loads are there with their numbers, and the linkage reads back as without them. */
/* The centre of mass of a part is a marker of this part, also where markers are numbered one after the other. */
TEST(masses_of_many_links)
{
    OWN(lw_bytes) text = { 0 }, b = { 0 };
    char part[200];
    static drun d;
    lw_bytes_text(&text, "{\"linkwright\": 1, \"ground\": \"b0\", \"links\": [\"b0\"");
    for (int i = 1; i <= 70; i++) {
        snprintf(part, sizeof part, ", {\"name\": \"b%d\", \"mass\": 1, \"inertia\": 1, \"centre\": [%d.5, 0]}", i, i);
        lw_bytes_text(&text, part);
    }
    for (int i = 1; i <= 70; i++) {
        snprintf(part, sizeof part, "%s{\"name\": \"J%d\", \"links\": [\"b%d\", \"b%d\"], \"at\": [%d, 0]}", i == 1 ? "], \"joints\": [" : ", ",
                 i, i - 1, i, i);
        lw_bytes_text(&text, part);
    }
    lw_bytes_text(&text, "]}");
    drun_read_json(&d, text.data);
    lw_export_options o = { .model = &d.model, .clearance = -1 };
    CHECK_SILENT(lw_export_adams(&d.model.linkage, &o, &b, &check_error));
    for (int i = 1; i <= 70; i++) {
        int number = 0;
        snprintf(part, sizeof part, "PART/%02d, MASS = 1, CM = %%d", i + 1);
        for (const char *at = b.data; at && sscanf(at, part, &number) != 1; at = strchr(at, '\n') ? strchr(at, '\n') + 1 : NULL) {
        }
        snprintf(part, sizeof part, "MARKER/%04d, PART = %02d, QP = %d.5, 0, 0\n", number, i + 1, i);
        CHECK_HAS(b.data, part);
    }
}

/* The motion of an input is the model's own, counted from the posture, with masses or without. */
TEST(motions_are_the_models)
{
    static const struct { const char *link, *motion, *says; } rows[] = {
        { "'mass': 1, 'centre': [1, 0]", "0.5 + 0.3*sin(2*t)^2", "JOINT = 01, ROTATION\n, FUNCTION = 0.5 + 0.3*SIN(2*TIME)**2 - 0.5\n" },
        { "'mass': 0", "0.5 + 4*t", "FUNCTION = 0.5 + 4*TIME - 0.5\n" }, { "'mass': 0", "0.5 + t*sign(t)", NULL }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        static drun d;
        OWN(lw_bytes) b = { 0 };
        char text[600];
        json_format(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'arm', %s}], 'joints': [{'name': 'A', 'links': ['ground', "
                    "'arm'], 'at': [0, 0]}], 'input': {'joint': 'A', 'value': 0.5, 'motion': '%s'}}", rows[i].link, rows[i].motion);
        drun_read_json(&d, text);
        lw_export_options o = { .model = &d.model, .clearance = -1 };
        lw_status s = lw_export_adams(&d.model.linkage, &o, &b, &check_error);
        CHECK_INT(s, rows[i].says ? LW_OK : LW_E_KIND);
        CHECK_HAS(rows[i].says ? b.data : check_error.text, rows[i].says ? rows[i].says : "has no form in ADAMS");
    }
}

TEST(loads_are_written)
{
    static const char *const has[][12] = {
        { "PART/02, MASS = 2, CM = 0201, IP = 0.01, 0.01, 0.02\n", "MARKER/0201, PART = 02, QP = 0.1, 0, 0\n",
          "PART/03, MASS = 3, CM = 0301", "ACCGRAV/IGRAV = 1, JGRAV = -9.81, KGRAV = 0",
          "TRANSLATION, K = 200, C = 3, LENGTH = 0.3\n", "ROTATION, KT = 4, CT = 0.1, ANGLE = 0.2\n",
          "ROTATION\n, FUNCTION = 3*(1 - 0.05*WZ(", "TRANSLATION, ACTIONONLY\n, FUNCTION = 12\n",
          "TRANSLATION, ACTIONONLY\n, FUNCTION = 5\n", "ROTATION, ACTIONONLY\n, FUNCTION = 0.7\n" },
        { "PART/01, MASS = 1, CM = 0101", "PART/02, GROUND\n", "ROTATION, KT = 20, CT = 0.2, ANGLE = 0.1\n",
          "FUNCTION = -1*(1 - -0.0333333333333333*WZ(" }
    };
    for (size_t i = 0; i < LOADED_COUNT; i++) {
        static drun d;
        OWN(lw_bytes) b = { 0 };
        lw_linkage back;
        drun_read_format(&d, loaded[i], 0, 0);
        lw_export_options o = { .model = &d.model, .clearance = -1 };
        CHECK_SILENT(lw_export_adams(LW_VIEW(d.model.small), &o, &b, &check_error));
        for (int n = 0; n < 12 && has[i][n]; n++)
            CHECK_HAS(b.data, has[i][n]);
        CHECK(strstr(b.data, "MOTION/") == NULL);                      /* it runs freely */
        CHECK_SILENT(read_back(b.data, b.size, &back, &check_error));
        CHECK_INT(back.n_link, d.model.small->n_link);
        CHECK_INT(back.n_joint, d.model.small->n_joint);
        CHECK_INT(back.n_tracer, 1);
        lw_bytes_free(&b);
        CHECK_OK(lw_export_adams_commands(LW_VIEW(d.model.small), &o, &b, &check_error));
        CHECK_HAS(b.data, "SIMULATE/DYNAMICS");
    }
}
