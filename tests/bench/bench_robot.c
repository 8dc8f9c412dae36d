/* tests/bench/bench_robot.c - a posture of the DELTA robot, 0.002 rad further, and its Jacobian: by the general rows
 * of the joints (mbs/space/robot.h), and the angles of its arms in closed form (Clavel 1991) with the Jacobian of that. */
#include <stdio.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/real.h"
#include "mbs/space/robot.h"

enum { STEPS = 400, TRIALS = 15 };

/* Angle q of arm i below the level for the tool at p, and its derivatives by p: of x cos q - z sin q = reach.  The sine and cosine of q
 * follow from those of its two parts, atan2(-z, x) and acos(reach/sqrt(x^2 + z^2)), without any angle. */
static double closed_form(int i, lw_vec3 p, double by[3])
{
    static const double arm = 0.35, bar = 0.75, apart = 0.15, cosine[] = { 1, -0.5, -0.5 };
    static const double sine[] = { 0, 0.86602540378443865, -0.86602540378443865 };
    double c = cosine[i], s = sine[i], x = c*p.x + s*p.y - apart, y = c*p.y - s*p.x, z = p.z, square = x*x + z*z;
    double reach = (square + y*y + arm*arm - bar*bar)/(2*arm), turn = sqrt(square - reach*reach);
    double cos_q = (x*reach - z*turn)/square, sin_q = (-z*reach - x*turn)/square, by_turn = 1/turn;
    double dx = (x/arm - cos_q)*by_turn, dy = y/arm*by_turn, dz = (z/arm + sin_q)*by_turn;
    by[0] = c*dx - s*dy, by[1] = s*dx + c*dy, by[2] = dz;
    return atan2(sin_q, cos_q);
}

int main(void)
{
    char *text;
    size_t size;
    static lw_spatial m;
    static lw_robot r;
    static lw_robot_pose p;
    static lw_error e;
    static lw_vec3 at[STEPS];
    static const char file[] = "examples/space/delta.json";
    double rows = INFINITY, jacobian = INFINITY, closed = INFINITY, by[3], off = 0;
    double sum = 0;                          /* of all results, so that they are computed */
    bool good = lw_file_read(file, &text, &size, &e) == LW_OK && lw_spatial_read(text, size, file, &m, &e) == LW_OK
        && lw_robot_make(&m, NULL, &r, &e) == LW_OK;
    for (int n = 0; n < TRIALS && good; n++) {
        double from = lw_clock_cpu();
        for (int i = 0; i < STEPS && good; i++) {
            double turn = 0.002*(i < STEPS/2 ? i : STEPS - i), q[3] = { turn, 0.5*turn, -0.3*turn };
            good = lw_robot_drive(&r, q, &e) == LW_OK && lw_robot_measure(&r, &p, &e) == LW_OK;
            at[i] = p.place;
        }
        rows = fmin(rows, (lw_clock_cpu() - from)/STEPS);
        from = lw_clock_cpu();
        for (int i = 0; i < STEPS && good; i++)
            good = lw_robot_measure(&r, &p, &e) == LW_OK;
        jacobian = fmin(jacobian, (lw_clock_cpu() - from)/STEPS);
        from = lw_clock_cpu();
        for (int k = 0; k < 10; k++)
            for (int i = 0; i < STEPS; i++)
                for (int leg = 0; leg < 3; leg++)
                    sum += closed_form(leg, at[i], by) + by[0] + by[1] + by[2];
        closed = fmin(closed, (lw_clock_cpu() - from)/(10*STEPS));
    }
    for (int i = 0; i < 3 && good; i++) {    /* rows of the inverse of J; drives count from the posture of the file */
        double start = closed_form(i, lw_v3(0, 0, -0.65), by);
        off = fmax(off, fabs(closed_form(i, p.place, by) - start - p.drive[i]));
        for (int j = 0; j < 3; j++)
            off = fmax(off, fabs(by[0]*p.jacobian[0][j] + by[1]*p.jacobian[1][j] + by[2]*p.jacobian[2][j] - (i == j)));
    }
    if (!good || !(off < 1e-9) || !isfinite(sum)) {
        fprintf(stderr, "%s\n", good ? "angles or Jacobians differ" : e.text);
        return 1;
    }
    printf("DELTA, posture and Jacobian: general rows %.1f us (the Jacobian and its singular values %.1f us), "
           "closed form %.2f us\n", 1e6*rows, 1e6*jacobian, 1e6*closed);
    lw_robot_free(&r);
    lw_spatial_free(&m);
    return 0;
}
