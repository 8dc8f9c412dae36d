/* cli/fit/fit_settings.h - the options of the fit command, and what is made of them. */
#ifndef CLI_FIT_FIT_SETTINGS_H
#define CLI_FIT_FIT_SETTINGS_H

#include "cli/fit/fit.h"

/* Values of the options, in the units of the user (cmd_fit.c). */
typedef struct cli_fit_settings {
    const char *tolerance, *type, *bounds, *solver, *save, *plot, *length_unit, *angle_unit, *joints, *topology, *resume,
    *gear_ratios, *stations,
               *input_ratios, *point_links;
    int         task, timing, datum, starts, rounds, results, links, dof;
    double      budget;
    const char *tolerances, *smooth;
    double      weight_path, weight_angle, angle_length, min_transmission, max_acceleration;
    double      length_range[2], position_range[2], length_ratio, max_size, class_margin;
    bool        crank_only, full_turn, closed, open, exact, through_limits, unlimited, mpi;
    const char *keep;
} cli_fit_settings;

/* fit_spec.c: check what needs no look at the target, LW_E_ARG; the timing of the fit of a target; make the conditions
 * for the target of `set`, in SI units; read the lengths
 * "0.1mm,0.05mm" of --tolerances, in the unit u where they have none. */
lw_status cli_fit_check_conditions(const cli_call *call, lw_error *e);
lw_timing cli_fit_timing(const cli_call *call, const cli_fit_set *set);
lw_status cli_fit_make_spec(const cli_call *call, const cli_fit_set *set, lw_fit_spec *spec, lw_error *e);
lw_status cli_fit_read_tolerances(const char *text, const lw_units *u, lw_tolerances *of, lw_error *e);

/* fit_notes.c: what would do with less than a linkage: a single link draws a circle, or turns a body about a point; a parallelogram moves it
 * without turning; a slider moves straight.  Then notes on the results for a target.  On standard error. */
void cli_fit_note_simpler(const cli_call *call, const cli_fit_set *set);
void cli_fit_notes(const cli_call *call, const cli_fit_set *set);

#endif
