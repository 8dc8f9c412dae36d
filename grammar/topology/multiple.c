#include "grammar/topology/multiple.h"

#include <stdlib.h>
#include "grammar/text/text_internal.h"

static int by_size(const void *a, const void *b)
{
    const uint32_t *x = a, *y = b;
    int more = __builtin_popcount(*y) - __builtin_popcount(*x);
    return more ? more : (*x < *y) - (*x > *y);
}

void lw_multiple_sort(lw_multiple *m) { qsort(m->pin, (size_t)m->n_pin, sizeof *m->pin, by_size); }

int lw_multiple_joints(const lw_multiple *m)
{
    int n = 0;
    for (int k = 0; k < m->n_pin; k++)
        n += __builtin_popcount(m->pin[k]) - 1;
    return n;
}

size_t lw_multiple_print(const lw_multiple *m, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    for (int k = 0; k < m->n_pin; k++)
        for (uint32_t s = m->pin[k]; s; s &= s - 1)
            lw_text_add(&t, "%s%d", s != m->pin[k] ? "-" : k > 0 ? " " : "", __builtin_ctz(s) + 1);
    return t.length;
}

/* One pin, such as "1-2-5". */
static lw_status read_pin(lw_cursor *c, lw_multiple *m)
{
    lw_cursor start = *c;
    uint32_t pin = 0;
    char name[24];
    for (;;) {
        lw_cursor at = *c;
        int link;
        if (!lw_cursor_number(c, &link))
            return lw_cursor_fail(&at, "%s where a link number was expected", lw_byte_name(lw_cursor_peek(c), name));
        if (link < 1 || link > LW_LINK_MAX)
            return lw_cursor_fail(&at, "links are numbered 1 to %d", LW_LINK_MAX);
        if (pin >> (link - 1) & 1)
            return lw_cursor_fail(&at, "link %d is twice on this pin", link);
        pin |= 1u << (link - 1);
        m->n_link = link > m->n_link ? link : m->n_link;
        if (lw_cursor_peek(c) != '-')
            break;
        lw_cursor_next(c);
    }
    int after = lw_cursor_peek(c);
    if (after >= 0 && after != ' ' && after != '\t' && after != '\n' && after != '\r')
        return lw_cursor_fail(c, "%s where '-' or a blank was expected", lw_byte_name(after, name));
    if (!(pin & (pin - 1)))
        return lw_cursor_fail(&start, "a pin holds two links or more");
    for (int k = 0; k < m->n_pin; k++)
        if (__builtin_popcount(m->pin[k] & pin) > 1)
            return lw_cursor_fail(&start, "two of its links are on one pin already");
    if (m->n_pin == LW_JOINT_MAX)
        return lw_cursor_fail(&start, "more than %d pins", LW_JOINT_MAX);
    m->pin[m->n_pin++] = pin;
    return LW_OK;
}

lw_status lw_multiple_read(const char *text, size_t size, const char *file, lw_multiple *m, lw_error *e)
{
    lw_cursor c = lw_cursor_start(text, size, file, e), start = c;
    lw_multiple out = { 0 };
    uint32_t named = 0;
    lw_status s = LW_OK;
    for (lw_cursor_skip(&c, false, 0); s == LW_OK && lw_cursor_peek(&c) >= 0 && lw_cursor_peek(&c) != '\n'
         && lw_cursor_peek(&c) != '\r'; lw_cursor_skip(&c, false, 0))
        s = read_pin(&c, &out);
    lw_cursor_skip(&c, true, 0);
    if (s == LW_OK && lw_cursor_peek(&c) >= 0)
        return lw_cursor_fail(&c, "one line of text is one chain");
    for (int k = 0; k < out.n_pin; k++)
        named |= out.pin[k];
    if (s == LW_OK && !named)
        s = lw_cursor_fail(&start, "there is no pin");
    if (s == LW_OK && named & (named + 1))
        s = lw_cursor_fail(&start, "there is a link %d but no link %d", out.n_link, 1 + __builtin_ctz(~named));
    lw_multiple_sort(&out);
    if (s == LW_OK)
        *m = out;
    return s;
}

lw_status lw_multiple_mechanism(const lw_multiple *m, lw_mechanism *out, uint32_t *axes)
{
    int n = m->n_link;
    lw_mechanism all;
    *axes = 0;
    for (int k = 0; k < m->n_pin; k++)
        n += __builtin_popcount(m->pin[k]) > 2;
    lw_status s = lw_mechanism_clear(&all, n);
    n = m->n_link;
    for (int k = 0; k < m->n_pin && s == LW_OK; k++) {
        int first = __builtin_ctz(m->pin[k]), last = 31 - __builtin_clz(m->pin[k]);
        bool axis = __builtin_popcount(m->pin[k]) > 2;
        for (uint32_t left = m->pin[k]; axis && left && s == LW_OK; left &= left - 1)
            s = lw_mechanism_join(&all, n, __builtin_ctz(left), 'r');
        *axes |= axis ? 1u << n++ : 0;
        if (!axis)
            s = lw_mechanism_join(&all, first, last, 'r');
    }
    if (s == LW_OK)
        *out = all;
    return s;
}
