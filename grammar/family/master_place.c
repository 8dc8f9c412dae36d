/* grammar/family/master_place.c - from a place of an expanded model back to the place of the master that it came from. */
#include <stdio.h>
#include <string.h>
#include "grammar/family/master_expansion_internal.h"
#include "grammar/text/json_locate_internal.h"

void lw_master_name_instances(const map *p, int at, lw_error *e)
{
    if (at < 0 || !e)
        return;
    size_t used = strlen(e->text);
    snprintf(e->text + used, sizeof e->text - used, " (in \"%.60s\", part \"%.60s\")", p->instance[at].name, p->instance[at].part->name);
}

static size_t offset_of(const lw_expansion *x, long line, long column)
{
    size_t at = 0;
    for (long k = 1; k < line && at < x->size; at++)
        k += x->text[at] == '\n';
    return at + (size_t)(column > 0 ? column - 1 : 0);
}

static const mark *find_mark(const lw_expansion *x, long line, long column, size_t *delta)
{
    const map *p = x->map;
    size_t at = offset_of(x, line, column);
    int low = 0, high = p->n_mark;
    while (low < high) {                                /* the first mark behind the place */
        int mid = (low + high)/2;
        if (p->mark[mid].out <= at)
            low = mid + 1;
        else
            high = mid;
    }
    *delta = low > 0 ? at - p->mark[low - 1].out : 0;
    return low > 0 ? &p->mark[low - 1] : NULL;
}

static bool place_of(const map *p, const mark *k, size_t delta, long *line, long *column)
{
    const lw_template *t = &p->m->block[k->node];
    lw_json_path path = { .n = 0 };
    size_t index[16];
    int depth = 0;
    for (const lw_json_node *n = &t->json; n->parent; n = n->parent) {
        if (depth == 16)
            return false;
        index[depth++] = n->index;
    }
    while (depth > 0)
        path.index[path.n++] = index[--depth];
    size_t at = lw_json_locate(p->m->text, p->m->json.size, &path, k->key);
    if (!k->key && t->kind == LW_TEMPLATE_VERBATIM && delta <= strlen(t->verbatim))
        at += delta;
    lw_text_place(p->m->text, p->m->json.size, at, line, column);
    return true;
}

bool lw_expansion_place(const lw_expansion *x, long line, long column, long *master_line, long *master_column)
{
    size_t delta;
    const mark *k = x->map ? find_mark(x, line, column, &delta) : NULL;
    return k && place_of(x->map, k, delta, master_line, master_column);
}

void lw_expansion_fault(const lw_expansion *x, lw_error *e)
{
    const map *p = x->map;
    size_t delta;
    if (!p || !e)
        return;
    const mark *k = e->line > 0 ? find_mark(x, e->line, e->column, &delta) : NULL;
    snprintf(e->file, sizeof e->file, "%s", p->m->file);
    if (k && place_of(p, k, delta, &e->line, &e->column))
        lw_master_name_instances(p, k->instance, e);
    else if (e->line > 0) {                             /* before the first key of the model */
        lw_text_place(p->m->text, p->m->json.size, 0, &e->line, &e->column);
    }
}
