/* The loops somebody would write by hand for one linkage each; included once per instruction set with
 * HAND(name) and TARGET defined. */

/* Four-bar coupler point over input angles. */
TARGET static void HAND(fourbar_angles)(size_t n, const double *restrict c, const double *restrict s, const double *g,
                                        double mode, double *restrict x, double *restrict y)
{
    const double r1 = g[0], r2 = g[1], r3 = g[2], r4 = g[3], cx = g[4], cy = g[5], x0 = g[6], y0 = g[7];
    const double ct = cos(g[8]), st = sin(g[8]), sum = r3 + r4, dif = r3 - r4;
    for (size_t i = 0; i < n; i++) {
        double ax = r2*c[i], ay = r2*s[i], dx = r1 - ax, dy = -ay, d2 = dx*dx + dy*dy;
        double h = (sum*sum - d2)*(d2 - dif*dif), p = d2 + sum*dif, q = mode*sqrt(h > 0 ? h : 0), t = 0.5/(d2*r3);
        double u = (dx*p - dy*q)*t, v = (dx*q + dy*p)*t;
        double px = ax + cx*u - cy*v, py = ay + cx*v + cy*u;
        x[i] = x0 + ct*px - st*py;
        y[i] = y0 + st*px + ct*py;
    }
}

/* The same over candidates (place and turn left out, as in lw_batch_frame; crank at c, s). */
TARGET static void HAND(fourbar_candidates)(size_t n, const double *restrict c, const double *restrict s,
                                            const double *restrict g, size_t ld, const double *restrict mode,
                                            double *restrict ox, double *restrict oy, double *restrict ux, double *restrict uy)
{
    const double *restrict r1 = g, *restrict r2 = g + ld, *restrict r3 = g + 2*ld, *restrict r4 = g + 3*ld;
    for (size_t i = 0; i < n; i++) {
        double ax = r2[i]*c[i], ay = r2[i]*s[i], dx = r1[i] - ax, dy = -ay, d2 = dx*dx + dy*dy;
        double sum = r3[i] + r4[i], dif = r3[i] - r4[i];
        double h = (sum*sum - d2)*(d2 - dif*dif), p = d2 + sum*dif, q = mode[i]*sqrt(h > 0 ? h : 0), t = 0.5/(d2*r3[i]);
        ox[i] = ax;
        oy[i] = ay;
        ux[i] = (dx*p - dy*q)*t;
        uy[i] = (dx*q + dy*p)*t;
    }
}

/* Candidates with everything of their own, place and turn too; the library's cosine and sine. */
TARGET static void HAND(fourbar_places)(size_t n, const double *restrict c, const double *restrict s,
                                        const double *restrict g, size_t ld, const double *restrict mode,
                                        double *restrict x, double *restrict y)
{
    const double *restrict r1 = g, *restrict r2 = g + ld, *restrict r3 = g + 2*ld, *restrict r4 = g + 3*ld;
    const double *restrict cx = g + 4*ld, *restrict cy = g + 5*ld, *restrict x0 = g + 6*ld, *restrict y0 = g + 7*ld;
    for (size_t i = 0; i < n; i++) {
        double ax = r2[i]*c[i], ay = r2[i]*s[i], dx = r1[i] - ax, dy = -ay, d2 = dx*dx + dy*dy;
        double sum = r3[i] + r4[i], dif = r3[i] - r4[i];
        double h = (sum*sum - d2)*(d2 - dif*dif), p = d2 + sum*dif, q = mode[i]*sqrt(h > 0 ? h : 0), t = 0.5/(d2*r3[i]);
        double u = (dx*p - dy*q)*t, v = (dx*q + dy*p)*t;
        double px = ax + cx[i]*u - cy[i]*v, py = ay + cx[i]*v + cy[i]*u, ct = cos(g[8*ld + i]), st = sin(g[8*ld + i]);
        x[i] = x0[i] + ct*px - st*py;
        y[i] = y0[i] + st*px + ct*py;
    }
}

TARGET static void HAND(slidercrank_angles)(size_t n, const double *restrict c, const double *restrict s, const double *g,
                                            double mode, double *restrict x, double *restrict y)
{
    const double r2 = g[0], r3 = g[1], e1 = g[2], cx = g[3], cy = g[4], x0 = g[5], y0 = g[6];
    const double ct = cos(g[7]), st = sin(g[7]), inv = 1/r3;
    for (size_t i = 0; i < n; i++) {
        double ax = r2*c[i], ay = r2*s[i], away = e1 - ay, h = (r3 - away)*(r3 + away);
        double u = mode*sqrt(h > 0 ? h : 0)*inv, v = away*inv;
        double px = ax + cx*u - cy*v, py = ay + cx*v + cy*u;
        x[i] = x0 + ct*px - st*py;
        y[i] = y0 + st*px + ct*py;
    }
}

TARGET static void HAND(inverted_angles)(size_t n, const double *restrict c, const double *restrict s, const double *g,
                                         double mode, double *restrict x, double *restrict y)
{
    const double r1 = g[0], r2 = g[1], e = g[2], cx = g[3], cy = g[4], x0 = g[5], y0 = g[6];
    const double ct = cos(g[7]), st = sin(g[7]);
    for (size_t i = 0; i < n; i++) {
        double ax = r2*c[i], ay = r2*s[i], dx = r1 - ax, dy = -ay, d2 = dx*dx + dy*dy, h = d2 - e*e;
        double t = mode*sqrt(h > 0 ? h : 0), inv = 1/d2;
        double u = (dx*t + dy*e)*inv, v = (dy*t - dx*e)*inv;
        double px = ax + cx*u - cy*v, py = ay + cx*v + cy*u;
        x[i] = x0 + ct*px - st*py;
        y[i] = y0 + st*px + ct*py;
    }
}

/* Where two circles meet, on the left (mode 1) or right of the line from a to b. */
TARGET static inline void HAND(circles)(double ax, double ay, double bx, double by, double r1, double r2, double mode, double *x, double *y)
{
    double dx = bx - ax, dy = by - ay, d2 = dx*dx + dy*dy, sum = r1 + r2, dif = r1 - r2;
    double h = (sum*sum - d2)*(d2 - dif*dif), t = 0.5/d2, p = (d2 + sum*dif)*t, q = mode*sqrt(h > 0 ? h : 0)*t;
    *x = ax + dx*p - dy*q;
    *y = ay + dx*q + dy*p;
}

/* Six-bars: a four-bar A B C D with E on its coupler and a dyad E F G, the tracer on E F.  G on the ground (Stephenson III)
 * or on the rocker (Watt I).  p: AB BC CD, D, E on BC, EF FG, tracer on EF, G (on the ground, or on DC); modes of C, F. */
TARGET static void HAND(sixbar_angles)(size_t n, const double *restrict c, const double *restrict s, const double *p,
                                       int watt, double *restrict x, double *restrict y)
{
    const double r2 = p[0], r3 = p[1], r4 = p[2], dx = p[3], dy = p[4], ex = p[5]/r3, ey = p[6]/r3, r5 = p[7], r6 = p[8];
    const double tx = p[9]/r5, ty = p[10]/r5, gx = p[11], gy = p[12], mode_c = p[13], mode_f = p[14], hx = gx/r4, hy = gy/r4;
    for (size_t i = 0; i < n; i++) {
        double bx = r2*c[i], by = r2*s[i], cx, cy, fx, fy;
        HAND(circles)(bx, by, dx, dy, r3, r4, mode_c, &cx, &cy);
        double ux = cx - bx, uy = cy - by, px = bx + ex*ux - ey*uy, py = by + ex*uy + ey*ux;
        double vx = cx - dx, vy = cy - dy, qx = watt ? dx + hx*vx - hy*vy : gx, qy = watt ? dy + hx*vy + hy*vx : gy;
        HAND(circles)(px, py, qx, qy, r5, r6, mode_f, &fx, &fy);
        double wx = fx - px, wy = fy - py;
        x[i] = px + tx*wx - ty*wy;
        y[i] = py + tx*wy + ty*wx;
    }
}

/* Jansen's leg by bars: r = a b c d e f g h i j k l m; the foot. */
TARGET static void HAND(jansen_angles)(size_t n, const double *restrict c, const double *restrict s, const double *r,
                                       double *restrict x, double *restrict y)
{
    const double gx = -r[0], gy = -r[11];
    for (size_t i = 0; i < n; i++) {
        double ax = r[12]*c[i], ay = r[12]*s[i], x2, y2, x3, y3, x4, y4, x5, y5;
        HAND(circles)(ax, ay, gx, gy, r[9], r[1], -1, &x2, &y2);
        HAND(circles)(x2, y2, gx, gy, r[4], r[3], -1, &x3, &y3);
        HAND(circles)(ax, ay, gx, gy, r[10], r[2], 1, &x4, &y4);
        HAND(circles)(x3, y3, x4, y4, r[5], r[6], -1, &x5, &y5);
        HAND(circles)(x4, y4, x5, y5, r[8], r[7], 1, &x[i], &y[i]);
    }
}

/* Sum of squared distances and its gradient by nine dimensions: one sweep, ten times eight accumulators. */
TARGET static double HAND(fourbar_sum)(size_t n, const double *restrict c, const double *restrict s, const double *g,
                                       double mode, const double *restrict tx, const double *restrict ty, double *grad)
{
    const double r1 = g[0], r2 = g[1], r3 = g[2], r4 = g[3], cx = g[4], cy = g[5], x0 = g[6], y0 = g[7];
    const double ct = cos(g[8]), st = sin(g[8]), sum = r3 + r4, dif = r3 - r4, inv4 = 1/r4;
    double a[10][8] = { { 0 } };
    for (size_t i = 0; i < n; i += 8)
        for (size_t j = 0; j < 8; j++) {
            double cc = c[i + j], ss = s[i + j];
            double ax = r2*cc, ay = r2*ss, dx = r1 - ax, dy = -ay, d2 = dx*dx + dy*dy;
            double h = (sum*sum - d2)*(d2 - dif*dif), p = d2 + sum*dif, q = mode*sqrt(h > 0 ? h : 0), t = 0.5/(d2*r3);
            double u = (dx*p - dy*q)*t, v = (dx*q + dy*p)*t;
            double kx = cx*u - cy*v, ky = cx*v + cy*u, px = ax + kx, py = ay + ky;
            double qx = ct*px - st*py, qy = st*px + ct*py, ex = x0 + qx - tx[i + j], ey = y0 + qy - ty[i + j];
            double bx = 2*(ct*ex + st*ey), by = 2*(ct*ey - st*ex), turn = kx*by - ky*bx;
            double w = (r3*u - dx)*inv4, z = (r3*v - dy)*inv4, k = turn*2*r4/q;
            a[0][j] += k*w;
            a[1][j] += (bx - k*w)*cc + (by - k*z)*ss;
            a[2][j] -= k*(u*w + v*z);
            a[3][j] += k;
            a[4][j] += bx*u + by*v;
            a[5][j] += by*u - bx*v;
            a[6][j] += 2*ex;
            a[7][j] += 2*ey;
            a[8][j] += 2*(qx*ey - qy*ex);
            a[9][j] += ex*ex + ey*ey;
        }
    double f = 0;
    for (int d = 0; d < 10; d++) {
        double t = 0;
        for (int j = 0; j < 8; j++)
            t += a[d][j];
        if (d < 9)
            grad[d] = t;
        f = t;
    }
    return f;
}
