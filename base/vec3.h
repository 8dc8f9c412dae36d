/* base/vec3.h - vectors, rotation matrices and unit quaternions of space. */
#ifndef LW_BASE_VEC3_H
#define LW_BASE_VEC3_H

#include "base/real.h"
#include "linkwright.h"     /* lw_vec3, lw_quaternion */

/* A matrix by rows; of a rotation: its columns are the turned axes. */
typedef struct lw_mat3 { lw_vec3 row[3]; } lw_mat3;

static inline lw_vec3 lw_v3(double x, double y, double z) { return (lw_vec3){ x, y, z }; }
static inline lw_vec2 lw_v3_xy(lw_vec3 a) { return (lw_vec2){ a.x, a.y }; }
static inline lw_vec3 lw_v3_add(lw_vec3 a, lw_vec3 b) { return lw_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline lw_vec3 lw_v3_sub(lw_vec3 a, lw_vec3 b) { return lw_v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline lw_vec3 lw_v3_scale(lw_vec3 a, double s) { return lw_v3(s*a.x, s*a.y, s*a.z); }
static inline double  lw_v3_dot(lw_vec3 a, lw_vec3 b) { return a.x*b.x + a.y*b.y + a.z*b.z; }
static inline lw_vec3 lw_v3_cross(lw_vec3 a, lw_vec3 b)
{
    return lw_v3(a.y*b.z - a.z*b.y, a.z*b.x - a.x*b.z, a.x*b.y - a.y*b.x);
}
static inline double  lw_v3_norm(lw_vec3 a)      /* without overflow */
{
    double m = fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
    if (!(m > 0) || !isfinite(m))
        return m;
    lw_vec3 b = lw_v3(a.x/m, a.y/m, a.z/m);
    return m*sqrt(lw_v3_dot(b, b));
}

static inline lw_vec3 lw_m3_apply(const lw_mat3 *m, lw_vec3 a)
{
    return lw_v3(lw_v3_dot(m->row[0], a), lw_v3_dot(m->row[1], a), lw_v3_dot(m->row[2], a));
}
/* the transposed matrix times a: for a rotation, the inverse */
static inline lw_vec3 lw_m3_unapply(const lw_mat3 *m, lw_vec3 a)
{
    return lw_v3(m->row[0].x*a.x + m->row[1].x*a.y + m->row[2].x*a.z,
                 m->row[0].y*a.x + m->row[1].y*a.y + m->row[2].y*a.z,
                 m->row[0].z*a.x + m->row[1].z*a.y + m->row[2].z*a.z);
}
static inline lw_mat3 lw_m3_columns(lw_vec3 x, lw_vec3 y, lw_vec3 z)
{
    return (lw_mat3){ { { x.x, y.x, z.x }, { x.y, y.y, z.y }, { x.z, y.z, z.z } } };
}
static inline lw_vec3 lw_m3_column(const lw_mat3 *m, int i)
{
    return i == 0 ? lw_v3(m->row[0].x, m->row[1].x, m->row[2].x) : i == 1 ? lw_v3(m->row[0].y, m->row[1].y, m->row[2].y)
                  : lw_v3(m->row[0].z, m->row[1].z, m->row[2].z);
}

static inline lw_mat3 lw_m3_times(const lw_mat3 *a, const lw_mat3 *b)
{
    return lw_m3_columns(lw_m3_apply(a, lw_m3_column(b, 0)), lw_m3_apply(a, lw_m3_column(b, 1)), lw_m3_apply(a, lw_m3_column(b, 2)));
}

/* the turn b, then the turn a */
static inline lw_quaternion lw_quaternion_times(lw_quaternion a, lw_quaternion b)
{
    return (lw_quaternion){ a.w*b.w - a.x*b.x - a.y*b.y - a.z*b.z, a.w*b.x + a.x*b.w + a.y*b.z - a.z*b.y,
                      a.w*b.y - a.x*b.z + a.y*b.w + a.z*b.x, a.w*b.z + a.x*b.y - a.y*b.x + a.z*b.w };
}
static inline lw_quaternion lw_quaternion_inverse(lw_quaternion a) { return (lw_quaternion){ a.w, -a.x, -a.y, -a.z }; }
static inline lw_quaternion lw_quaternion_unit(lw_quaternion a)
{
    double n = sqrt(a.w*a.w + a.x*a.x + a.y*a.y + a.z*a.z);
    return (lw_quaternion){ a.w/n, a.x/n, a.y/n, a.z/n };
}
/* a or -a, which are the same rotation: the one nearer to `before`; the one with w >= 0 where both are as near, or `before` is 0 */
static inline lw_quaternion lw_quaternion_beside(lw_quaternion before, lw_quaternion a)
{
    double same = before.w*a.w + before.x*a.x + before.y*a.y + before.z*a.z;
    return (same != 0 ? same : a.w) < 0 ? (lw_quaternion){ -a.w, -a.x, -a.y, -a.z } : a;
}
/* the matrix of a quaternion of any length but 0 */
static inline lw_mat3 lw_quaternion_matrix(lw_quaternion a)
{
    double s = 2/(a.w*a.w + a.x*a.x + a.y*a.y + a.z*a.z);
    double xx = s*a.x*a.x, yy = s*a.y*a.y, zz = s*a.z*a.z, xy = s*a.x*a.y, xz = s*a.x*a.z, yz = s*a.y*a.z;
    double wx = s*a.w*a.x, wy = s*a.w*a.y, wz = s*a.w*a.z;
    return (lw_mat3){ { { 1 - yy - zz, xy - wz, xz + wy }, { xy + wz, 1 - xx - zz, yz - wx }, { xz - wy, yz + wx,
            1 - xx - yy } } };
}

/* The turn by a vector, whose length is the angle [rad]. */
lw_quaternion lw_quaternion_of_vector(lw_vec3 angle);
/* The inverse: the vector of a turn, of length at most pi. */
lw_vec3 lw_quaternion_vector(lw_quaternion a);
/* The turn of a rotation matrix. */
lw_quaternion lw_quaternion_of_matrix(const lw_mat3 *m);
/* A unit vector across the unit vector a. */
lw_vec3 lw_v3_across(lw_vec3 a);

/* Principal values and axes of a symmetric matrix (xx, yy, zz, xy, xz, yz) by Jacobi's method: axes is a rotation whose
 * columns belong to value[0..2].  A diagonal matrix keeps its axes. */
void lw_m3_principal(const double tensor[6], double value[3], lw_mat3 *axes);

#endif
