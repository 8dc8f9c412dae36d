/* base/sum.h - a sum of four numbers with the error of a single rounding, for differences that nearly cancel. */
#ifndef LW_BASE_SUM_H
#define LW_BASE_SUM_H

/* w + x + y + z with the rounding errors of the additions added back (Knuth's two-sum; Ogita, Rump & Oishi 2005).
 * Do not compile with reassociation. */
static inline double lw_sum4(double w, double x, double y, double z)
{
    double term[3] = { x, y, z }, s = w, lost = 0.0;
    for (int i = 0; i < 3; i++) {
        double t = s + term[i], v = t - s;
        lost += (s - (t - v)) + (term[i] - v);
        s = t;
    }
    return s + lost;
}

#endif
