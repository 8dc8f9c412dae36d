/* Any text that names the families of a catalogue's curves: the maker of the curves gives the same text again, and
 * what it makes are linkages. */
#include <stdio.h>

#include "catalogues/curves/curves.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    static const double u[LW_CURVE_DRAWS] = { 0.5, 0.1, 0.7, 0.3, 0.9, 0.2, 0.6, 0.4 };
    char text[400];
    lw_curve_maker *m, *again;
    lw_error e = { .text = "" };
    lw_curve_row row;
    lw_linkage k;
    snprintf(text, sizeof text, "%.*s", (int)(size < sizeof text ? size : sizeof text - 1), (const char *)data);
    if (lw_curve_maker_of(text, &m, &e) != LW_OK) {
        if (!e.text[0] || m)
            abort();
        return 0;
    }
    lw_curve_work *work = NULL;
    (void)lw_curve_work_create(m, &work);
    for (int closed = 0; closed < 2 && work && *lw_curve_maker_families(m); closed++) {
        lw_vec2 p[LW_CURVE_POINTS];
        if (lw_curve_draw(m, u, closed, work, &row) == LW_OK && lw_curve_linkage(m, &row, closed, work, &k) == LW_OK
            && (lw_linkage_check(&k, &e) != LW_OK || lw_curve_points(m, &row, closed, work, p, NULL) != LW_OK))
            abort();
    }
    if (lw_curve_maker_of(lw_curve_maker_families(m), &again, &e) != LW_OK
        || strcmp(lw_curve_maker_families(m), lw_curve_maker_families(again)) != 0)
        abort();
    lw_curve_work_free(work);
    lw_curve_maker_free(m);
    lw_curve_maker_free(again);
    return 0;
}
