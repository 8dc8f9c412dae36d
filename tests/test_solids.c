/* Plates and pins as solids: STL meshes are closed and have the volume of the formula; STEP is whole, and OpenCASCADE
 * (gmsh, where it is installed) reads an assembly of solids of the same volumes. */
#include "catalogues/exchange/plates.h"

#include "tests/example_linkage.h"
#include "tests/temporary.h"

static const char *const names[] = { "hoeken", "klann", "slider-crank", "scott-russell", "jansen",
                                     "inverted-slider-crank",
                                     "chebyshev" };
#define COUNT (sizeof names/sizeof *names)

/* Area of a convex polygon widened by r (Steiner): A + r L + pi r^2; a bar counts its length twice. */
static double widened(const lw_vec2 *p, int n, double r)
{
    double area = 0, length = 0;
    for (int i = 0; i < n; i++) {
        lw_vec2 b = p[(i + 1) % n];
        area += lw_v2_cross(p[i], b)/2;
        length += lw_v2_norm(lw_v2_sub(b, p[i]));
    }
    return area + r*length + LW_PI*r*r;
}

/* Volume of slab i in mm^3 by the formula. */
static double volume(const lw_plates *w, int i)
{
    const lw_layers *l = &w->layers;
    int n_link = w->scene.linkage.n_link;
    if (i >= n_link) {
        const lw_pin *p = &l->pin[i - n_link];
        double high = (p->high - p->low)*1.1*l->thickness + l->thickness;
        return 1e9*LW_PI*l->pin_radius*l->pin_radius*high;
    }
    double area = widened(l->plate[i].corner, l->plate[i].n_corner, l->radius);
    for (int h = 0; h < l->plate[i].n_hole; h++) {
        lw_vec2 ends[2] = { l->plate[i].hole[h].a, l->plate[i].hole[h].b };
        bool round = lw_v2_norm(lw_v2_sub(ends[1], ends[0])) == 0;
        area -= widened(ends, round ? 1 : 2, l->bore);
    }
    return 1e9*area*l->thickness;
}

/* ---- STL ------------------------------------------------------------------------------------------------------- */

typedef struct edge { char a[3][24], b[3][24]; } edge;

static int compare(const void *a, const void *b) { return memcmp(a, b, sizeof(edge)); }

/* Every edge of every solid is there once in each direction, and the volume is right but for chords. */
static void meshes(void)
{
    static edge all[2][60000];
    for (size_t i = 0; i < COUNT; i++) {
        lw_linkage k = example(names[i]);
        OWN(lw_bytes) b = { 0 };
        lw_plates *w;
        CHECK_SILENT(lw_export_stl(LW_VIEW(&k), NULL, &b, &check_error));
        if (lw_plates_make(LW_VIEW(&k), NULL, &w, &check_error) != LW_OK)
            continue;
        int solid = 0;
        char *at = b.data;
        for (; (at = strstr(at, "solid ")); solid++, at = strstr(at, "endsolid") + 9) {
            char *end = strstr(at, "endsolid");
            int n = 0;
            double six = 0;
            memset(all, 0, sizeof all);
            for (char *f = at; (f = strstr(f, "outer loop")) && f < end; f += 10) {
                char c[3][3][24];
                double v[3][3];
                CHECK_INT(sscanf(f, "outer loop vertex %23s %23s %23s vertex %23s %23s %23s vertex %23s %23s %23s",
                                 c[0][0],
                                 c[0][1], c[0][2], c[1][0], c[1][1], c[1][2], c[2][0], c[2][1], c[2][2]), 9);
                for (int p = 0; p < 3; p++)
                    for (int d = 0; d < 3; d++)
                        v[p][d] = strtod(c[p][d], NULL);
                for (int p = 0; p < 3 && n < 60000; p++, n++)
                    for (int d = 0; d < 3; d++) {
                        strcpy(all[0][n].a[d], c[p][d]);
                        strcpy(all[0][n].b[d], c[(p + 1) % 3][d]);
                        strcpy(all[1][n].a[d], c[(p + 1) % 3][d]);
                        strcpy(all[1][n].b[d], c[p][d]);
                    }
                six += v[0][0]*(v[1][1]*v[2][2] - v[1][2]*v[2][1]) - v[0][1]*(v[1][0]*v[2][2] - v[1][2]*v[2][0])
                     + v[0][2]*(v[1][0]*v[2][1] - v[1][1]*v[2][0]);
            }
            qsort(all[0], (size_t)n, sizeof **all, compare);
            qsort(all[1], (size_t)n, sizeof **all, compare);
            CHECK(memcmp(all[0], all[1], (size_t)n*sizeof **all) == 0);
            CHECK_NEAR(six/6, volume(w, solid), 0, 3e-3);             /* 48 sides instead of a circle */
        }
        CHECK_INT(solid, lw_plates_count(w));
        lw_plates_free(w);
    }
}

/* ---- STEP ------------------------------------------------------------------------------------------------------ */

/* Each instance that is used is there, and each edge is passed once in each direction. */
static void instances(void)
{
    for (size_t i = 0; i < COUNT; i++) {
        lw_linkage k = example(names[i]);
        OWN(lw_bytes) b = { 0 };
        static int way[60000], kind[60000];
        memset(way, 0, sizeof way);
        memset(kind, 0, sizeof kind);
        CHECK_SILENT(lw_export_step(LW_VIEW(&k), NULL, &b, &check_error));
        if (!b.data)
            continue;
        for (char *line = strstr(b.data, "\n#1=") + 1; *line == '#'; line = strchr(line, '\n') + 1) {
            int id = atoi(line + 1);
            kind[id] = strncmp(strchr(line, '=') + 1, "EDGE_CURVE", 10) == 0 ? 2 : 1;
        }
        for (char *line = strstr(b.data, "\n#1=") + 1; *line == '#'; line = strchr(line, '\n') + 1) {
            char *end = strchr(line, '\n');
            for (char *c = strchr(line + 1, '#'); c && c < end; c = strchr(c + 1, '#'))
                CHECK(kind[atoi(c + 1)] > 0);
            int edge_id, n = 0;
            char direction = 0;
            sscanf(strchr(line, '=') + 1, "ORIENTED_EDGE('',*,*,#%d,.%c%n", &edge_id, &direction, &n);
            if (n > 0)
                way[edge_id] += direction == 'T' ? 1 : 100;
        }
        for (int id = 0; id < 60000; id++)
            CHECK(kind[id] == 2 ? way[id] == 101 : way[id] == 0);
    }
}

/* gmsh opens the file with OpenCASCADE and weighs the solids. */
static void independent_reader(void)
{
    for (size_t i = 0; i < COUNT; i++) {
        lw_linkage k = example(names[i]);
        OWN(lw_bytes) b = { 0 };
        lw_plates *w;
        lw_error e = { 0 };
        lw_export_options o = { .width = 0.01*lw_export_size(LW_VIEW(&k)), .clearance = 0.0005*lw_export_size(LW_VIEW(&k)) };
        char path[300], line[1200];
        if (lw_plates_make(LW_VIEW(&k), &o, &w, &e) != LW_OK || lw_export_step(LW_VIEW(&k), &o, &b, &e) != LW_OK) {
            CHECK_TEXT(e.text, "");
            continue;
        }
        snprintf(path, sizeof path, "%s/x.step", temporary_folder());
        CHECK_INT(lw_file_write(path, b.data, b.size, &e), LW_OK);
        snprintf(line, sizeof line, "cd %s && printf '%%s\\n' 'SetFactory(\"OpenCASCADE\");' 'v() = ShapeFromFile(\"x.step\");' "
                 "'For i In {0:#v()-1}' 'm = Mass Volume{v(i)}; Printf(\"volume %%.12g\", m);' 'EndFor' > x.geo && gmsh x.geo -0 -o "
                 "x.msh 2>&1", temporary_folder());
        FILE *f = popen(line, "r");
        int solid = 0;
        char text[600];
        while (f && fgets(text, sizeof text, f)) {
            double v;
            CHECK(strncmp(text, "Error", 5) != 0 && strncmp(text, "Warning", 7) != 0);
            if (sscanf(text, "volume %lf", &v) == 1 && solid < lw_plates_count(w))
                CHECK_NEAR(v, volume(w, solid++), 0, 1e-9);
        }
        if (f)
            pclose(f);
        CHECK_INT(solid, lw_plates_count(w));
        lw_plates_free(w);
    }
}

/* ---- sizes ------------------------------------------------------------------------------------------------------ */

static void sizes(void)
{
    lw_linkage k = example("hoeken");
    lw_plates *w;
    lw_export_options o = { .width = 0.008, .thickness = 0.003, .hole = 0.004, .clearance = 0.0002 };
    CHECK_OK(lw_plates_make(LW_VIEW(&k), &o, &w, &check_error));
    CHECK_NEAR(w->layers.radius, 0.004, 1e-15, 0);
    CHECK_NEAR(w->layers.bore, 0.002, 1e-15, 0);
    CHECK_NEAR(w->layers.pin_radius, 0.0019, 1e-15, 0);
    CHECK_NEAR(w->layers.thickness, 0.003, 1e-15, 0);
    lw_plates_free(w);
    o.hole = 0.009;
    CHECK_FAILS(lw_plates_make(LW_VIEW(&k), &o, &w, &check_error), LW_E_ARG, "plates 8 mm wide, holes of 9 mm");
    lw_bytes b = { 0 };
    k = example("trammel");                              /* its slots cross */
    CHECK_INT(lw_export_step(LW_VIEW(&k), NULL, &b, &check_error), LW_E_KIND);
    CHECK_INT(lw_export_stl(LW_VIEW(&k), NULL, &b, &check_error), LW_E_KIND);
    CHECK(b.data == NULL);
    k = example("hoeken");
    o = (lw_export_options){ .hole = 0.001, .clearance = 0.001 };
    CHECK_INT(lw_plates_make(LW_VIEW(&k), &o, &w, &check_error), LW_E_ARG);
}

CHECK_MAIN
{
    RUN(meshes);
    RUN(instances);
    RUN(sizes);
    if (system("command -v gmsh > /dev/null 2>&1") == 0)
        RUN(independent_reader);
    else
        puts("skipped: gmsh is not installed, which reads STEP by OpenCASCADE");
    return check_end();
}
