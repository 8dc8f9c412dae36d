/* Product families of linkwright.h: readers of files, models read back, plain numbers. */
#include "base/real.h"
#include "grammar/family/master.h"
#include "grammar/model/model.h"
#include "grammar/model/spatial.h"
#include "surface/surface.h"

static lw_status parse(const char *text, size_t size, const char *file, void *out, lw_error *e)
{
    return lw_master_read(text, size, file ? file : "", out, e);
}

lw_status lw_master_parse(const char *text, size_t size, const char *file, lw_master **out, lw_error *error)
{
    return lw_master_read(text, size, file ? file : "", out, error);
}

lw_status lw_master_load(const char *path, lw_master **out, lw_error *error)
{
    *out = NULL;
    return lw_surface_load(path, parse, out, error);
}

void lw_master_destroy(lw_master *master) { lw_master_free(master); }
void lw_variant_destroy(lw_variant *variant) { lw_variant_free(variant); }

const char *lw_master_parameter_name(const lw_master *master, int i)
{
    const lw_parameter *p = lw_master_parameter(master, i);
    return p ? p->name : NULL;
}

lw_status lw_master_parameter_unit(const lw_master *master, int i, const char **unit, double range[2])
{
    const lw_parameter *p = lw_master_parameter(master, i);
    if (!p)
        return LW_E_ARG;
    *unit = p->unit;
    range[0] = p->has_range ? p->least : -INFINITY;
    range[1] = p->has_range ? p->most : INFINITY;
    return LW_OK;
}

lw_status lw_variant_number(lw_variant *variant, const char *formula, double *out, lw_error *error)
{
    return lw_variant_quantity(variant, formula, out, NULL, error);
}

lw_status lw_variant_text(lw_variant *variant, char **out, size_t *size, lw_error *error)
{
    lw_expansion x;
    *out = NULL;
    lw_status s = lw_variant_expand(variant, &x, error);
    if (s != LW_OK)
        return s;
    *out = x.text;
    *size = x.size;
    x.text = NULL;
    lw_expansion_free(&x);
    return LW_OK;
}

/* Expand and read as one of both; the other is NULL. */
static lw_status make(lw_variant *variant, lw_model **planar, lw_spatial **spatial, lw_error *error)
{
    lw_expansion x;
    lw_status s = lw_variant_expand(variant, &x, error);
    if (s != LW_OK)
        return s;
    bool is_spatial;
    if (lw_spatial_recognise(x.text, x.size, &is_spatial) != LW_OK)
        s = lw_error_set(error, LW_E_MEMORY, "out of memory");
    else if (is_spatial != !planar)
        s = lw_error_set(error, LW_E_KIND, planar ? "this model is spatial: lw_variant_spatial makes it" :
                         "this model is planar: lw_variant_model makes it");
    else
        s = planar ? lw_model_parse(x.text, x.size, "", planar, error) : lw_spatial_parse(x.text, x.size, "", spatial, error);
    if (s != LW_OK && s != LW_E_KIND)
        lw_expansion_fault(&x, error);
    lw_expansion_free(&x);
    return s;
}

lw_status lw_variant_model(lw_variant *variant, lw_model **out, lw_error *error)
{
    *out = NULL;
    return make(variant, out, NULL, error);
}

lw_status lw_variant_spatial(lw_variant *variant, lw_spatial **out, lw_error *error)
{
    *out = NULL;
    return make(variant, NULL, out, error);
}
