/* tests/example_linkage.h - the linkages of examples/, and two that are driven through slots. */
#ifndef LW_TESTS_EXAMPLE_LINKAGE_H
#define LW_TESTS_EXAMPLE_LINKAGE_H

#include "tests/mbs_linkage.h"
#include "tests/planar_models.h"

static const char *const example_names[] = {
    "hoeken", "chebyshev", "inverted-slider-crank", "jansen", "klann", "scott-russell", "slider-crank", "trammel",
    "geared-five-bar", "five-bar", "loader"
};
#define N_EXAMPLE ((int)(sizeof example_names/sizeof *example_names))

static inline lw_linkage example(const char *name)
{
    static lw_linkage k;
    char path[128];
    snprintf(path, sizeof path, "examples/%s.json", name);
    load_linkage(path, &k);
    return k;
}

/* A Scotch yoke; the bits of `order`: slider before slot, slider from the yoke to the ground. */
static inline lw_linkage scotch_yoke(int order)
{
    lw_linkage k;
    blank_linkage(&k, 3);
    add_pin(&k, 0, 1, lw_v2(0, 0));
    for (int i = 0; i < 2; i++)
        if ((order & 1) == i)
            add_slide(&k, order & 2 ? 2 : 0, order & 2 ? 0 : 2, lw_v2(0.3, 0.4), 0.2);
        else
            k.joint[add_slide(&k, 2, 1, lw_v2(0.3, 0.4), 1.5)].kind = LW_JOINT_SLOT;
    add_input(&k, 0, lw_linkage_posture_input(&k, 0));
    add_tracer(&k, 2, lw_v2(2, 3));
    return k;
}

#endif
