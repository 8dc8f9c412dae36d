/* catalogues/store/store_build.c - structures, chains, ground links and mechanisms into the store. */
#include "catalogues/store/store_internal.h"

lw_status lw_store_build_begin(lw_store *s, int links, int dof, const char *joints, uint64_t *done, bool *complete,
                               lw_error *e)
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
        status = lw_store_find(s, "SELECT complete FROM build WHERE id = ?1", &is_complete, &any, e, "i",
                               (long long)s->build);
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
