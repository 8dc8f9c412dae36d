/* base/sum.h - a short sum with the error of one rounding, for differences that nearly vanish. */
#ifndef LW_BASE_SUM_H
#define LW_BASE_SUM_H

/* w + x + y + z: what the additions lose is carried along (Knuth's two-sum; Ogita, Rump & Oishi
 * 2005).  Not to be compiled with reassociation. */
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
