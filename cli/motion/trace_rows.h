/* cli/motion/trace_rows.h - print the rows of `linkwright trace` as CSV or JSON. */
#ifndef CLI_MOTION_TRACE_ROWS_H
#define CLI_MOTION_TRACE_ROWS_H

#include <signal.h>
#include <stdio.h>
#include "cli/program/json.h"
#include "cli/program/progress.h"
#include "grammar/linkage/assembly.h"

#define CLI_ROW_ORDER 3
#define CLI_ROW_VALUES 12         /* x y vx vy ax ay jx jy angle angle_v angle_a angle_j           */
#define CLI_ROW_MOST   19         /* with --geometry: curvature pole_x pole_y pole_u pole_v inflection_x inflection_y */

/* Rows that are kept for a plot. */
typedef struct cli_kept {
    size_t  n, capacity;
    double *row;                  /* (n * width): leading column,
        then the values of each printed tracer; NaN between arcs */
    int     width, arc, only;     /* only: the arc to keep; 0: all                                 */
    char    lead[96], by[8];      /* "input [deg]"; what derivatives are taken by                  */
    bool    failed;               /* out of memory                                                 */
} cli_kept;

typedef struct cli_rows {
    FILE             *f;
    cli_json         *json;       /* NULL: CSV                                                     */
    lw_assembly       k;          /* a view                                                        */
    int               only;       /* the tracer that is printed; -1: all                           */
    bool              geometry;   /* with curvature, instant centre, inflection circle, double points */
    double           *path;       /* input, x, y of the printed tracers in the rows of this arc     */
    size_t            n_path, room;
    const volatile sig_atomic_t *stop;
    double            until;      /* clock [s] at which to stop; 0: never                          */
    bool              cut_short;  /* stopped early, after `done` rows                              */
    double            done, total;
    cli_progress     *progress;
    cli_kept         *kept;       /* NULL: rows are only printed                                   */
} cli_rows;

typedef struct cli_row {
    int         arc;
    const char *mode;
    int         n_lead;
    double     *lead;                                         /* input, or other leading columns    */
    bool        rates;                                        /* derivatives exist                  */
    double    (*value)[CLI_ROW_MOST];                         /* (n_tracer)                         */
} cli_row;

/* Space for a row of a linkage. */
#define CLI_ROW_SPACE double lead[2 + LW_INPUT_MAX], value[LW_TRACER_MAX][CLI_ROW_MOST]

/* Is this tracer printed?  How many are? */
static inline bool cli_rows_want(const cli_rows *r, int tracer) { return r->only < 0 || tracer == r->only; }
static inline int  cli_rows_tracers(const cli_rows *r) { return r->only < 0 ? r->k.n_tracer : 1; }

/* Values of a tracer in the units of the file.  p, a: place [m] and direction of its link [rad] with derivatives;
 * angle: of the tool [rad]. */
void cli_row_values(const cli_rows *r, const lw_vec2 *p, const double *a, double angle, double *value);

/* Does this input slide?  Its unit: of a length or of an angle.  "time" and all inputs, as column names or with their units. */
static inline bool cli_input_slides(const lw_assembly *k, int input) { return lw_joint_slides(k->joint[k->input[input].joint].kind); }
const char *cli_input_unit(const lw_assembly *k, int input);
void        cli_time_columns(const lw_assembly *k, bool units, char *text, size_t size);

/* Print "# units: ...".  lead: unit of the input; by: unit that derivatives are taken by. */
void cli_rows_units(const cli_rows *r, const char *lead, const char *by);

/* Print the column names; lead: the leading ones, separated by commas. */
void cli_rows_head(const cli_rows *r, const char *lead);

void cli_rows_put(cli_rows *r, const cli_row *row);

/* Called behind the rows of an arc: with --geometry the double points of the paths, as comments or as "double_points". */
void cli_rows_arc_end(cli_rows *r, int arc);

/* Called before each row: show the progress; true if printing must end here. */
bool cli_rows_stopped(cli_rows *r);

/* Draw what was kept: places, velocities and accelerations of the printed tracers over the leading column, a panel
 * for each unit. LW_E_ARG: too many tracers for one plot. */
lw_status cli_rows_plot(const cli_rows *r, const char *path, lw_error *e);

/* Print a number as in comments. */
void cli_row_number(FILE *f, double v);

#endif
