#include "mbs/space/star_volume.h"

#include <limits.h>

#include "base/growable_array.h"
#include "base/key_table.h"
#include "base/real.h"

typedef struct ray {
    int     from[2];                             /* rays between which it lies, the lesser first: its key; of the first six {-1, own index} */
    lw_vec3 direction, end;
} ray;

typedef struct face {
    int    corner[3], middle[3];                 /* rays, counter-clockwise from outside; middle i lies opposite corner i */
    double volume;                               /* four pyramids, and a third of what they have more than one */
    double error;                                /* its part of the change of the volume by the last division */
} face;

typedef struct search {
    lw_star_reach *reach;
    void          *context;
    ray           *ray;
    face          *face;
    int            n_ray, ray_room, n_face, face_room;
    lw_key_table   by_parents;
} search;

/* A new ray; returns its index, -1: *s says why not. */
static int cast(search *x, int a, int b, lw_vec3 direction, lw_status *s)
{
    double far = 0;
    ray *more = lw_array_grow(x->ray, x->n_ray, &x->ray_room, sizeof *more);
    *s = more ? LW_OK : LW_E_MEMORY;
    if (!more)
        return -1;
    x->ray = more;
    if ((*s = x->reach(x->context, direction, &far)) != LW_OK)
        return -1;
    ray new = { { a, b }, direction, lw_v3_scale(direction, far) };
    if (!lw_key_table_add(&x->by_parents, new.from, sizeof new.from, x->n_ray)) {
        *s = LW_E_MEMORY;
        return -1;
    }
    x->ray[x->n_ray] = new;
    return x->n_ray++;
}

/* The ray in the middle between two, which the neighbouring face may have cast before. */
static int between(search *x, int a, int b, lw_status *s)
{
    int key[] = { a < b ? a : b, a < b ? b : a };
    int known = lw_key_table_find(&x->by_parents, x->ray, sizeof *x->ray, key, sizeof key);
    lw_vec3 sum = lw_v3_add(x->ray[a].direction, x->ray[b].direction);
    return known >= 0 ? known : cast(x, key[0], key[1], lw_v3_scale(sum, 1/lw_v3_norm(sum)), s);
}

static double pyramid(const search *x, int a, int b, int c)
{
    return lw_v3_dot(x->ray[a].end, lw_v3_cross(x->ray[b].end, x->ray[c].end))/6;
}

static lw_status fill_face(search *x, int at, int a, int b, int c)
{
    face f = { .corner = { a, b, c } };
    lw_status s = LW_OK;
    for (int i = 0; i < 3; i++)
        if ((f.middle[i] = between(x, f.corner[(i + 1)%3], f.corner[(i + 2)%3], &s)) < 0)
            return s;
    const int *m = f.middle;
    double four = pyramid(x, m[0], m[1], m[2]) + pyramid(x, a, m[2], m[1]) + pyramid(x, b, m[0], m[2]) + pyramid(x, c, m[1], m[0]);
    f.volume = four + (four - pyramid(x, a, b, c))/3;
    x->face[at] = f;
    return s;
}

/* Four faces in place of one. */
static lw_status divide(search *x, int at)
{
    for (int i = 0; i < 3; i++) {
        face *more = lw_array_grow(x->face, x->n_face + i, &x->face_room, sizeof *more);
        if (!more)
            return LW_E_MEMORY;
        x->face = more;
    }
    face f = x->face[at];
    const int *m = f.middle;
    int first = x->n_face, part[] = { at, first, first + 1, first + 2 };
    lw_status s = fill_face(x, at, m[0], m[1], m[2]);
    for (int i = 0; i < 3 && s == LW_OK; i++)
        s = fill_face(x, x->n_face++, f.corner[i], m[(i + 2)%3], m[(i + 1)%3]);
    double sum = 0;
    for (int i = 0; i < 4 && s == LW_OK; i++)
        sum += x->face[part[i]].volume;
    for (int i = 0; i < 4 && s == LW_OK; i++)
        x->face[part[i]].error = fabs(sum - f.volume)/4;
    return s;
}

/* Divide the faces whose error is above `least`, and none once there are `most` rays. */
static lw_status divide_all(search *x, double least, int most)
{
    lw_status s = LW_OK;
    for (int i = 0, n = x->n_face; i < n && s == LW_OK && x->n_ray < most; i++)
        if (x->face[i].error > least)
            s = divide(x, i);
    return s;
}

/* An octahedron whose axes lie askew: the edge of a robot's workspace is often symmetric about the axes of the ground. */
static lw_status begin(search *x)
{
    lw_status s = LW_OK;
    lw_mat3 axes = lw_quaternion_matrix(lw_quaternion_of_vector(lw_v3(0.3, 0.7, -0.4)));
    for (int i = 0; i < 6 && s == LW_OK; i++)
        cast(x, -1, i, lw_v3_scale(lw_m3_column(&axes, i%3), i < 3 ? 1 : -1), &s);
    if (s == LW_OK && !(x->face = lw_array_grow(NULL, 8, &x->face_room, sizeof *x->face)))
        s = LW_E_MEMORY;
    for (; x->n_face < 8 && s == LW_OK; x->n_face++) {
        int i = x->n_face, px = i & 1 ? 3 : 0, py = i & 2 ? 4 : 1, pz = i & 4 ? 5 : 2;
        bool turned = (i ^ i >> 1 ^ i >> 2) & 1;
        s = fill_face(x, i, px, turned ? pz : py, turned ? py : pz);
    }
    return s;
}

static double sum_up(const search *x, lw_star_volume *out)
{
    double greatest = 0;
    *out = (lw_star_volume){ .volume = 0 };
    for (int i = 0; i < x->n_face; i++) {
        const face *f = &x->face[i];
        out->volume += f->volume;
        out->error += f->error;
        greatest = fmax(greatest, f->error);
    }
    return greatest;
}

lw_status lw_star_volume_find(int around, double share, int most, lw_star_reach *reach, void *context, lw_star_volume *out)
{
    search x = { .reach = reach, .context = context };
    lw_status s = begin(&x);
    for (int n = 8; n < (around > 16 ? around : 16) && s == LW_OK; n *= 2)
        s = divide_all(&x, -1, INT_MAX);
    double greatest = s == LW_OK ? sum_up(&x, out) : 0;
    while (s == LW_OK && out->error > share*fabs(out->volume) && x.n_ray < most) {
        if ((s = divide_all(&x, 0.3*greatest, most)) == LW_OK)
            greatest = sum_up(&x, out);
    }
    lw_key_table_free(&x.by_parents);
    free(x.ray);
    free(x.face);
    return s;
}
