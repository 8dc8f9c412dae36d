/* catalogues/store/store_rows.c - write rows into the store: structures, chains, ground links, mechanisms, segments of
 * curves, linkages; and read blocks of curves. */
#include "base/real.h"
#include "catalogues/store/store_internal.h"

#include <stdio.h>
#include <string.h>

#include "catalogues/store/nearest.h"

lw_status lw_store_build_begin(lw_store *s, int links, int dof, const char *joints, uint64_t *done, bool *complete, lw_error *e)
{
    bool any;
    sqlite3_int64 n_done = 0, is_complete = 0;
    lw_status status = lw_store_do(s, "INSERT OR IGNORE INTO build(links, dof, joints) VALUES(?1, ?2, ?3)", e, "iit",
                                   (long long)links, (long long)dof, joints);
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT id FROM build WHERE links = ?1 AND dof = ?2 AND joints = ?3", &s->build, &any,
                               e, "iit", (long long)links, (long long)dof, joints);
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT done FROM build WHERE id = ?1", &n_done, &any, e, "i", (long long)s->build);
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT complete FROM build WHERE id = ?1", &is_complete, &any, e, "i", (long long)s->build);
    *done = (uint64_t)n_done;
    *complete = is_complete != 0;
    return status;
}

lw_status lw_store_build_done(lw_store *s, uint64_t done, bool complete, lw_error *e)
{
    return lw_store_do(s, "UPDATE build SET done = ?1, complete = ?2 WHERE id = ?3", e, "iii", (long long)done,
                       (long long)complete, (long long)s->build);
}

lw_status lw_store_put_structure(lw_store *s, const lw_store_structure *t, lw_error *e)
{
    return lw_store_do(s, "INSERT OR IGNORE INTO structure(loops, number, circles, lines, planar, form, derivation, "
                          "run) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)", e, "iiiiitti", (long long)t->loops,
                       (long long)t->number, (long long)t->circles, (long long)t->lines, (long long)t->planar, t->form,
                       t->derivation, (long long)s->run);
}

static lw_status put_row(lw_store *s, const lw_store_chain *c, lw_error *e)
{
    return lw_store_do(s, "INSERT OR IGNORE INTO chain(label, graph6, links, dof, joints, loops, structure, "
                          "assortment, binary, ternary, quaternary, quinary, senary, symmetry, grounds, planar, "
                          "franke, sentence, matrix, layout, run) VALUES(?1, ?2, ?3, ?4, ?5, ?6, (SELECT id FROM "
                          "structure WHERE loops = ?6 AND number = ?7), ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, "
                          "?17, ?18, ?19, ?20, ?21)", e, "ttiiiiitiiiiiiiitttbi", c->label, c->graph6,
                       (long long)c->links, (long long)c->dof, (long long)c->joints, (long long)c->loops,
                       (long long)c->structure, c->assortment, (long long)c->n_with[0], (long long)c->n_with[1],
                       (long long)c->n_with[2], (long long)c->n_with[3], (long long)c->n_with[4],
                       (long long)c->symmetry, (long long)c->n_ground, (long long)c->planar, c->franke, c->sentence,
                       c->matrix, c->layout, c->layout_size, (long long)s->run);
}

lw_status lw_store_put_chain(lw_store *s, const lw_store_chain *c, lw_error *e)
{
    sqlite3_int64 id = 0;
    bool any;
    lw_status status = put_row(s, c, e);
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT id FROM chain WHERE label = ?1", &id, &any, e, "t", c->label);
    for (int i = 0; i < c->n_ground && status == LW_OK; i++)
        status = lw_store_do(s, "INSERT OR IGNORE INTO ground(chain, link, alike) VALUES(?1, ?2, ?3)", e, "iii",
                             (long long)id, (long long)c->ground[i], (long long)c->alike[i]);
    for (size_t i = 0; i < c->n_mechanism && status == LW_OK; i++) {
        const lw_store_mechanism *m = &c->mechanism[i];
        status = lw_store_do(s, "INSERT OR IGNORE INTO mechanism(chain, ground, kinds, sliders, inputs, assur, "
                                "groups_n, highest, modes, run) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, nullif(?9, 0), "
                                "?10)", e, "iitittiiii", (long long)id, (long long)m->ground, m->kinds,
                             (long long)m->n_slider, m->inputs, m->groups, (long long)m->n_group, (long long)m->highest,
                             (long long)m->modes, (long long)s->run);
    }
    return status;
}

lw_status lw_store_put_multiple(lw_store *s, const lw_store_multiple *m, lw_error *e)
{
    return lw_store_do(s, "INSERT OR IGNORE INTO multiple(pins, links, dof, joints, loops, assortment, symmetry, planar, "
                          "grounds, ground_links, run) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)", e,
                       "tiiiitiiiti", m->pins, (long long)m->links, (long long)m->dof, (long long)m->joints,
                       (long long)m->loops, m->assortment, (long long)m->symmetry, (long long)m->planar,
                       (long long)m->n_ground, m->ground_links, (long long)s->run);
}

lw_status lw_store_sweep_begin(lw_store *s, lw_atlas_sweep *sweep, lw_error *e)
{
    bool any;
    char seed[24];
    sqlite3_int64 samples = 0, segments = 0, first = 0;
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)sweep->seed);
    lw_status status = lw_store_do(s, "INSERT OR IGNORE INTO sweep(families, kinds, seed, first) VALUES(?1, ?2, ?3, ?4)",
                                   e, "titi", sweep->families, (long long)sweep->kinds, seed, (long long)sweep->first);
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT id FROM sweep WHERE families = ?1 AND kinds = ?2 AND seed = ?3", &s->sweep,
                               &any, e, "tit", sweep->families, (long long)sweep->kinds, seed);
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT samples FROM sweep WHERE id = ?1", &samples, &any, e, "i", (long long)s->sweep);
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT segments FROM sweep WHERE id = ?1", &segments, &any, e, "i", (long long)s->sweep);
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT first FROM sweep WHERE id = ?1", &first, &any, e, "i", (long long)s->sweep);
    if (status == LW_OK && (uint64_t)first != sweep->first)
        status = lw_error_at(e, LW_E_ARG, s->path, 0, 0, "it holds the curves of this sequence from segment %lld on, not "
                             "from %llu; give each part a file of its own", (long long)first + 1,
                             (unsigned long long)sweep->first + 1);
    sweep->samples = (uint64_t)samples;
    sweep->segments = (uint64_t)segments;
    return status;
}

static lw_status put_tree(lw_store *s, const lw_atlas_tree *t, lw_error *e)
{
    sqlite3_int64 last = 0;
    bool any;
    size_t at = 0;
    lw_status status = lw_store_find(s, "SELECT max(id) FROM curve_block", &last, &any, e, "");
    for (size_t b = 0; b < t->n_block && status == LW_OK; b++) {
        size_t n = t->box[b].n;
        status = lw_store_do(s, "INSERT INTO curve_block(id, terms, linkages) VALUES(?1, ?2, ?3)", e, "ibb",
                             (long long)last + 1 + (long long)b, t->terms + at, n*sizeof *t->terms, t->row + at,
                             n*sizeof *t->row);
        at += n;
    }
    if (status == LW_OK)
        status = lw_store_do(s, "INSERT INTO curve_segment(sweep, number, closed, n, first_block, boxes, run) "
                             "SELECT ?1, first + segments + 1, ?2, ?3, ?4, ?5, ?6 FROM sweep WHERE id = ?1", e, "iiiibi",
                             (long long)s->sweep, (long long)t->closed, (long long)t->n, (long long)last + 1, t->box,
                             t->n_block*sizeof *t->box, (long long)s->run);
    return status;
}

lw_status lw_store_put_segment(lw_store *s, const lw_atlas_tree tree[2], size_t n_sample, lw_error *e)
{
    lw_status status = LW_OK;
    for (int i = 0; i < 2 && status == LW_OK; i++)
        if (tree[i].n > 0)
            status = put_tree(s, &tree[i], e);
    if (status == LW_OK)
        status = lw_store_do(s, "UPDATE sweep SET samples = samples + ?1, segments = segments + 1 WHERE id = ?2", e,
                             "ii", (long long)n_sample, (long long)s->sweep);
    return status;
}

/* ---- curves of another catalogue --------------------------------------------------------------------- */

#define SAME "main.sweep h JOIN part.sweep t ON h.families = t.families AND h.kinds = t.kinds AND h.seed = t.seed"

/* Check that the sequence in the attached catalogue goes on where the same one here ends.  LW_NOTHING: it is here. */
static lw_status check_part(lw_store *s, const char *path, sqlite3_int64 *n_curve, lw_error *e)
{
    sqlite3_int64 n = 0, n_open = 0, first = 0, last = 0, here = 0;
    bool any;
    lw_status status = lw_store_find(s, "SELECT count(*) FROM part.sweep", &n, &any, e, "");
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT ended IS NULL FROM part.run WHERE id = (SELECT run FROM part.curve_segment "
                               "ORDER BY id DESC LIMIT 1)", &n_open, &any, e, "");
    n_open = status == LW_OK && !any ? 1 : n_open;
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT first FROM part.sweep", &first, &any, e, "");
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT first + segments FROM part.sweep", &last, &any, e, "");
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT h.first + h.segments FROM " SAME, &here, &any, e, "");
    if (status == LW_OK)
        status = lw_store_find(s, "SELECT sum(n) FROM part.curve_segment", n_curve, &any, e, "");
    if (status != LW_OK)
        return status;
    if (n != 1)
        return lw_error_at(e, LW_E_ARG, path, 0, 0, "it holds %lld sequences of curves; a part holds one", (long long)n);
    if (n_open > 0)
        return lw_error_at(e, LW_E_ARG, path, 0, 0, "this part is not complete; give the command that makes it again");
    if (last <= here)
        return LW_NOTHING;
    if (first == here)
        return LW_OK;
    return lw_error_at(e, LW_E_ARG, path, 0, 0, "it begins after segment %lld of its sequence, and %s has %lld segments; "
                       "add part 1 first, then 2, and so on", (long long)first, s->path, (long long)here);
}

static lw_status copy_part(lw_store *s, lw_error *e)
{
    sqlite3_int64 last = 0;
    bool any;
    lw_status status = lw_store_find(s, "SELECT max(id) FROM curve_block", &last, &any, e, "");
    if (status == LW_OK)
        status = lw_store_do(s, "INSERT OR IGNORE INTO main.sweep(families, kinds, seed, first) "
                             "SELECT families, kinds, seed, first FROM part.sweep", e, "");
    if (status == LW_OK)
        status = lw_store_do(s, "INSERT INTO main.curve_block(id, terms, linkages) "
                             "SELECT id + ?1, terms, linkages FROM part.curve_block ORDER BY id", e, "i",
                             (long long)last);
    if (status == LW_OK)
        status = lw_store_do(s, "INSERT INTO main.curve_segment(sweep, number, closed, n, first_block, boxes, run) "
                             "SELECT (SELECT h.id FROM " SAME "), number, closed, n, first_block + ?1, boxes, ?2 "
                             "FROM part.curve_segment ORDER BY id", e, "ii", (long long)last, (long long)s->run);
    return status != LW_OK ? status
         : lw_store_do(s, "UPDATE main.sweep SET samples = samples + (SELECT samples FROM part.sweep), segments = "
                       "segments + (SELECT segments FROM part.sweep) WHERE id = (SELECT h.id FROM " SAME ")", e, "");
}

lw_status lw_store_add_curves(lw_store *s, const char *part, const lw_store_run *run, uint64_t *n_curve, lw_error *e)
{
    sqlite3_int64 n = 0;
    *n_curve = 0;
    lw_status status = lw_store_do(s, "ATTACH ?1 AS part", e, "t", part);
    if (status != LW_OK)
        return status;
    status = lw_store_begin(s, e);
    if (status == LW_OK)
        status = check_part(s, part, &n, e);
    if (status == LW_OK)
        status = lw_store_run_begin(s, run, e);
    if (status == LW_OK)
        status = copy_part(s, e);
    if (status == LW_OK)
        status = lw_store_run_end(s, e);
    if (status == LW_OK)
        status = lw_store_commit(s, e);
    if (status == LW_OK)
        *n_curve = (uint64_t)n;
    else
        lw_store_rollback(s);
    lw_error ignored;
    (void)lw_store_do(s, "DETACH part", &ignored, "");
    return status;
}

/* ---- linkages that were found ------------------------------------------------------------------------ */

lw_status lw_store_has_linkage(lw_store *s, const char *hash, bool *has, lw_error *e)
{
    sqlite3_int64 id;
    return lw_store_find(s, "SELECT id FROM linkage WHERE hash = ?1", &id, has, e, "t", hash);
}

/* -1: not known */
static double known(int v)
{
    return v < 0 ? NAN : v;
}

lw_status lw_store_put_linkage(lw_store *s, const lw_store_linkage *k, lw_error *e)
{
    return lw_store_do(s, "INSERT OR IGNORE INTO linkage(hash, name, links, dof, joints, sliders, kinds, label, type, "
                          "family, class, task, timing, target, source, objective, error, error_mean, error_rms, "
                          "error_max, error_curve, angle_error, crank, circuits, transmission_min, transmission_max, "
                          "size, closed, curve, terms, json, run) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, "
                          "?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22, ?23, ?24, ?25, ?26, ?27, ?28, ?29, "
                          "?30, ?31, ?32)", e, "ttiiiittttttttt" "ddddddd" "dd" "ddd" "d" "bbti", k->hash, k->name,
                       (long long)k->links, (long long)k->dof, (long long)k->joints, (long long)k->sliders, k->kinds,
                       k->label, k->type, k->family, k->four_bar, k->task, k->timing, k->target, k->source,
                       k->objective, k->error, k->error_mean, k->error_rms, k->error_max, k->error_curve,
                       k->angle_error, known(k->crank), known(k->circuits), k->transmission_min, k->transmission_max,
                       k->size, known(k->closed), k->curve, 2*k->n_curve*sizeof *k->curve, k->terms, k->terms_size,
                       k->json, (long long)s->run);
}

/* ---- blocks out of the store ------------------------------------------------------------------------ */

lw_status lw_store_block(lw_store *s, long long id, bool linkages, void *to, size_t size, lw_error *e)
{
    sqlite3_stmt *t;
    lw_status status = lw_store_prepare(s, linkages ? "SELECT linkages FROM curve_block WHERE id = ?1"
                                        : "SELECT terms FROM curve_block WHERE id = ?1", &t, e);
    if (status != LW_OK)
        return status;
    sqlite3_bind_int64(t, 1, id);
    int code = sqlite3_step(t);
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        status = lw_store_fail(s, code, "cannot be read", e);
    else if (code == SQLITE_DONE || (size_t)sqlite3_column_bytes(t, 0) != size)
        status = lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "block %lld of curves is not what its box says", id);
    else
        memcpy(to, sqlite3_column_blob(t, 0), size);
    sqlite3_reset(t);
    return status;
}
