/* A product family: all configurations of a master file, their masses and the greatest forces of their cylinders.
 *
 *     cc family.c $(pkg-config --cflags --libs linkwright) -lm -o family
 *     ./family examples/families/loader.json                                                             */
#include <linkwright.h>
#include <math.h>
#include <stdio.h>

static double peak;

static lw_status greatest(void *context, const lw_simulation_sample *sample)
{
    (void)context;
    peak = fmax(peak, fabs(sample->drive[0]));
    return LW_OK;
}

int main(int argc, char **argv)
{
    const char *file = argc > 1 ? argv[1] : "examples/families/loader.json";
    lw_master *master = NULL;
    lw_variant *variant = NULL;
    lw_error error = { LW_OK, "", 0, 0, "" };
    lw_status status = lw_master_load(file, &master, &error);
    if (status == LW_OK)
        status = lw_variant_create(master, &variant);
    for (int i = -1; status == LW_OK && (i < 0 || lw_master_configuration(master, i)); i++) {
        const char *name = i < 0 ? NULL : lw_master_configuration(master, i);
        lw_model *model = NULL;
        lw_simulation *run = NULL;
        lw_simulation_options options = lw_simulation_options_default();
        double mass = 0;
        options.to = 2;
        peak = 0;
        if ((status = lw_variant_configure(variant, name, &error)) == LW_OK
            && (status = lw_variant_hold_checks(variant, &error)) == LW_OK
            && (status = lw_variant_number(variant, "boom_mass", &mass, &error)) == LW_OK
            && (status = lw_variant_model(variant, &model, &error)) == LW_OK
            && (status = lw_simulation_create(model, &options, &run, &error)) == LW_OK
            && (status = lw_simulation_run(run, greatest, NULL, NULL, &error)) == LW_OK)
            printf("%-12s boom %6.1f kg, lift cylinder %5.1f kN\n", name ? name : "(defaults)", mass, peak/1000);
        lw_simulation_destroy(run);
        lw_model_destroy(model);
    }
    if (status != LW_OK)
        fprintf(stderr, "%s:%ld: %s\n", error.file, error.line, error.text);
    lw_variant_destroy(variant);
    lw_master_destroy(master);
    return status != LW_OK;
}
