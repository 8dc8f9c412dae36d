/* catalogues/build/build_check.c - check a catalogue for consistency and against the published counts. */
#include <stdio.h>
#include <string.h>

#include "catalogues/build/build.h"
#include "enumerate/canon.h"
#include "enumerate/multiple.h"
#include "grammar/topology/graph6.h"

/* ---- every chain: is it what its label says, and does it move with its freedoms? --------------------- */

typedef struct check {
    const lw_build_control *control;
    uint64_t n_chain, n_wrong;
    char     wrong[LW_GRAPH6_SIZE];            /* the first wrong one                                 */
} check;

/* A label that cannot be computed says nothing about the chain. */
static bool no_verdict(lw_status s) { return s == LW_E_MEMORY || s == LW_E_IO; }

static lw_status count_chain(check *c, bool good, const char *text)
{
    c->n_chain++;
    c->n_wrong += !good;
    if (!good && !c->wrong[0])
        snprintf(c->wrong, sizeof c->wrong, "%s", text ? text : "");
    return c->control && c->control->goes_on && !c->control->goes_on(c->control->context, (double)c->n_chain, 0)
         ? LW_STOPPED : LW_OK;
}

static lw_status check_chain(void *context, int n_column, const char *const *name, const lw_value *value)
{
    check *c = context;
    lw_chain chain, form;
    char label[LW_GRAPH6_SIZE];
    lw_status made = LW_OK;
    bool good = value[0].text && value[1].text
             && lw_graph6_read(value[1].text, value[1].size, NULL, &chain, NULL) == LW_OK
             && lw_chain_check(&chain, NULL) == LW_OK && (made = lw_chain_canonical(&chain, &form)) == LW_OK
             && lw_chain_mobility(&chain) == (int)value[2].integer && chain.n_link == (int)value[3].integer;
    (void)n_column, (void)name;
    if (no_verdict(made))
        return made;
    if (good) {
        lw_graph6_print(&form, label, sizeof label);
        good = strcmp(label, value[0].text) == 0;
    }
    return count_chain(c, good, value[1].text);
}

/* pins, dof, links, symmetry of a chain with multiple joints */
static lw_status check_multiple(void *context, int n_column, const char *const *name, const lw_value *value)
{
    check *c = context;
    lw_multiple m, form;
    uint8_t lowest[LW_LINK_MAX];
    uint64_t order = 0;
    lw_status made = LW_OK;
    bool good = value[0].kind == LW_VALUE_TEXT
             && lw_multiple_read(value[0].text, value[0].size, NULL, &m, NULL) == LW_OK
             && m.n_link == (int)value[2].integer && lw_multiple_moves(&m)
             && 3*(m.n_link - 1) - 2*lw_multiple_joints(&m) == (int)value[1].integer
             && (made = lw_multiple_canonical(&m, &form)) == LW_OK && memcmp(&m, &form, sizeof m) == 0
             && (made = lw_multiple_symmetry(&m, lowest, &order)) == LW_OK && order == (uint64_t)value[3].integer;
    (void)n_column, (void)name;
    if (no_verdict(made))
        return made;
    return count_chain(c, good, value[0].text);
}

static lw_status check_chains(lw_store *s, check *c, lw_error *e)
{
    lw_store_query q = { .sql = "SELECT label, graph6, dof, links FROM chain", .row = check_chain, .context = c };
    lw_store_query pins = { .sql = "SELECT pins, dof, links, symmetry FROM multiple", .row = check_multiple, .context = c };
    bool has = false;
    lw_status status = lw_store_ask(s, &q, e);
    if (status == LW_OK)
        status = lw_store_has_table(s, "multiple", &has, e);
    if (status == LW_OK && has)
        status = lw_store_ask(s, &pins, e);
    if (status == LW_OK && c->n_wrong > 0)
        status = lw_error_at(e, LW_E_NOTATION, lw_store_path(s), 0, 0, "%llu of %llu chains are not what their label "
                             "says, the first is %s", (unsigned long long)c->n_wrong, (unsigned long long)c->n_chain,
                             c->wrong);
    return status;
}

/* ---- sums -------------------------------------------------------------------------------------------- */

/* Check every number in the file that follows from others. */
static lw_status check_sums(lw_store *s, lw_error *e)
{
    static const struct { const char *what, *sql, *table; } sums[] = {      /* table: which older files lack */
        { "chains of a finished build are missing",
          "SELECT count(*) FROM build b WHERE complete AND done != "
          "(SELECT count(*) FROM chain c WHERE c.links = b.links AND c.dof = b.dof) AND joints != 'multiple'", NULL },
        { "chains with multiple joints of a finished build are missing",
          "SELECT count(*) FROM build b WHERE complete AND joints = 'multiple' AND done != "
          "(SELECT count(*) FROM multiple c WHERE c.links = b.links AND c.dof = b.dof)", "multiple" },
        { "chains have not all their ground links",
          "SELECT count(*) FROM chain c WHERE grounds != (SELECT count(*) FROM ground g WHERE g.chain = c.id) "
          "OR links != (SELECT sum(alike) FROM ground g WHERE g.chain = c.id)", NULL },
        { "ground links have no input",                /* with more freedoms the joints of a ground may all lie in a loop with fewer */
          "SELECT count(*) FROM ground g JOIN chain c ON c.id = g.chain WHERE c.dof = 1 AND NOT EXISTS "
          "(SELECT 1 FROM mechanism m WHERE m.chain = g.chain AND m.ground = g.link)", NULL },
        { "chains stand at the wrong structure",
          "SELECT count(*) FROM chain c JOIN structure s ON s.id = c.structure "
          "WHERE s.loops != c.loops OR s.circles != c.links - c.binary OR s.planar != c.planar", NULL },
        { "segments of curves lack blocks or have too many",
          "SELECT count(*) FROM curve_segment s WHERE n != (SELECT coalesce(sum(length(terms)), 0)/64 FROM curve_block b "
          "WHERE b.id >= s.first_block AND b.id < s.first_block + length(s.boxes)/68) "
          "OR n != (SELECT coalesce(sum(length(linkages)), 0)/36 FROM curve_block b "
          "WHERE b.id >= s.first_block AND b.id < s.first_block + length(s.boxes)/68)", NULL },
        { "sequences of curves lack segments",
          "SELECT count(*) FROM sweep w WHERE segments != "
          "(SELECT count(DISTINCT number) FROM curve_segment s WHERE s.sweep = w.id)", NULL },
    };
    for (size_t i = 0; i < sizeof sums/sizeof *sums; i++) {
        long long n = 0;
        bool has = true;
        lw_status status = sums[i].table ? lw_store_has_table(s, sums[i].table, &has, e) : LW_OK;
        if (status == LW_OK && has)
            status = lw_store_number(s, sums[i].sql, NULL, 0, &n, e);
        if (status != LW_OK)
            return status;
        if (n > 0)
            return lw_error_at(e, LW_E_NOTATION, lw_store_path(s), 0, 0, "%lld %s", n, sums[i].what);
    }
    return LW_OK;
}

lw_status lw_build_check(lw_store *s, const lw_build_control *control, uint64_t *n_chain, uint64_t *n_open, lw_error *e)
{
    check c = { .control = control };
    long long n = 0;
    lw_status status = lw_store_verify(s, e);
    if (status == LW_OK)
        status = check_chains(s, &c, e);
    if (status == LW_OK)
        status = check_sums(s, e);
    if (status == LW_OK)
        status = lw_store_number(s, "SELECT count(*) FROM build WHERE NOT complete", NULL, 0, &n, e);
    if (status == LW_STOPPED)
        lw_error_set(e, status, "stopped before the whole file was checked");
    *n_chain = c.n_chain;
    *n_open = (uint64_t)n;
    return status;
}

/* ---- published counts --------------------------------------------------------------------------------- */

#define COMPLETE " FROM chain c WHERE c.links = ?1 AND c.dof = ?2"
#define GROUNDS  "SELECT count(*) FROM ground g JOIN chain c ON c.id = g.chain WHERE c.links = ?1 AND c.dof = ?2"

/* How to count what a published text describes: the first row here whose `begin` starts the text. ?3 is the assortment.
 * A catalogue has no fractionated chains; with F = 1 there are none, so counts of all chains are compared for F = 1
 * only. */
static const struct { const char *begin; const char *sql; bool only_dof_1; } wordings[] = {
    { "all chains with nonplanar", "SELECT count(*)" COMPLETE " AND NOT c.planar", true },
    { "all chains; assortment", "SELECT count(*)" COMPLETE " AND c.assortment = ?3", true },
    { "all chains", "SELECT count(*)" COMPLETE, true },
    { "nonfractionated; assortment", "SELECT count(*)" COMPLETE " AND c.assortment = ?3", false },
    { "assortment", "SELECT count(*)" COMPLETE " AND c.assortment = ?3", false },
    { "inversions; assortment", GROUNDS " AND c.assortment = ?3", false },
    { "inversions of all chains", GROUNDS, true },
    { "inversions of nonfractionated", GROUNDS, false },
    { "nonfractionated chains with nonplanar", "SELECT count(*)" COMPLETE " AND NOT c.planar", false },
    { "chains with nonplanar", "SELECT count(*)" COMPLETE " AND NOT c.planar", false },
    { "nonfractionated chains with at least one multiple", "SELECT count(*) FROM multiple c WHERE c.links = ?1 AND c.dof = ?2",
      false },
    { "nonfractionated chains", "SELECT count(*)" COMPLETE, false },
    { "chains with trivial automorphism", "SELECT count(*)" COMPLETE " AND c.symmetry = 1", false },
};

/* Read the assortment in "... [4 4 0]" and write it as the catalogue does: without zeros at the end. */
static void read_assortment(const char *what, char text[64])
{
    const char *at = strrchr(what, '[');
    size_t n = at ? strcspn(at + 1, "]") : 0;
    text[0] = 0;
    if (!at || n > 60)
        return;
    memcpy(text, at + 1, n);
    text[n] = 0;
    while (n > 2 && text[n - 1] == '0' && text[n - 2] == ' ')
        text[n -= 2] = 0;
}

static const char *sql_of(const lw_published *row)
{
    for (size_t i = 0; i < sizeof wordings/sizeof *wordings; i++)
        if (strncmp(row->what, wordings[i].begin, strlen(wordings[i].begin)) == 0)
            return wordings[i].only_dof_1 && row->dof != 1 ? NULL : wordings[i].sql;
    return NULL;
}

/* Set *counted to the catalogue's own count; -1 if the row is not about a finished build of this catalogue. */
static lw_status count_row(lw_store *s, const lw_published *row, long long *counted, lw_error *e)
{
    char links[64];
    bool multiple = strcmp(row->family, "multiple-joint") == 0;
    const char *sql = multiple || strcmp(row->family, "simple-joint") == 0 ? sql_of(row) : NULL;
    long long n = 0;
    lw_value v[3] = { { .kind = LW_VALUE_INTEGER, .integer = row->links },
                      { .kind = LW_VALUE_INTEGER, .integer = row->dof }, { .kind = LW_VALUE_TEXT, .text = links } };
    *counted = -1;
    if (!sql)
        return LW_OK;
    lw_status status = lw_store_number(s, multiple ? "SELECT count(*) FROM build WHERE links = ?1 AND dof = ?2 AND complete "
                                       "AND joints = 'multiple'" : "SELECT count(*) FROM build WHERE links = ?1 AND dof = ?2 "
                                       "AND complete AND joints != 'multiple'", v, 2, &n, e);
    if (status != LW_OK || n == 0)
        return status;
    read_assortment(row->what, links);
    v[2].size = strlen(links);
    return lw_store_number(s, sql, v, strstr(sql, "?3") ? 3 : 2, counted, e);
}

lw_status lw_build_check_published(lw_store *s, const lw_published_table *t,
                                   void (*row)(void *context, const lw_published *row, long long counted),
                                   void *context, lw_error *e)
{
    lw_status status = LW_OK;
    for (size_t i = 0; i < t->n && status == LW_OK; i++) {
        long long counted;
        status = count_row(s, &t->row[i], &counted, e);
        if (status == LW_OK && counted >= 0)
            row(context, &t->row[i], counted);
    }
    return status;
}
