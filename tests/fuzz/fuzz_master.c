/* Any bytes are a master file, or have an error with a place; its model is made twice with the same bytes, or there is an
 * error; an error of the model's reader has a place in the master. */
#include "grammar/family/master.h"
#include "grammar/model/model.h"
#include "tests/fuzz/fuzz.h"

static void demand_place(lw_status s, const lw_error *e)
{
    demand(e->status == s && e->text[0] && memchr(e->text, '\0', sizeof e->text) != NULL);
    demand(s != LW_E_NOTATION || (e->line > 0 && e->column > 0));
}

static int one_input(const uint8_t *data, size_t size)
{
    static lw_model model;
    lw_master *m;
    lw_variant *v;
    lw_expansion x, again;
    lw_error e = { .text = "" };
    lw_status s = lw_master_read((const char *)data, size, "f", &m, &e);
    if (s != LW_OK) {
        demand_place(s, &e);
        return 0;
    }
    demand(lw_variant_create(m, &v) == LW_OK);
    for (int i = -1; i < 0 || lw_master_view(m, i); i++) {
        e = (lw_error){ .text = "" };
        demand(lw_variant_look(v, i < 0 ? NULL : lw_master_view(m, i), &e) == LW_OK);
        s = lw_variant_hold_checks(v, &e);
        if (s != LW_OK)
            demand_place(s, &e);
        s = lw_variant_expand(v, &x, &e);
        if (s != LW_OK) {
            demand_place(s, &e);
            continue;
        }
        demand(lw_variant_expand(v, &again, &e) == LW_OK && again.size == x.size && memcmp(again.text, x.text, x.size) == 0);
        s = lw_model_read(x.text, x.size, "model", &model, &e);
        if (s == LW_OK)
            lw_model_free(&model);
        else {
            lw_expansion_fault(&x, &e);
            demand_place(s, &e);
        }
        lw_expansion_free(&x);
        lw_expansion_free(&again);
    }
    lw_variant_free(v);
    lw_master_free(m);
    return 0;
}
