/* base/vec3.c - turns and principal axes. */
#include "base/vec3.h"

lw_quaternion lw_quaternion_of_vector(lw_vec3 angle)
{
    double a = lw_v3_norm(angle), s, c;
    sincos(a/2, &s, &c);
    double k = a > 1e-9 ? s/a : 0.5;
    return (lw_quaternion){ c, k*angle.x, k*angle.y, k*angle.z };
}

lw_vec3 lw_quaternion_vector(lw_quaternion a)
{
    lw_vec3 u = lw_v3(a.x, a.y, a.z);
    double s = lw_v3_norm(u), sign = a.w < 0 ? -1 : 1;
    return s > 1e-150 ? lw_v3_scale(u, 2*atan2(s, sign*a.w)/s*sign) : lw_v3(0, 0, 0);
}

lw_quaternion lw_quaternion_of_matrix(const lw_mat3 *m)
{
    double xx = m->row[0].x, yy = m->row[1].y, zz = m->row[2].z, t = xx + yy + zz;
    lw_vec3 d = lw_v3(m->row[2].y - m->row[1].z, m->row[0].z - m->row[2].x, m->row[1].x - m->row[0].y);
    double xy = m->row[0].y + m->row[1].x, xz = m->row[0].z + m->row[2].x, yz = m->row[1].z + m->row[2].y;
    if (t >= xx && t >= yy && t >= zz)
        return lw_quaternion_unit((lw_quaternion){ 1 + t, d.x, d.y, d.z });
    if (xx >= yy && xx >= zz)
        return lw_quaternion_unit((lw_quaternion){ d.x, 1 + xx - yy - zz, xy, xz });
    return lw_quaternion_unit(yy >= zz ? (lw_quaternion){ d.y, xy, 1 + yy - xx - zz, yz } : (lw_quaternion){ d.z, xz,
            yz, 1 + zz - xx - yy });
}

lw_vec3 lw_v3_across(lw_vec3 a)
{
    lw_vec3 e = fabs(a.x) <= fabs(a.y) && fabs(a.x) <= fabs(a.z) ? lw_v3(1, 0, 0)
              : fabs(a.y) <= fabs(a.z) ? lw_v3(0, 1, 0) : lw_v3(0, 0, 1);
    lw_vec3 b = lw_v3_cross(a, e);
    return lw_v3_scale(b, 1/lw_v3_norm(b));
}

void lw_m3_principal(const double tensor[6], double value[3], lw_mat3 *axes)
{
    double a[3][3] = { { tensor[0], tensor[3], tensor[4] }, { tensor[3], tensor[1], tensor[5] },
                       { tensor[4], tensor[5], tensor[2] } }, v[3][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    for (int sweep = 0; sweep < 30; sweep++)
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++) {
                if (fabs(a[p][q]) <= 1e-300 || fabs(a[p][q]) <= 1e-17*sqrt(fabs(a[p][p]*a[q][q])))
                    continue;
                double theta = (a[q][q] - a[p][p])/(2*a[p][q]);
                double t = (theta < 0 ? -1 : 1)/(fabs(theta) + sqrt(1 + theta*theta)), c = 1/sqrt(1 + t*t), s = t*c;
                for (int k = 0; k < 3; k++) {
                    double x = a[k][p], y = a[k][q];
                    a[k][p] = c*x - s*y, a[k][q] = s*x + c*y;
                }
                for (int k = 0; k < 3; k++) {
                    double x = a[p][k], y = a[q][k];
                    a[p][k] = c*x - s*y, a[q][k] = s*x + c*y;
                    x = v[k][p], y = v[k][q];
                    v[k][p] = c*x - s*y, v[k][q] = s*x + c*y;
                }
            }
    for (int i = 0; i < 3; i++)
        value[i] = a[i][i];
    for (int i = 0; i < 3; i++)
        axes->row[i] = lw_v3(v[i][0], v[i][1], v[i][2]);
}
