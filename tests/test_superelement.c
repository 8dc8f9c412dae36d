/* Superelements: condensed bars (Guyan, Craig and Bampton) and matrices of files, against bars of elements, in the plane and in space. */
#include "tests/elastic_run.h"

static srun sagged;

static double sag(const char *elastic, double gravity, double force)
{
    lw_spatial m;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    if (read_bar(&m, elastic, gravity, force) != LW_OK)
        return NAN;
    run(&m, o, &sagged);
    return sagged.at[0].tracer[0].z;
}

/* Clapeyron: half the work of a load is strain energy, of a weight what the whole potential loses. */
static void check_strain(const char *elastic)
{
    double w = sag(elastic, 0, -1);
    CHECK_NEAR(sagged.strain, -w/2, 0, 1e-6);
    sag(elastic, -0.1, 0);
    CHECK_NEAR(sagged.strain, -sagged.at[0].total, 0, 1e-6);
}

static void write_matrix(const char *path, int n, const double *a)
{
    FILE *f = fopen(path, "w");
    fprintf(f, "%%%%MatrixMarket matrix array real general\n%% by columns\n%d %d\n", n, n);
    for (int i = 0; f && i < n*n; i++)
        fprintf(f, "%.17g\n", a[i%n*n + i/n]);
    if (f)
        fclose(f);
}

/* Small loads bend a bar condensed to any number of pieces as the whole one, by its weight too; the frequencies come from above to
 * those of the whole bar; matrices from files are the same superelement. */
TEST(condensed)
{
    double whole = sag(BAR ", 'segments': 20", -0.1, -1), f[3][4], before = INFINITY;
    lw_spatial m;
    CHECK(whole < -1e-6);
    check_strain(BAR ", 'segments': 20");
    read_bar(&m, BAR ", 'segments': 20", 0, 0);
    frequencies(&m, false, 4, f[0]);
    for (int pieces = 1; pieces <= 5; pieces = 2*pieces + pieces/2) {        /* 1, 2, 5 */
        char text[500];
        snprintf(text, sizeof text, BAR ", 'segments': 20, 'superelements': %d", pieces);
        CHECK_NEAR(sag(text, -0.1, -1)/whole, 1, 1e-10, 0);
        CHECK_INT(sagged.n_inner, pieces + 1);
        for (int i = 0; i <= pieces; i++) {  /* statics of a bar: what hangs beyond a node */
            double beyond = 2 - 2.0*i/pieces, line = 0.1*7850*(0.05*0.08 - 0.042*0.072);
            CHECK_NEAR(sagged.inner[i].shear[0], -line*beyond - 1, 1e-5, 0);
            CHECK_NEAR(sagged.inner[i].bending[1], -line*beyond*beyond/2 - beyond, 1e-5, 0);
            CHECK_NEAR(sagged.inner[i].normal, 0, 1e-4, 0);
        }
        check_strain(text);
        read_bar(&m, text, 0, 0);
        frequencies(&m, false, 4, f[1]);
        double error = f[1][0]/f[0][0] - 1;                          /* of a cubic: 0.5 % */
        CHECK(error > 0 && error < 0.15*before && error < 0.006);
        before = error;
    }
    OWN(lw_spatial_expansion) x = { 0 };
    read_bar(&m, BAR ", 'segments': 20, 'superelements': 1", 0, 0);
    CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
    lw_superelement *p = x.model.super;
    char path[2][300], text[1000];
    for (int i = 0; i < 2; i++)
        snprintf(path[i], sizeof path[i], "%s/%s.mtx", temporary_folder(), i ? "mass" : "stiffness");
    double most = 0, rigid = 0;              /* rigid motions cause no force */
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < 12; i++) {
            double force = 0;
            for (int j = 0; j < 2; j++) {
                lw_vec3 axis = lw_v3(k%3 == 0, k%3 == 1, k%3 == 2), move = k < 3 ? axis : lw_v3_cross(axis, p->at[j]);
                const double by[6] = { move.x, move.y, move.z, k > 2 ? axis.x : 0, k > 2 ? axis.y : 0, k > 2 ? axis.z : 0 };
                for (int c = 0; c < 6; c++) {
                    force += p->stiffness[12*i + 6*j + c]*by[c];
                    most = fmax(most, fabs(p->stiffness[12*i + 6*j + c]));
                }
            }
            rigid = fmax(rigid, fabs(force));
        }
    CHECK(rigid < 1e-9*most);
    write_matrix(path[0], 12, p->stiffness);
    write_matrix(path[1], 12, p->rate);
    frequencies(&m, false, 4, f[1]);
    snprintf(text, sizeof text, "'nodes': [[0, 0, 0], [2, 0, 0]], 'stiffness': '%s', 'mass': '%s'", path[0], path[1]);
    CHECK_NEAR(sag(text, -0.1, -1)/whole, 1, 1e-9, 0);
    check_strain(text);
    read_bar(&m, text, 0, 0);
    frequencies(&m, false, 4, f[2]);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(f[2][i], f[1][i], 0, 1e-9);
}

/* A planar bar on a hinge and a slide: two frequencies [Hz], the turn at the hinge under its weight [rad], and the energy of its strains [J]; elastic:
 * "elastic" of its link. */
static void hinged_bar(const char *elastic, lw_elastic_expansion *x, double out[4])
{
    char text[1500];
    OWN(lw_model) m = { 0 };
    OWN(lw_modes) modes = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d = NULL;
    lw_rest rest;
    snprintf(text, sizeof text, "{'linkwright': 1, 'gravity': [0, -0.01], 'links': ['ground', {'name': 'bar', 'elastic': {%s}}], 'joints': [{'name': 'A', "
             "'links': ['ground', 'bar'], 'at': [0, 0]}, {'name': 'B', 'kind': 't', 'links': ['ground', 'bar'], 'at': [0.6, 0.8], 'along': [0.6, 0.8]}]}", elastic);
    o.analysis = LW_ANALYSIS_STATIC;
    read_planar(text, "test", &m);
    lw_status st = lw_dynamics_make(&m, &o, &d, &check_error);
    CHECK_OK(st);
    if (st == LW_OK) {
        const lw_system *s = lw_dynamics_system(d);
        FREED double *q = calloc(2*(size_t)s->n_q, sizeof *q);
        lw_dynamics_start(d, q, q + s->n_q);
        CHECK_OK(lw_modes_find_large(d, &(lw_modes_options){ 0 }, 3, 0, q, &modes, &check_error));
        for (int i = 0; i < 2; i++)
            out[i] = i < modes.n_mode ? modes.mode[i].frequency : NAN;
        CHECK_OK(lw_statics_rest(d, 0, q, &rest, &check_error));
        out[2] = q[2];
        out[3] = lw_forces_strain(lw_dynamics_forces(d), q);
    }
    if (x)
        CHECK_OK(lw_elastic_expand(&m, false, x, &check_error));
    lw_dynamics_free(d);
}

/* In the plane, a bar condensed to pieces rests as its elements do and has their frequencies, from above, and nearer with modes, which are those in the
 * plane; its matrices from files are the same superelement. */
TEST(condensed_in_the_plane)
{
    enum { PIECES = 12, ROWS = 6*(PIECES + 1) };
    static double matrix[2][ROWS*ROWS];
    static const char bar[] = "'section': {'shape': 'rectangle', 'width': 0.02, 'height': 0.03}, 'material': 'steel', 'segments': 12";
    double whole[4], got[4], same[4];
    char text[2000], path[2][300], nodes[1000] = "";
    OWN(lw_elastic_expansion) x = { 0 };
    hinged_bar(bar, NULL, whole);
    snprintf(text, sizeof text, "%s, 'superelements': 4", bar);
    hinged_bar(text, NULL, got);
    CHECK(got[0] > whole[0] && got[0] < 1.001*whole[0] && got[1] > whole[1] && got[1] < 1.01*whole[1]);
    CHECK_NEAR(got[2], whole[2], 0, 1e-6);
    snprintf(text, sizeof text, "%s, 'superelements': 2", bar);
    hinged_bar(text, &x, got);
    CHECK_NEAR(got[2], whole[2], 0, 1e-6);
    CHECK_INT(x.model.n_super, 2);
    lw_elastic_expansion_free(&x);
    snprintf(text, sizeof text, "%s, 'superelements': 1", bar);
    hinged_bar(text, &x, got);
    lw_superelement *p = x.model.super;
    for (int i = 0; i < 2; i++)
        snprintf(path[i], sizeof path[i], "%s/flat-%s.mtx", temporary_folder(), i ? "mass" : "stiffness");
    write_matrix(path[0], 12, p->stiffness);
    write_matrix(path[1], 12, p->rate);
    lw_elastic_expansion_free(&x);
    snprintf(text, sizeof text, "'nodes': [[0, 0], [0.6, 0.8]], 'stiffness': '%s', 'mass': '%s'", path[0], path[1]);
    hinged_bar(text, NULL, same);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(same[i], got[i], 0, i < 2 ? 1e-9 : 1e-7);
    snprintf(text, sizeof text, "%s, 'superelements': 1, 'modes': 6", bar);
    hinged_bar(text, NULL, got);
    CHECK(got[0] > whole[0] && got[0] < (1 + 1e-6)*whole[0] && got[1] > whole[1] && got[1] < (1 + 1e-4)*whole[1]);
    CHECK_NEAR(got[2], whole[2], 0, 1e-6);
    snprintf(text, sizeof text, "%s, 'superelements': %d", bar, PIECES);
    hinged_bar(text, &x, same);
    for (int k = 0; k < PIECES; k++)
        for (int i = 0; i < 144; i++) {
            int to = (6*k + i/12)*ROWS + 6*k + i%12;
            matrix[0][to] += x.model.super[k].stiffness[i];
            matrix[1][to] += x.model.super[k].rate[i];
        }
    for (int i = 0; i <= PIECES; i++)
        snprintf(nodes + strlen(nodes), sizeof nodes - strlen(nodes), "%s[%.17g, %.17g]", i ? ", " : "", 0.6*i/PIECES, 0.8*i/PIECES);
    for (int i = 0; i < 2; i++)
        write_matrix(path[i], ROWS, matrix[i]);
    snprintf(text, sizeof text, "'nodes': [%s], 'stiffness': '%s', 'mass': '%s', 'modes': 6", nodes, path[0], path[1]);
    hinged_bar(text, NULL, same);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(same[i], got[i], 0, i < 2 ? 1e-9 : 1e-7);
}

/* Craig and Bampton's modes: the frequencies come from above to those of the whole bar, clamped and free, ever nearer with more
 * modes, and much nearer than Guyan's; at rest the ends stay where Guyan has them; matrices of a mesh are the same. */
TEST(craig_bampton)
{
    enum { PIECES = 10, ROWS = 6*(PIECES + 1), COUNT_OF = 8 };
    static const char *const joint[] = { "fixed", "free" };
    static double matrix[2][ROWS*ROWS];
    double whole[COUNT_OF], f[COUNT_OF];
    OWN(lw_spatial) m = { 0 };
    for (int free_free = 0; free_free < 2; free_free++) {
        double before = INFINITY, guyan = 0;
        for (int modes = -6; modes <= 48; modes = modes < 6 ? modes + 6 : 2*modes) {
            const char *more[] = { "", ", 'superelements': 1", ", 'superelements': 1, 'modes': " };
            int skip = 6*free_free;
            double worst = 0, all[COUNT_OF + 6];
            char number[20];
            snprintf(number, sizeof number, "%d", modes);
            CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {" BAR ", 'segments': 20%s%s}}], 'joints': "
                               "[{'name': 'A', 'kind': '%s', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}]%s}", more[modes < 0 ? 0 : modes ? 2 : 1],
                               modes > 0 ? number : "", joint[free_free], free_free ? "" : ", 'gravity': [0, 0, 0]"));
            int n = modes == 0 ? (free_free ? 8 : 4) : skip + 5;      /* Guyan has few */
            frequencies(&m, false, n, all);
            for (int i = 0; i < n - skip; i++) {
                f[i] = all[skip + i];
                whole[i] = modes < 0 ? f[i] : whole[i];
                worst = fmax(worst, f[i]/whole[i] - 1);
                CHECK(f[i] > whole[i]*(1 - 1e-9));
            }
            if (modes < 0)
                continue;
            guyan = modes == 0 ? worst : guyan;
            CHECK(worst < before && (modes < 6 || worst < 0.05*guyan));
            before = worst;
        }
        CHECK(before < 1e-5);
    }
    for (int modes = 0; modes < 2; modes++) {        /* a tracer cuts off a piece of one element, which has no modes */
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {" BAR ", 'segments': 20%s}}], 'joints': [{'name': 'A', "
                           "'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [0.1, 0, 0]}]}",
                           modes ? ", 'superelements': 1, 'modes': 24" : ""));
        frequencies(&m, false, 4, modes ? f : whole);
    }
    for (int i = 0; i < 4; i++)
        CHECK(f[i] > whole[i] && f[i] < (1 + 1e-4)*whole[i]);
    for (int modes = 0; modes <= 24; modes += 12) {
        char text[500];
        snprintf(text, sizeof text, BAR ", 'segments': 20, 'superelements': 1, 'modes': %d", modes);
        whole[modes/12] = sag(text, -0.1, -1);
        CHECK_NEAR(whole[modes/12]/whole[0], 1, 1e-11, 0);
    }
    OWN(lw_spatial_expansion) x = { 0 };
    read_bar(&m, BAR ", 'segments': 20, 'superelements': 10", 0, 0);
    CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
    for (int k = 0; k < PIECES; k++)
        for (int i = 0; i < 144; i++) {
            int to = (6*k + i/12)*ROWS + 6*k + i%12;
            matrix[0][to] += x.model.super[k].stiffness[i];
            matrix[1][to] += x.model.super[k].rate[i];
        }
    char nodes[1000] = "", path[2][300], text[2000];
    for (int i = 0; i <= PIECES; i++)
        snprintf(nodes + strlen(nodes), sizeof nodes - strlen(nodes), "%s[%.17g, 0, 0]", i ? ", " : "", 2.*i/PIECES);
    lw_spatial_expansion_free(&x);
    frequencies(&m, false, 4, whole);
    double before = INFINITY;
    for (int modes = 0; modes <= 24; modes = modes ? 2*modes : 6) {
        double worst = 0;
        for (int i = 0; i < 2; i++) {
            snprintf(path[i], sizeof path[i], "%s/mesh-%s.mtx", temporary_folder(), i ? "mass" : "stiffness");
            write_matrix(path[i], ROWS, matrix[i]);
        }
        snprintf(text, sizeof text, "'nodes': [%s], 'stiffness': '%s', 'mass': '%s', 'modes': %d", nodes, path[0], path[1], modes);
        read_bar(&m, text, 0, 0);
        frequencies(&m, false, 4, f);
        for (int i = 0; i < 4; i++)
            worst = fmax(worst, fabs(f[i]/whole[i] - 1));
        CHECK(modes ? worst < before : worst < 1e-9);
        before = modes ? worst : before;
    }
    CHECK(before < 1e-3);
    static srun r[3];                      /* in time the clamped bar falls 1.6 mm by its weight: ten pieces, the mesh, the mesh by modes */
    for (int k = 0; k < 3; k++) {
        lw_dynamics_options o = lw_dynamics_options_default();
        snprintf(text, sizeof text, "'nodes': [%s], 'stiffness': '%s', 'mass': '%s', 'modes': %d", nodes, path[0], path[1], k == 2 ? 12 : 0);
        read_bar(&m, k ? text : BAR ", 'segments': 20, 'superelements': 10", -9.81, 0);
        o.to = 0.1, o.intervals = 50;
        o.relative = o.absolute = 1e-8;
        run(&m, o, &r[k]);
        double most = 0;
        for (int i = 0; i < r[k].n; i++) {
            most = fmax(most, fabs(r[k].at[i].tracer[0].z));
            CHECK_NEAR(r[k].at[i].tracer[0].z, r[0].at[i].tracer[0].z, k == 2 ? 1e-6 : 5e-9, 0);
            CHECK_NEAR(r[k].at[i].tracer[0].x, r[0].at[i].tracer[0].x, 0.1*r[0].at[i].tracer[0].z*r[0].at[i].tracer[0].z + 1e-8, 0);       /* foreshortening, of second order */
        }
        CHECK(most > 1e-3);
    }
    snprintf(text, sizeof text, "'nodes': [%s], 'stiffness': '%s', 'mass': '%s', 'modes': 60", nodes, path[0], path[1]);
    read_bar(&m, text, 0, 0);
    CHECK_FAILS(lw_spatial_expand(&m, false, &x, &check_error), LW_E_ARG, "9 inner nodes, which has 54");
}

/* A soft bar (48 N m by its weight) falls about a hinge, whole and condensed: modes bring its tip a hundred times nearer to that of the whole
 * mesh, where K of small strains leaves the rest, which falls with the square of the number of pieces; no energy is lost, and nothing pulls
 * at its free end. */
TEST(condensed_swing)
{
    static const struct { const char *more; double off; } row[] = {
        { "", 0 }, { ", 'superelements': 1", 2e-3 }, { ", 'superelements': 1, 'modes': 6", 2.5e-5 }, { ", 'superelements': 1, 'modes': 12", 2.5e-5 },
        { ", 'superelements': 2, 'modes': 12", 8e-6 },
    };
    static srun whole, r;
    for (int k = 0; k < (int)(sizeof row/sizeof *row); k++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'round', 'diameter': "
                           "0.02}, 'material': " STEEL ", 'axis': [[0, 0, 0], [2, 0, 0]], 'segments': 20%s}}], 'joints': [{'name': 'A', 'kind': "
                           "'revolute', 'links': ['ground', 'bar'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', "
                           "'at': [2, 0, 0]}], 'gravity': [0, 0, -9.81]}", row[k].more));
        o.to = 0.3;
        o.intervals = 60;
        o.relative = o.absolute = 1e-8;
        run(&m, o, k ? &r : &whole);
        double worst = 0, lost = 0;
        for (int i = 0; k && i < r.n; i++) {
            worst = fmax(worst, lw_v3_norm(lw_v3_sub(r.at[i].tracer[0], whole.at[i].tracer[0])));
            lost = fmax(lost, fabs(r.at[i].total - r.at[0].total));
        }
        CHECK(worst <= row[k].off && lost < 1e-6);
        if (k) {                             /* nothing pulls at the free end; the bar weighs 24 N */
            const lw_space_inner *end = &r.inner[r.n_inner - 1];
            CHECK_NEAR(end->normal, 0, 1e-4, 0);
            CHECK_NEAR(hypot(end->shear[0], end->shear[1]), 0, 1e-4, 0);
        }
    }
}

/* A thick bar falls about a hinge, in 4 elements of consistent mass, as the rigid bar does whose angle follows from its energy; in 4 elements with
 * lumped mass the bar has too much inertia. */
TEST(consistent_swing)
{
    static srun r;
    for (int lumped = 0; lumped < 2; lumped++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'rectangle', 'width': 0.1, 'height': "
                           "0.1}, 'material': " STEEL ", 'axis': [[0, 0, 0], [1, 0, 0]], 'segments': 4, 'mass': '%s'}}], 'joints': [{'name': 'A', 'kind': "
                           "'revolute', 'links': ['ground', 'bar'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', "
                           "'at': [1, 0, 0]}], 'gravity': [0, 0, -9.81]}", lumped ? "lumped" : "consistent"));
        o.to = 0.25;
        o.intervals = 20;
        run(&m, o, &r);
        double angle = 0, rate = 0, drive = 9.81/2/(1./3 + 0.1*0.1/12), worst = 0, lost = 0, step = 1e-4;
        for (int i = 1; i < r.n; i++) {
            for (int k = 0; k < 125; k++) {              /* angle'' = drive cos(angle), leapfrog */
                rate += step/2*drive*cos(angle);
                angle += step*rate;
                rate += step/2*drive*cos(angle);
            }
            worst = fmax(worst, hypot(r.at[i].tracer[0].x - cos(angle), r.at[i].tracer[0].z + sin(angle)));
            lost = fmax(lost, fabs(r.at[i].total - r.at[0].total));
        }
        CHECK(r.n == 21 && lost < 1e-3);
        CHECK(lumped ? worst > 1e-2 : worst < 3e-5);
    }
}

/* A condensed bar on a hub that tumbles freely: momentum, angular momentum and energy are kept, by radau and by the explicit method, which
 * agree. */
TEST(condensed_tumbles)
{
    static srun r[2];
    for (int k = 0; k < 2; k++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        o.to = 0.1, o.intervals = 20;
        o.relative = o.absolute = k ? 1e-10 : 1e-12;
        o.formulation = k ? LW_FORMULATION_INDEX1 : LW_FORMULATION_RADAU;
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'hub', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [0.02, 0.03, "
                           "0.04], 'angular_velocity': [0.6, 0, 6.283185307179586], 'velocity': [0.1, 0, -0.2]}, {'name': 'bar', 'elastic': "
                           "{'section': {'shape': 'rectangle', 'width': 0.1, 'height': 0.05}, 'height': [0, 0, 1], 'material': {'E': 2e7, 'nu': 0.3, "
                           "'density': 1000}, 'axis': [[0, 0, 0], [0.5, 0.1, 0]], 'segments': 10, 'superelements': 1, 'modes': 6}}], 'joints': "
                           "[{'name': 'F', 'kind': 'free', 'links': ['ground', 'hub'], 'at': [0, 0, 0]}, {'name': 'W', 'kind': 'fixed', 'links': "
                           "['hub', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [0.5, 0.1, 0]}]}"));
        run(&m, o, &r[k]);
        CHECK_INT(r[k].n, 21);
        for (int i = 0; i < r[k].n; i++) {
            CHECK_NEAR(r[k].at[i].total/r[k].at[0].total, 1, 1e-9, 0);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(r[k].at[i].linear, r[k].at[0].linear)), 0, 1e-12, 0);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(r[k].at[i].angular, r[k].at[0].angular)), 0, 1e-12, 0);
        }
    }
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(r[0].at[20].tracer[0], r[1].at[20].tracer[0])), 0, 1e-9, 0);
}

/* The spin-up of Simo & Vu-Quoc (1986), tip across the arm that turns as given: -.571 at 7 s, -.559 at 7.5 s, -.3625 at 10 s (+-.001, from
 * ever finer chains).  A condensed piece is not stiffened by the tension in it, so the error falls with the square of the number of pieces. */
TEST(condensed_spin_up)
{
    static srun r;
    double before = 0;
    for (int pieces = 4; pieces <= 16; pieces *= 2) {
        static const double want[] = { -.571, -.559, -.3625 }, t[] = { 7, 7.5, 10 };
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        o.to = 10, o.intervals = 20;
        o.relative = o.absolute = 1e-5;
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'arm', 'elastic': {'section': {'shape': 'general', 'area': 1, 'Iz': "
                           "5e-4, 'Iy': 5e-4, 'It': 1e-3, 'zeta': 1}, 'material': {'E': 2.8e7, 'G': 1e7, 'density': 1.2}, 'axis': [[0, 0, 0], [10, 0, "
                           "0]], 'segments': 32, 'superelements': %d}}], 'joints': [{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'arm'], "
                           "'at': [0, 0, 0], 'axis': [0, 0, 1]}], 'input': {'joint': 'A', 'motion': '0.4*(t^2/2 + (7.5/pi)^2*(cos(2*pi*t/15) - 1))'}, "
                           "'gravity': [0, 0, 0], 'tracers': [{'name': 'P', 'link': 'arm', 'at': [10, 0, 0]}]}", pieces));
        run(&m, o, &r);
        double off = 0;
        for (int k = 0; k < 3 && r.n == 21; k++) {
            double psi = 0.4*(t[k]*t[k]/2 + pow(7.5/LW_PI, 2)*(cos(2*LW_PI*t[k]/15) - 1));
            lw_vec3 at = r.at[(int)(2*t[k])].tracer[0];
            off = fmax(off, fabs(at.y*cos(psi) - at.x*sin(psi) - want[k]));
        }
        CHECK_INT(r.n, 21);
        CHECK(pieces == 4 || off < 0.4*before);
        CHECK(pieces < 16 || off < 2.5e-3);
        before = off;
    }
}

/* A bar of 40 elements swung slowly about its end: in four superelements its tip is where the whole one has it, though each has two nodes. */
TEST(condensed_swung)
{
    static srun r[2];
    for (int k = 0; k < 2; k++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'rectangle', 'width': 0.01, "
                           "'height': 0.02}, 'height': [0, 0, 1], 'material': " STEEL ", 'axis': [[0, 0, 0], [1, 0, 0]], 'segments': 40%s}}], 'joints': "
                           "[{'name': 'A', 'kind': 'revolute', 'links': ['ground', 'bar'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}], 'input': {'joint': 'A', "
                           "'motion': '0.3*sin(6*t)'}, 'tracers': [{'name': 'P', 'link': 'bar', 'at': [1, 0, 0]}]}", k ? ", 'superelements': 4" : ""));
        o.to = 0.3, o.intervals = 60;
        o.relative = o.absolute = 1e-7;
        run(&m, o, &r[k]);
    }
    for (int i = 0; i <= 60; i++)
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(r[1].at[i].tracer[0], r[0].at[i].tracer[0])), 0, 1.5e-6, 0);
}

/* A shaft that is turned faster and faster about its axis, whole and condensed: the torque at its driven end accelerates all of it,
 * nothing acts on its free end.  The angle 5 t^3 is slow against its vibrations (800 Hz, damped). */
TEST(condensed_shaft)
{
    static srun got;
    for (int pieces = 0; pieces <= 2; pieces++) {
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        char more[60] = "";
        if (pieces)
            snprintf(more, sizeof more, ", 'superelements': %d", pieces);
        CHECK_SILENT(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'shaft', 'elastic': {'section': {'shape': 'round', 'diameter': 0.1}, "
                               "'material': " STEEL ", 'axis': [[0, 0, 0], [1, 0, 0]], 'segments': 8, 'damping': 2e-4%s}}], 'joints': [{'name': 'A', 'kind': "
                               "'revolute', 'links': ['ground', 'shaft'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}], 'input': {'joint': 'A', 'motion': '5*t^3'}, "
                               "'tracers': [{'name': 'P', 'link': 'shaft', 'at': [1, 0, 0]}]}", more));
        o.to = 0.1;
        o.intervals = 1;
        o.relative = o.absolute = 1e-9;
        run(&m, o, &got);
        double torque = 7850*LW_PI*pow(0.1, 4)/32*30*0.1;
        /* of the whole bar, half an element at either end is the joint's and the free end's own */
        CHECK_NEAR(-got.inner[0].torque/torque, pieces ? 1 : 15./16, 2e-4, 0);
        CHECK_NEAR(-got.inner[got.n_inner - 1].torque/torque, pieces ? 0 : 1./16, 2e-4, 0);
    }
}

/* A bent bar whose centre of mass is beside the line of its ends sags under its weight as the whole one, in one piece too. */
TEST(condensed_frame)
{
    static srun r[3];
    for (int i = 0; i < 3; i++) {
        static const char *const more[] = { "", ", 'superelements': 1", ", 'superelements': 1, 'modes': 12" };
        lw_spatial m;
        lw_dynamics_options o = lw_dynamics_options_default();
        o.analysis = LW_ANALYSIS_STATIC;
        CHECK_OK(read_text(&m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'section': {'shape': 'box', 'width': 0.05, "
                           "'height': 0.08, 'wall': 0.004}, 'height': [0.1, 1, 0.3], 'material': " STEEL ", 'axis': [[0, 0, 0], [0.2, 0.3, 1], "
                           "[2, 0, 1]], 'segments': 20%s}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, "
                           "0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [2, 0, 1]}], 'gravity': [0.02, 0.03, -0.05]}", more[i]));
        run(&m, o, &r[i]);
        lw_vec3 off = lw_v3_sub(r[i].at[0].tracer[0], r[0].at[0].tracer[0]), sag = lw_v3_sub(r[0].at[0].tracer[0], lw_v3(2, 0, 1));
        CHECK(lw_v3_norm(off) < 1e-4*lw_v3_norm(sag));
    }
}

/* Elastica, P L^2/EI = 5: w/L .713791524; the error falls with the square of the number of pieces. */
TEST(condensed_elastica)
{
    double before = 0;
    for (int pieces = 4; pieces <= 16; pieces *= 2) {
        char text[500];
        snprintf(text, sizeof text, "'section': {'shape': 'general', 'area': 1, 'Iz': 1e-8, 'Iy': 1e-8, 'It': 1e-8, 'zeta': 1e-12}, 'material': "
                 "{'E': 1e9, 'G': 1e9, 'density': 1}, 'axis': [[0, 0, 0], [2, 0, 0]], 'segments': %d, 'superelements': %d", 2*pieces, pieces);
        double off = sag(text, 0, 5*10/4.)/2 - .713791524;
        CHECK_NEAR(off, 0, 0.15/(pieces*pieces), 0);
        CHECK(pieces == 4 || (fabs(off) < 0.3*before && fabs(off) > 0.2*before));
        before = fabs(off);
    }
}

/* Forces of a superelement between four nodes in any posture against differences of its energy, and their derivatives against
 * differences of the forces; forces and moments balance. */
TEST(superelement_derivatives)
{
    enum { N = 4, ROWS = 6*N };
    double stiffness[ROWS*ROWS], first[3*ROWS], lump[N], force[3][ROWS], by_x[ROWS*ROWS], by_v[ROWS*ROWS], power;
    lw_vec3 at[N];
    lw_mat3 turn[N];
    lw_beam_node node[N];
    OWN(lw_super) s = { 0 };
    lw_rng rng = check_rng(0);
    for (int i = 0; i < ROWS*ROWS; i++)
        stiffness[i] = lw_rng_range(&rng, -1, 1);
    for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < i; j++)
            stiffness[ROWS*i + j] = stiffness[ROWS*j + i];
    for (int i = 0; i < 3*ROWS; i++)
        first[i] = lw_rng_range(&rng, -0.1, 0.1);
    for (int i = 0; i < N; i++) {
        lump[i] = 0.1;
        at[i] = lw_v3(i, lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1));
        lw_vec3 away = lw_v3(lw_rng_range(&rng, -.3, .3), lw_rng_range(&rng, -.3, .3), lw_rng_range(&rng, -.3, .3));
        lw_vec3 about = lw_v3(2 + lw_rng_range(&rng, -.4, .4), lw_rng_range(&rng, -.4, .4), lw_rng_range(&rng, -.4, .4));
        turn[i] = lw_quaternion_matrix(lw_quaternion_of_vector(away));
        node[i] = (lw_beam_node){ .at = lw_v3_add(at[i], away) };
        node[i].turn = lw_quaternion_matrix(lw_quaternion_times(lw_quaternion_of_vector(about), lw_quaternion_of_matrix(&turn[i])));
    }
    lw_superelement p = { .n = N, .at = at, .stiffness = stiffness, .first = first, .lump = lump, .beside = { 0.2, -0.1, 0.3 } };
    CHECK_INT(lw_super_make(&p, turn, lw_v3(1, -2, 9), &s), LW_OK);
    lw_super_at(&s, node, force[0], by_x, by_v, &power);
    double h = 1e-5;
    for (int c = 0; c < ROWS; c++) {
        double energy[2];
        for (int way = 0; way < 2; way++) {
            lw_beam_node old = node[c/6];
            lw_vec3 by = lw_v3_scale(lw_v3(c%3 == 0, c%3 == 1, c%3 == 2), way ? h : -h);
            lw_quaternion more = lw_quaternion_of_vector(by);
            if (c%6 < 3)
                node[c/6].at = lw_v3_add(old.at, by);
            else
                node[c/6].turn = lw_quaternion_matrix(lw_quaternion_times(more, lw_quaternion_of_matrix(&old.turn)));
            energy[way] = lw_super_at(&s, node, force[1 + way], NULL, NULL, &power);
            node[c/6] = old;
        }
        CHECK_NEAR(force[0][c], -(energy[1] - energy[0])/(2*h), 1e-8, 0);
        for (int r = 0; r < ROWS; r++)
            CHECK_NEAR(by_x[ROWS*r + c], (force[2][r] - force[1][r])/(2*h), 1e-7, 0);
    }
    lw_super_free(&s);
    CHECK_INT(lw_super_make(&p, turn, lw_v3(0, 0, 0), &s), LW_OK);
    lw_super_at(&s, node, force[0], NULL, NULL, &power);
    lw_vec3 pull = { 0, 0, 0 }, twist = { 0, 0, 0 };
    for (int i = 0; i < N; i++) {
        const double *f = force[0] + 6*i;
        pull = lw_v3_add(pull, lw_v3(f[0], f[1], f[2]));
        twist = lw_v3_add(twist, lw_v3_add(lw_v3(f[3], f[4], f[5]), lw_v3_cross(node[i].at, lw_v3(f[0], f[1], f[2]))));
    }
    CHECK(lw_v3_norm(pull) < 1e-12 && lw_v3_norm(twist) < 1e-12);
}

/* Nodes of a superelement, and their accelerations, after a time t (to its second order). */
static void move_nodes(int n, const lw_beam_node *node, const lw_vec3 *rate, double t, lw_beam_node *out)
{
    for (int i = 0; i < n; i++) {
        lw_vec3 turn = lw_v3_add(lw_v3_scale(node[i].omega, t), lw_v3_scale(rate[2*i + 1], t*t/2));
        out[i].at = lw_v3_add(node[i].at, lw_v3_add(lw_v3_scale(node[i].v, t), lw_v3_scale(rate[2*i], t*t/2)));
        out[i].turn = lw_quaternion_matrix(lw_quaternion_times(lw_quaternion_of_vector(turn), lw_quaternion_of_matrix(&node[i].turn)));
        out[i].v = lw_v3_add(node[i].v, lw_v3_scale(rate[2*i], t));
        out[i].omega = lw_v3_add(node[i].omega, lw_v3_scale(rate[2*i + 1], t));
    }
}

enum { INERTIA_NODES = 4 };

/* Inertia of a superelement between three nodes and one that carries modes, of any matrices, in any motion: its momenta are the
 * derivatives of its energy by velocities; its forces follow from these by Lagrange's equations, where rates of angular velocities are
 * not those of coordinates: d/dt(dT/dw) + dT/dw x w - dT/d(turn); momentum and angular momentum are kept. */
static void check_inertia(const lw_super *s, lw_beam_node *node, const lw_vec3 *a)
{
    enum { N = INERTIA_NODES, ROWS = 6*N };
    const double h = 1e-5;
    double force[ROWS], p[3][ROWS];
    lw_beam_node near[N];
    double energy = lw_super_inertia(s, node, a, force, p[0]), twice = 0;
    for (int way = 0; way < 2; way++) {
        move_nodes(N, node, a, way ? h : -h, near);
        lw_super_inertia(s, near, NULL, NULL, p[1 + way]);
    }
    lw_vec3 pull = { 0, 0, 0 }, twist = { 0, 0, 0 }, rates[2] = { { 0, 0, 0 }, { 0, 0, 0 } };
    for (int c = 0; c < ROWS; c++) {
        double by_v[2], by_x[2];
        lw_beam_node *k = &node[c/6], old = *k;
        for (int way = 0; way < 2; way++) {
            lw_vec3 by = lw_v3_scale(lw_v3(c%3 == 0, c%3 == 1, c%3 == 2), way ? h : -h);
            *(c%6 < 3 ? &k->v : &k->omega) = lw_v3_add(c%6 < 3 ? old.v : old.omega, by);
            by_v[way] = lw_super_inertia(s, node, NULL, NULL, NULL);
            *k = old;
            if (c%6 < 3)
                k->at = lw_v3_add(old.at, by);
            else
                k->turn = lw_quaternion_matrix(lw_quaternion_times(lw_quaternion_of_vector(by), lw_quaternion_of_matrix(&old.turn)));
            by_x[way] = lw_super_inertia(s, node, NULL, NULL, NULL);
            *k = old;
        }
        CHECK_NEAR(p[0][c], (by_v[1] - by_v[0])/(2*h), 1e-8, 0);
        const double *q = p[0] + 6*(c/6) + 3, w[3] = { old.omega.x, old.omega.y, old.omega.z };
        double across = c%6 < 3 ? 0 : q[(c + 1)%3]*w[(c + 2)%3] - q[(c + 2)%3]*w[(c + 1)%3];
        CHECK_NEAR(force[c], (p[2][c] - p[1][c])/(2*h) + across - (by_x[1] - by_x[0])/(2*h), 1e-7, 0);
        twice += p[0][c]*(c%6 < 3 ? c%3 == 0 ? old.v.x : c%3 == 1 ? old.v.y : old.v.z : w[c%3]);
    }
    CHECK_NEAR(twice, 2*energy, 1e-12, 0);
    for (int i = 0; i < N; i++) {
        const double *f = force + 6*i, *now = p[0] + 6*i;
        pull = lw_v3_add(pull, lw_v3(f[0], f[1], f[2]));
        twist = lw_v3_add(twist, lw_v3_add(lw_v3(f[3], f[4], f[5]), lw_v3_cross(node[i].at, lw_v3(f[0], f[1], f[2]))));
        for (int way = 0; way < 2; way++) {
            const double *m = p[1 + way] + 6*i;
            lw_vec3 push = lw_v3_scale(lw_v3(m[0], m[1], m[2]), (way ? 1 : -1)/(2*h)), spin = lw_v3_scale(lw_v3(m[3], m[4], m[5]), (way ? 1 : -1)/(2*h));
            rates[0] = lw_v3_add(rates[0], push);
            rates[1] = lw_v3_add(rates[1], lw_v3_add(spin, lw_v3_cross(node[i].at, push)));
        }
        rates[1] = lw_v3_add(rates[1], lw_v3_cross(node[i].v, lw_v3(now[0], now[1], now[2])));
    }
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(pull, rates[0])), 0, 1e-7, 0);
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(twist, rates[1])), 0, 1e-7, 0);
}

TEST(superelement_inertia)
{
    enum { N = INERTIA_NODES, ROWS = 6*N };
    double stiffness[ROWS*ROWS], rate[ROWS*ROWS], parts[9*ROWS*ROWS], first[3*ROWS] = { 0 }, lump[N] = { 0 };
    lw_vec3 at[N], a[2*N];
    lw_mat3 turn[N];
    lw_beam_node node[N];
    OWN(lw_super) s = { 0 };
    lw_rng rng = check_rng(0);
    for (int i = 0; i < 9*ROWS*ROWS; i++) {
        int k = i/(ROWS*ROWS), row = i/ROWS%ROWS, column = i%ROWS;
        parts[i] = k > 2 && row > column ? parts[k*ROWS*ROWS + column*ROWS + row] : lw_rng_range(&rng, -1, 1);
        if (k == 0)
            rate[i] = row > column ? rate[column*ROWS + row] : lw_rng_range(&rng, -1, 1), stiffness[i] = 0;
    }
    for (int i = 0; i < N; i++) {
        double x[15];
        for (int k = 0; k < 15; k++)
            x[k] = lw_rng_range(&rng, -.4, .4);
        at[i] = i == 3 ? at[0] : lw_v3(i, x[0], x[1]);
        turn[i] = lw_quaternion_matrix(lw_quaternion_of_vector(lw_v3(x[2], x[3], x[4])));
        node[i] = (lw_beam_node){ .at = lw_v3_add(at[i], lw_v3(x[5], x[6], x[7])), .v = lw_v3(x[8], x[9], 5*x[10]), .omega = lw_v3(x[11], 5*x[12], x[13]) };
        lw_quaternion about = lw_quaternion_of_vector(lw_v3(2 + x[14], x[1], x[2]));
        node[i].turn = lw_quaternion_matrix(lw_quaternion_times(about, lw_quaternion_of_matrix(&turn[i])));
        a[2*i] = lw_v3(3*x[3], -x[6], x[9]), a[2*i + 1] = lw_v3(x[1], 4*x[8], -x[12]);
    }
    lw_superelement own = { .n = N, .n_bound = 3, .at = at, .stiffness = stiffness, .rate = rate, .turn = parts, .first = first, .lump = lump };
    CHECK_INT(lw_super_make(&own, turn, lw_v3(0, 0, 0), &s), LW_OK);
    for (int still = 0; still < 2; still++) {
        if (still)                           /* the frame does not turn, but strains and node 1 do */
            node[s.a].omega = node[s.b].omega = lw_v3(0, 0, 0);
        check_inertia(&s, node, a);
    }
}

/* Matrices that are no body's are refused, each with what is wrong: a skew stiffness; an indefinite one; a body that is fixed somewhere; a
 * mass that differs from one direction to the other; an indefinite mass; a matrix of another size. */
TEST(bad_matrices)
{
    static const char *const says[] = { "is not symmetric", "a displacement with negative energy", "resists a motion of the whole body",
                                        "differs from one direction to the other", "not positive definite", "has 18 rows" };
    OWN(lw_spatial) m = { 0 };
    OWN(lw_spatial_expansion) x = { 0 };
    char path[2][300], text[1000];
    read_bar(&m, BAR ", 'segments': 4, 'superelements': 1", 0, 0);
    CHECK_OK(lw_spatial_expand(&m, false, &x, &check_error));
    for (int i = 0; i < 2; i++)
        snprintf(path[i], sizeof path[i], "%s/bad-%s.mtx", temporary_folder(), i ? "mass" : "stiffness");
    for (int k = 0; k < 6; k++) {
        double a[2][18*18] = { { 0 } }, *K = a[0], *M = a[1];
        memcpy(K, x.model.super[0].stiffness, 144*sizeof *K);
        memcpy(M, x.model.super[0].rate, 144*sizeof *M);
        double most = K[0];
        if (k == 0)
            K[1] += 1e-3*most;
        for (int i = 0; k == 1 && i < 144; i++)
            K[i] = -K[i];
        if (k == 2)
            K[0] += most;
        if (k == 3)
            M[0] *= 1.1;
        if (k == 4)
            M[13*3 + 6] += 2*M[13*3], M[13*9 - 6] += 2*M[13*3];
        write_matrix(path[0], k == 5 ? 18 : 12, K);
        write_matrix(path[1], 12, M);
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {'nodes': [[0, 0, 0], [2, 0, 0]], 'stiffness': "
                 "'%s', 'mass': '%s'}}], 'joints': [{'name': 'A', 'kind': 'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}]}", path[0], path[1]);
        OWN(lw_spatial) bad = { 0 };
        CHECK_FAILS(read_text(&bad, &check_error, "%s", text), LW_E_NOTATION, says[k]);
    }
}
