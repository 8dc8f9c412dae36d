#include "cli/fit/fit_stages.h"

#include <stdlib.h>
#include <string.h>

#include "catalogues/store/nearest.h"
#include "cli/program/model.h"

enum { KNOWN_MAX = 256 };

static lw_status add_known(cli_fit_known *k, const lw_linkage *linkage)
{
    lw_linkage *more = realloc(k->linkage, sizeof *more*(size_t)(k->n + 1));
    if (!more)
        return LW_E_MEMORY;
    more[k->n++] = *linkage;
    k->linkage = more;
    return LW_OK;
}

/* May this linkage be a start?  It needs an input that moves by itself and a point. */
static lw_status check_known(const lw_linkage *k, const char *path, lw_error *e)
{
    int own = lw_linkage_free_inputs(k);
    if (own == 1 && k->n_tracer > 0)
        return LW_OK;
    return lw_error_at(e, LW_E_ARG, path, 0, 0, "a linkage to start from has one input%s and a tracer; \"%.40s\" has %d "
                       "inputs and %d tracers", own > 1 ? ", beside those tied to it by a ratio," : "", k->name, own,
                       k->n_tracer);
}

static int by_links(const void *a, const void *b)
{
    const lw_family *p = a, *q = b;
    if (p->links != q->links)
        return p->links - q->links;
    return p->linkage < q->linkage ? -1 : p->linkage > q->linkage;
}

/* Families of all that is known, each with its posture as a start. */
static lw_status name_families(cli_fit_known *k)
{
    lw_family *f = realloc(k->family, sizeof *f*(size_t)(k->n + 1));
    if (!f)
        return LW_E_MEMORY;
    k->family = f;
    for (int i = 0; i < k->n; i++) {
        lw_linkage *l = &k->linkage[i];
        if (!l->name[0])
            memcpy(l->name, "linkage", sizeof "linkage");
        f[i] = (lw_family){ .name = l->name, .linkage = l, .posture = true, .links = l->n_link };
    }
    qsort(f, (size_t)k->n, sizeof *f, by_links);
    return LW_OK;
}

lw_status cli_fit_known_read(const char *path, cli_fit_known *k, lw_error *e)
{
    for (int which = 0; which < KNOWN_MAX; which++) {
        lw_linkage linkage;
        lw_error why = { .text = "" };
        lw_status st = cli_read_linkage(path, which == 0 ? 0 : which + 1, &linkage, &why);
        if (st != LW_OK && which > 0)
            break;                                       /* one linkage, or no more results        */
        if (st != LW_OK) {
            *e = why;
            return st;
        }
        if ((st = check_known(&linkage, path, e)) != LW_OK)
            return st;
        if (add_known(k, &linkage) != LW_OK)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    return name_families(k) == LW_OK ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

lw_status cli_fit_known_atlas(const char *path, const lw_target *t, int links, cli_fit_known *k, lw_error *e)
{
    enum { NEAREST = 24 };
    lw_store *store;
    lw_atlas_hit *hit = calloc(NEAREST, sizeof *hit);
    lw_vec2 *p = malloc(sizeof *p*(t->n + 1));
    int n = 0;
    lw_status st = hit && p ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK && !t->x)
        st = lw_error_set(e, LW_E_ARG, "--atlas starts from curves, and the target has no points");
    for (size_t i = 0; st == LW_OK && i < t->n; i++)
        p[i] = lw_v2(t->x[i], t->y[i]);
    if (st == LW_OK && (st = lw_store_open(path, &(lw_store_options){ .write = false }, &store, e)) == LW_OK) {
        st = lw_store_nearest(store, p, t->n, t->closed, NEAREST, hit, &n, NULL, e);
        lw_store_close(store);
        st = st == LW_NOTHING ? LW_OK : st;
    }
    for (int i = 0; i < n && st == LW_OK; i++)
        if (hit[i].linkage.n_link <= links && check_known(&hit[i].linkage, path, NULL) == LW_OK
            && add_known(k, &hit[i].linkage) != LW_OK)
            st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK && name_families(k) != LW_OK)
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    free(hit);
    free(p);
    return st;
}

void cli_fit_known_free(cli_fit_known *k)
{
    free(k->linkage);
    free(k->family);
    memset(k, 0, sizeof *k);
}

/* Those of the known linkages that have so many links. */
static lw_families known_with(const cli_fit_known *k, int links)
{
    int first = 0, n = 0;
    while (first < k->n && k->family[first].links < links)
        first++;
    while (first + n < k->n && k->family[first + n].links == links)
        n++;
    return lw_families_of(k->family + first, n);
}

/* A stage of topologies, or of what is known with so many links, or of both; none when there are none.  Returns its
 * number. */
static int add_stage(lw_mechanism_set *all, lw_families topologies, lw_families known, int links, cli_fit_stages *s)
{
    lw_families_pair *pair = &s->pair[s->n];
    if (s->n == LW_STAGE_MAX)
        return LW_STAGE_MAX;
    *pair = (lw_families_pair){ topologies, known };
    s->stage[s->n] = (lw_search_stage){ .links = links, .families = lw_families_join(pair), .context = all,
                                 .name = all->n > 0 ? lw_mechanism_set_name : NULL };
    return s->n++;
}

/* The topologies of pins with so many links, or NULL. */
static lw_mechanism_stage *lower_with(lw_mechanism_set *t, int links)
{
    for (int i = 0; i < t->n; i++)
        if (t->stage[i].links == links && !t->stage[i].higher)
            return &t->stage[i];
    return NULL;
}

void cli_fit_stages_make(lw_mechanism_set *t, const cli_fit_known *k, cli_fit_stages *s)
{
    const lw_families none = lw_families_of(NULL, 0);
    s->n = t->dof <= 1;                                  /* the types have F = 1                   */
    s->stage[0] = (lw_search_stage){ .links = 4 };
    for (int links = 2; links <= LW_LINK_MAX; links++) {
        lw_families known = known_with(k, links);
        lw_mechanism_stage *own = lower_with(t, links);
        if (own)
            own->stage = own->slides = add_stage(t, lw_mechanism_stage_pins(own), known, links, s);
        else if (known.n > 0)
            add_stage(t, none, known, links, s);
    }
    for (int i = 0; i < t->n; i++)
        if (!t->stage[i].higher && t->stage[i].n_family > t->stage[i].n_pins)
            t->stage[i].slides = add_stage(t, lw_mechanism_stage_others(&t->stage[i]), none, t->stage[i].links, s);
    for (int i = 0; i < t->n; i++)
        if (t->stage[i].higher)
            t->stage[i].stage = t->stage[i].slides = add_stage(t, lw_mechanism_stage_others(&t->stage[i]), none,
                                                               t->stage[i].links, s);
}
