/* tests/scene_models.h - linkages and scenes to draw: four-bars by their dimensions, and examples/. */
#ifndef LW_TESTS_SCENE_MODELS_H
#define LW_TESTS_SCENE_MODELS_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/file.h"
#include "catalogues/draw/scene.h"

/* Fontconfig keeps its settings until the process ends; leak checkers are told to ignore them. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }

static inline void model_joint(lw_linkage *k, const char *name, int a, int b, lw_vec2 at)
{
    lw_joint *j = &k->joint[k->n_joint++];
    *j = (lw_joint){ .kind = LW_JOINT_REVOLUTE, .link = { a, b }, .at = at };
    strcpy(j->name, name);
}

/* r1 r2 r3 r4 cx cy x0 y0 theta0 at the crank angle t (from the frame line); mode: side of B. */
static inline lw_linkage model_four_bar(const double r[9], double t, double mode)
{
    lw_linkage k = { .n_link = 4, .n_input = 1, .n_tracer = 1, .units = lw_units_si() };
    static const char *const names[] = { "ground", "crank", "coupler", "rocker" };
    for (int i = 0; i < 4; i++)
        strcpy(k.link_name[i], names[i]);
    strcpy(k.name, "Four-bar");
    lw_vec2 a0 = lw_v2(r[6], r[7]), b0 = lw_v2_add(a0, lw_v2_polar(r[0], r[8]));
    lw_vec2 a = lw_v2_add(a0, lw_v2_polar(r[1], r[8] + t)), d = lw_v2_sub(b0, a);
    double l = lw_v2_norm(d), x = (r[2]*r[2] - r[3]*r[3] + l*l)/(2*l);
    lw_vec2 u = lw_v2_scale(d, 1/l), y = lw_v2_scale(lw_v2_perp(u), mode*sqrt(r[2]*r[2] - x*x));
    lw_vec2 b = lw_v2_add(a, lw_v2_add(lw_v2_scale(u, x), y));
    lw_vec2 c = lw_v2_scale(lw_v2_sub(b, a), 1/r[2]);
    model_joint(&k, "A0", 0, 1, a0);
    model_joint(&k, "A", 1, 2, a);
    model_joint(&k, "B", 2, 3, b);
    model_joint(&k, "B0", 0, 3, b0);
    strcpy(k.tracer[0].name, "P");
    k.tracer[0].link = 2;
    k.tracer[0].at = lw_v2_add(a, lw_v2_turn(lw_v2(r[4], r[5]), c));
    k.input[0].value = r[8] + t;
    return k;
}

static const double model_crank_rocker[9] = { 2, 1, 2.5, 2.4, 1.5, 1.2, 0.3, -0.2, 0.2 };

/* The scene of the crank-rocker with n target points on its curve (beginning at the posture). */
static inline lw_status model_scene(const char *title, size_t n, lw_scene *s)
{
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    lw_scene_options o = lw_scene_options_default();
    o.title = title;
    lw_error e;
    lw_status st = lw_scene_make(&k, NULL, &o, s, &e);
    if (st != LW_OK || n == 0)
        return st;
    s->station = calloc(n, sizeof *s->station);
    s->n_station = n;
    for (size_t i = 0; i < n; i++)
        s->station[i] = s->curve[0].p[i*s->curve[0].n/n];
    return LW_OK;
}

static const char *const model_files[] = {
    "chebyshev", "hoeken", "inverted-slider-crank", "jansen", "scott-russell", "slider-crank", "trammel",
};
#define MODEL_FILES (sizeof model_files/sizeof *model_files)

static inline lw_status model_read(const char *name, lw_linkage *k)
{
    char path[128], *content;
    size_t size;
    lw_error e = { .status = LW_OK };
    snprintf(path, sizeof path, "examples/%s.json", name);
    lw_status st = lw_file_read(path, &content, &size, &e);
    if (st == LW_OK) {
        st = lw_linkage_read(content, size, path, k, &e);
        free(content);
    }
    if (st != LW_OK)
        fprintf(stderr, "%s: %s\n", path, e.text);
    return st;
}
#endif
