/* tests/scene_models.h - linkages and scenes to draw: four-bars by their dimensions, and examples/. */
#ifndef LW_TESTS_SCENE_MODELS_H
#define LW_TESTS_SCENE_MODELS_H

#include "catalogues/draw/scene.h"
#include "tests/example_linkage.h"

/* r1 r2 r3 r4 cx cy x0 y0 theta0 at the crank angle t (from the frame line); mode: side of B. */
static inline lw_linkage model_four_bar(const double r[9], double t, double mode)
{
    static const char *const link[] = { "ground", "crank", "coupler", "rocker" }, *const joint[] = { "A0", "A", "B", "B0" };
    lw_linkage k;
    fourbar_linkage(&k, r, mode, t);
    strcpy(k.name, "Four-bar");
    strcpy(k.tracer[0].name, "P");
    for (int i = 0; i < 4; i++) {
        strcpy(k.link_name[i], link[i]);
        strcpy(k.joint[i].name, joint[i]);
    }
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

#endif
