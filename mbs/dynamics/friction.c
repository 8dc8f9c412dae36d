#include "mbs/dynamics/friction.h"

#include <math.h>
#include <string.h>
#include "base/linalg.h"
#include "grammar/linkage.h"

double lw_friction_push(double coefficient, double speed, double arm, double rate)
{
    return -coefficient*arm*tanh(arm*rate/speed);
}

lw_status lw_friction_presses(int n, const lw_vec2 *rest, const lw_vec2 *response, double *press)
{
    double matrix[LW_JOINT_MAX*LW_JOINT_MAX], diag[LW_JOINT_MAX], left[LW_JOINT_MAX], scale = 0;
    for (int j = 0; j < n; j++) {
        press[j] = lw_v2_norm(rest[j]);
        scale = fmax(scale, press[j]);
    }
    for (int pass = 0; pass < 60; pass++) {
        double off = 0;
        for (int j = 0; j < n; j++) {
            lw_vec2 r = rest[j];
            for (int k = 0; k < n; k++)
                r = lw_v2_add(r, lw_v2_scale(response[j + n*k], press[k]));
            double size = lw_v2_norm(r);
            left[j] = size - press[j];
            off = fmax(off, fabs(left[j]));
            for (int k = 0; k < n; k++)
                matrix[j + n*k] = (j == k) - (size > 0 ? lw_v2_dot(r, response[j + n*k])/size : 0);
        }
        if (off <= 1e-13*scale)
            return LW_OK;
        lw_qr_factor(n, n, matrix, diag);
        if (!(lw_qr_determinant(n, diag) > 1e-3))
            break;
        lw_qr_solve(n, n, matrix, diag, left);
        for (int j = 0; j < n; j++) {
            press[j] = fmax(0, press[j] + left[j]);
            scale = fmax(scale, press[j]);
        }
    }
    return LW_E_NUMERIC;
}
