/* catalogues/draw/drawing.c - see drawing.h */
#include "catalogues/draw/drawing.h"

#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"

unsigned lw_ink_light(lw_ink i)
{
    static const unsigned light[] = {
#define X(name, on_white, on_black, text) on_white,
        LW_INK_LIST(X)
#undef X
    };
    return light[i];
}

unsigned lw_ink_dark(lw_ink i)
{
    static const unsigned dark[] = {
#define X(name, on_white, on_black, text) on_black,
        LW_INK_LIST(X)
#undef X
    };
    return dark[i];
}

const char *lw_ink_name(lw_ink i)
{
    static const char *const names[] = {
#define X(name, on_white, on_black, text) text,
        LW_INK_LIST(X)
#undef X
    };
    return names[i];
}

const char *lw_role_name(lw_role r)
{
    static const char *const names[] = {
#define X(name, text) text,
        LW_ROLE_LIST(X)
#undef X
    };
    return names[r];
}

lw_vec2 lw_view_pixel(const lw_view *v, lw_vec2 p)
{
    return lw_v2(v->centre.x + v->scale*(p.x - v->middle.x), v->centre.y - v->scale*(p.y - v->middle.y));
}

void lw_drawing_free(lw_drawing *d)
{
    free(d->shape);
    free(d->point);
    free(d->text);
    *d = (lw_drawing){ 0 };
}

/* Make space for n more items in an array that doubles. */
static bool reserve(lw_drawing *d, void **array, size_t used, size_t *capacity, size_t n, size_t size)
{
    if (d->failed)
        return false;
    size_t wanted = *capacity ? *capacity : 256;
    while (wanted - used < n)
        wanted *= 2;
    if (wanted == *capacity)
        return true;
    void *bigger = realloc(*array, wanted*size);
    d->failed = !bigger;
    if (bigger) {
        *array = bigger;
        *capacity = wanted;
    }
    return !d->failed;
}

static lw_shape *add(lw_drawing *d, lw_shape_kind kind, lw_role role)
{
    bool ok = reserve(d, (void **)&d->shape, d->n_shape, &d->shape_room, 1, sizeof *d->shape);
    lw_shape *s = ok ? &d->shape[d->n_shape++] : &d->spare;
    *s = (lw_shape){ .kind = kind, .role = role,
                     .item = -1, .link = -1, .tie = -1, .panel = -1, .alpha = 1, .width = 1 };
    return s;
}

lw_shape *lw_drawing_path(lw_drawing *d, lw_role role, const lw_vec2 *p, size_t n, bool closed)
{
    bool ok = reserve(d, (void **)&d->point, d->n_point, &d->point_room, n, sizeof *d->point);
    lw_shape *s = add(d, LW_SHAPE_PATH, role);
    s->closed = closed;
    if (ok && n) {
        s->first = d->n_point;
        s->n = n;
        memcpy(d->point + d->n_point, p, n*sizeof *p);
        d->n_point += n;
    }
    return s;
}

lw_shape *lw_drawing_line(lw_drawing *d, lw_role role, lw_vec2 a, lw_vec2 b)
{
    lw_vec2 p[2] = { a, b };
    return lw_drawing_path(d, role, p, 2, false);
}

lw_shape *lw_drawing_circle(lw_drawing *d, lw_role role, lw_vec2 at, double radius)
{
    lw_shape *s = add(d, LW_SHAPE_CIRCLE, role);
    s->at = at;
    s->radius = radius;
    return s;
}

lw_shape *lw_drawing_text(lw_drawing *d, lw_role role, const char *text, lw_vec2 at, double size, double align)
{
    size_t capacity = 3*strlen(text) + 1;                  /* each byte may become a replacement character */
    bool ok = reserve(d, (void **)&d->text, d->n_text, &d->text_room, capacity, 1);
    lw_shape *s = add(d, LW_SHAPE_TEXT, role);
    s->at = s->hold = at;
    s->width = size;
    s->align = align;
    s->fill = LW_INK_TEXT;
    if (ok) {
        s->first = d->n_text;
        lw_text_clean(d->text + d->n_text, capacity, text);
        s->n = strlen(d->text + d->n_text);
        d->n_text += s->n + 1;
    }
    return s;
}

lw_status lw_drawing_end(lw_drawing *d, lw_error *e)
{
    if (!d->failed)
        return LW_OK;
    lw_drawing_free(d);
    return lw_error_set(e, LW_E_MEMORY, "not enough memory for the drawing");
}

/* Width of a character for type size 1: DejaVu Sans, the widest of the common sans-serif fonts, rounded up by class. */
static double letter_width(unsigned char c)
{
    if (strchr("iljI.,:;'|! ", c))
        return 0.40;
    if (strchr("ftr-()[]/\\\"", c))
        return 0.46;
    if (strchr("mMwW%@=+<>~^#&_", c))
        return c == 'm' || c == 'M' || c == 'W' || c == '%' || c == '@' ? 1.0 : 0.84;
    if (c >= 'A' && c <= 'Z')
        return 0.79;
    return c < 0x80 ? 0.64 : 0.84;
}

double lw_text_width(const char *text, double size)
{
    double w = 0;
    for (const unsigned char *c = (const unsigned char *)text; *c; c++)
        if ((*c & 0xc0) != 0x80)                                        /* the first byte of a character */
            w += letter_width(*c);
    return w*size;
}
