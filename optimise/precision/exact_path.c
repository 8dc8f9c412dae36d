/* optimise/precision/exact_path.c - a four-bar through six to nine points of a path, from one near it.
 *
 * The unknowns are the pins and the coupler's angles at the points; each guide keeps its length at each point.  These
 * are 2 (n - 1) equations for 8 + n - 1 unknowns, a square system for nine points.  With fewer points Newton's method
 * takes the shortest step that meets the equations (Ben-Israel 1966), so free dimensions stay near their first
 * values. */
#include "optimise/precision/exact_internal.h"

#include <string.h>
#include "base/linalg.h"

enum { EQUATIONS = 16, PASSES = 40 };
#define LEAST_LINK 1e-5      /* of the coupler and the frame, sizes of the path                            */

/* Rows of a guide: the error of the distance of its pins at the points, over that distance. */
static void guide_rows(size_t n, const lw_vec2 *step, const lw_vec2 *pin, const double *turn, int first, int column,
                       double *f, double (*m)[EQUATIONS])
{
    lw_vec2 x = pin[0], a = pin[1], link = lw_v2_sub(x, a);
    double scale = 1/lw_v2_norm(link);
    for (int j = 0; j + 1 < (int)n; j++) {
        lw_vec2 e = lw_v2_polar(1, turn[j]), ex = lw_v2_turn(x, e), q = lw_v2_sub(lw_v2_add(step[j], ex), a);
        lw_vec2 by_x = lw_v2_sub(lw_v2_unturn(q, e), link), by_a = lw_v2_sub(link, q);
        int i = first + j;
        f[i] = 0.5*scale*lw_v2_dot(lw_v2_sub(q, link), lw_v2_add(q, link));
        memset(m[i], 0, sizeof m[i]);
        m[i][column] = scale*by_x.x;
        m[i][column + 1] = scale*by_x.y;
        m[i][column + 2] = scale*by_a.x;
        m[i][column + 3] = scale*by_a.y;
        m[i][8 + j] = scale*lw_v2_dot(q, lw_v2_perp(ex));
    }
}

/* The step z with m z = f: by QR when m is square, else the shortest, m^T (m m^T)^-1 f. */
static bool newton_step(int rows, int columns, double (*m)[EQUATIONS], double *f, double *z)
{
    double a[EQUATIONS*EQUATIONS], d[EQUATIONS], w[EQUATIONS];
    bool square = rows == columns;
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < rows; k++) {
            double s = square ? m[i][k] : 0;
            for (int c = 0; c < columns && !square; c++)
                s += m[i][c]*m[k][c];
            a[i + rows*k] = s;
        }
    if (!(lw_qr_factor(rows, rows, a, d) > (square ? 0 : 1e-15)))
        return false;
    memcpy(w, f, sizeof w);
    lw_qr_solve(rows, rows, a, d, w);
    for (int c = 0; c < columns; c++) {
        z[c] = square ? w[c] : 0;
        for (int i = 0; i < rows && !square; i++)
            z[c] += m[i][c]*w[i];
    }
    return true;
}

bool lw_path_settle(size_t n, const lw_vec2 *step, lw_vec2 pin[4], double *angle)
{
    int rows = 2*((int)n - 1), columns = 8 + (int)n - 1;
    double before = INFINITY;
    for (int pass = 0; pass < PASSES; pass++) {
        double m[EQUATIONS][EQUATIONS], f[EQUATIONS], z[EQUATIONS], size = 0;
        guide_rows(n, step, pin, angle + 1, 0, 0, f, m);
        guide_rows(n, step, pin + 2, angle + 1, rows/2, 4, f, m);
        if (!newton_step(rows, columns, m, f, z))
            return false;
        for (int c = 0; c < columns; c++)
            size = fmax(size, fabs(z[c]));
        if (!(size < INFINITY) || (before < 1e-6 && !(size < 0.5*before)))
            break;
        double part = size > 0.3 ? 0.3/size : 1;              /* far away the step is a direction only        */
        for (int i = 0; i < 4; i++)
            pin[i] = lw_v2_sub(pin[i], lw_v2_scale(lw_v2(z[2*i], z[2*i + 1]), part));
        for (int j = 0; j + 1 < (int)n; j++)
            angle[j + 1] -= part*z[8 + j];
        before = size;
    }
    /* two guides that became one let the coupler turn: no linkage */
    lw_vec2 coupler = lw_v2_sub(pin[0], pin[2]), frame = lw_v2_sub(pin[1], pin[3]);
    return before < 1e-9 && lw_v2_norm(coupler) > LEAST_LINK && lw_v2_norm(frame) > LEAST_LINK;
}
