/* mbs/space/kernel_vec_internal.h - vectors, screws and quaternions of several states at once, one number of each in a register. */
#ifndef LW_MBS_SPACE_KERNEL_VEC_INTERNAL_H
#define LW_MBS_SPACE_KERNEL_VEC_INTERNAL_H

#include "base/vec3.h"
#include "mbs/batch/kernel_run_internal.h"

/* As many lanes at a time as a register holds: more would go through memory. */
#if defined(__AVX512F__)
enum { WIDTH = 8 };
#elif defined(__AVX__)
enum { WIDTH = 4 };
#else
enum { WIDTH = 2 };
#endif
typedef double pack __attribute__((vector_size(8*WIDTH)));
typedef double pack_anywhere __attribute__((vector_size(8*WIDTH), aligned(8), may_alias));
typedef long long mask __attribute__((vector_size(8*WIDTH)));

LW_INLINE pack pick(const double *from) { return *(const pack_anywhere *)from; }
LW_INLINE void keep(double *to, pack v) { *(pack_anywhere *)to = v; }
LW_INLINE pack all_lanes(double v) { return v - (pack){ 0 }; }
LW_INLINE pack choose(mask m, pack yes, pack no) { return (pack)((m & (mask)yes) | (~m & (mask)no)); }
LW_INLINE pack root(pack a)
{
    for (int k = 0; k < WIDTH; k++)
        a[k] = sqrt(a[k]);
    return a;
}
LW_INLINE double least_lane(pack a)
{
    double least = a[0];
    for (int k = 1; k < WIDTH; k++)
        least = a[k] < least ? a[k] : least;
    return least;
}
LW_INLINE bool any_lane(mask m)
{
    long long some = 0;
    for (int k = 0; k < WIDTH; k++)
        some |= m[k];
    return some != 0;
}

typedef struct vec { pack x, y, z; } vec;
static const vec none;

LW_INLINE vec add(vec a, vec b) { return (vec){ a.x + b.x, a.y + b.y, a.z + b.z }; }
LW_INLINE vec sub(vec a, vec b) { return (vec){ a.x - b.x, a.y - b.y, a.z - b.z }; }
LW_INLINE vec minus(vec a) { return (vec){ -a.x, -a.y, -a.z }; }
LW_INLINE vec times(vec a, pack s) { return (vec){ s*a.x, s*a.y, s*a.z }; }
LW_INLINE pack dot(vec a, vec b) { return a.x*b.x + a.y*b.y + a.z*b.z; }
LW_INLINE vec cross(vec a, vec b) { return (vec){ a.y*b.z - a.z*b.y, a.z*b.x - a.x*b.z, a.x*b.y - a.y*b.x }; }
LW_INLINE pack by(vec a, lw_vec3 b) { return a.x*b.x + a.y*b.y + a.z*b.z; }
LW_INLINE vec fixed(lw_vec3 a) { return (vec){ all_lanes(a.x), all_lanes(a.y), all_lanes(a.z) }; }

typedef struct screw { vec turn, move; } screw;

LW_INLINE screw add_screw(screw a, screw b) { return (screw){ add(a.turn, b.turn), add(a.move, b.move) }; }
LW_INLINE screw times_screw(screw a, pack s) { return (screw){ times(a.turn, s), times(a.move, s) }; }
LW_INLINE pack dot_screw(screw a, screw b) { return dot(a.turn, b.turn) + dot(a.move, b.move); }

typedef struct quat { pack w, x, y, z; } quat;

LW_INLINE quat quat_times(quat a, quat b)
{
    return (quat){ a.w*b.w - a.x*b.x - a.y*b.y - a.z*b.z, a.w*b.x + a.x*b.w + a.y*b.z - a.z*b.y,
                   a.w*b.y - a.x*b.z + a.y*b.w + a.z*b.x, a.w*b.z + a.x*b.y - a.y*b.x + a.z*b.w };
}
LW_INLINE quat fixed_quat(lw_quaternion a) { return (quat){ all_lanes(a.w), all_lanes(a.x), all_lanes(a.y), all_lanes(a.z) }; }

LW_INLINE quat unit_quat(const double *from)
{
    quat a = { pick(from), pick(from + 8), pick(from + 16), pick(from + 24) };
    pack s = 1/root(a.w*a.w + a.x*a.x + a.y*a.y + a.z*a.z);
    return (quat){ s*a.w, s*a.x, s*a.y, s*a.z };
}

#endif
