/* Motors for a model: what its cycle asks of each drive, and the three cheapest choices that can do it.
 *
 *     cc drives.c $(pkg-config --cflags --libs linkwright) -o drives
 *     ./drives examples/drives/lifting-arm.json 2.5 examples/drives/motors.csv examples/drives/gears.csv \
 *              examples/drives/amplifiers.csv                                                                     */
#include <linkwright.h>
#include <stdio.h>
#include <stdlib.h>

static lw_status print_choices(const lw_load *load, const lw_drive_parts *parts, lw_error *error)
{
    lw_load_figures figures = lw_load_figures_of(load);
    lw_drive_choice *choice = NULL;
    bool *front = NULL;
    size_t n = 0;
    printf("%s: peak %.4g, rms %.4g %s, speed %.4g %s\n", load->name, figures.torque_peak, figures.torque_rms,
           load->slides ? "N" : "N m", figures.speed_peak, load->slides ? "m/s" : "rad/s");
    lw_status status = lw_drive_choose(load, parts, 10, NULL, &n, &choice, &front, error);
    for (size_t i = 0; status == LW_OK && i < n && i < 3; i++) {
        const char *gear = lw_drive_parts_name(parts, 'g', choice[i].gear);
        printf("%c %s, %s, %s: cost %g, uses %.0f %% of its limits\n", front[i] ? '*' : ' ',
               lw_drive_parts_name(parts, 'm', choice[i].motor), gear ? gear : "no gear",
               choice[i].amplifier < 0 ? "any amplifier" : lw_drive_parts_name(parts, 'a', choice[i].amplifier),
               choice[i].cost, 100*choice[i].worst);
    }
    lw_free(choice);
    lw_free(front);
    return status;
}

int main(int argc, char **argv)
{
    static const char *const parts_files[] = { "examples/drives/motors.csv", "examples/drives/gears.csv",
                                               "examples/drives/amplifiers.csv" };
    const char *file = argc > 1 ? argv[1] : "examples/drives/lifting-arm.json";
    double end = argc > 2 ? atof(argv[2]) : 2.5;
    lw_model *model = NULL;
    lw_drive_parts *parts = NULL;
    lw_loads loads = { 0, NULL, NULL };
    lw_error error = { LW_OK, "", 0, 0, "" };
    lw_status status = lw_model_load(file, &model, &error);
    for (int i = 3; status == LW_OK && i < argc; i++)
        status = lw_drive_parts_load(argv[i], &parts, &error);
    for (int i = 0; status == LW_OK && argc <= 3 && i < 3; i++)
        status = lw_drive_parts_load(parts_files[i], &parts, &error);
    if (status == LW_OK)
        status = lw_model_loads(model, 0, end, 1000, &loads, &error);
    for (int i = 0; status == LW_OK && i < loads.n; i++)
        status = print_choices(&loads.load[i], parts, &error);
    if (status != LW_OK)
        fprintf(stderr, "%s: %s\n", error.file[0] ? error.file : file, error.text);
    lw_loads_free(&loads);
    lw_drive_parts_destroy(parts);
    lw_model_destroy(model);
    return status != LW_OK;
}
