/* cli/motion/clearance.h - sweeps of a model with clearance over speeds and laws of contact. */
#ifndef CLI_MOTION_CLEARANCE_H
#define CLI_MOTION_CLEARANCE_H

#include "cli/program/output.h"
#include "mbs/dynamics/clearance.h"

#define CLI_CLEARANCE_LIST_MAX 10000

/* "80:400:2" from, to, step; "1e6,1e7"; both mixed.  Free with free().  LW_E_ARG with a text. */
lw_status cli_clearance_list(const char *name, const char *text, double **list, int *n, lw_error *e);

/* One law of contact of the sweep, with the model that has it. */
typedef struct cli_clearance_law {
    lw_clearance_model  model;
    double              stiffness, damping;
    lw_model           *m;                /* a copy that shares what the first one owns                 */
    lw_clearance_scene *scene;
} cli_clearance_law;

/* The pin of the first joint at one passing of the input's start. */
typedef struct cli_clearance_pass {
    double direction, force;              /* in the bush [deg], [N]                                     */
    bool   touching;
} cli_clearance_pass;

typedef struct cli_clearance_row {
    int       law;
    double    speed;                      /* in the unit of the call                                    */
    bool      done;
    lw_status status;
    lw_clearance_result r;
    char      why[256];                   /* of a failure                                              */
    int       n_pass, room_pass;
    cli_clearance_pass *pass;             /* of a call with `passes`, after settling                    */
} cli_clearance_row;

/* Where contact ends and comes back as the speed rises, of one law and joint; NAN: not within the sweep. */
typedef struct cli_clearance_limit {
    int    law, joint;
    double kept, lost;                    /* the first pair of neighbouring speeds with and without contact */
    double lost_again, kept_again;        /* the last pair the other way round                            */
    int    n_lost, n;
} cli_clearance_limit;

typedef struct cli_clearance {
    const cli_call *call;
    const char *unit;                     /* "rpm", "rad/s", "m/s"                                     */
    double      unit_size;                /* in rad/s or m/s                                           */
    lw_model   *model;
    lw_clearance_options o;
    bool        passes;                   /* keep the passes of the rows                                */
    double      refine;                   /* limits to so much; 0: as the sweep has them               */
    double      until;                    /* of lw_clock_wall; 0: no limit                             */
    int         n_law, n_speed, n_row, n_limit;
    double     *speed;
    cli_clearance_law   *law;
    cli_clearance_row   *row;
    cli_clearance_limit *limit;
} cli_clearance;

/* Make laws and rows; run them on all cores; find limits. */
lw_status cli_clearance_make(cli_clearance *c, const char *models, const char *stiffness, const char *damping,
                             const char *speeds, lw_error *e);
lw_status cli_clearance_run(cli_clearance *c, lw_error *e);
void      cli_clearance_free(cli_clearance *c);

void cli_clearance_csv(const cli_clearance *c, FILE *f);
void cli_clearance_limits(const cli_clearance *c, FILE *f);
void cli_clearance_json(const cli_clearance *c, FILE *f);

/* Speed against stiffness, contact kept or lost (Makkonen 1999, paper C, figures 16-17). */
lw_status cli_clearance_plot(const cli_clearance *c, const char *path, lw_error *e);

/* Direction of the pin in its bush at every passing, over speed: few points where motion is regular, many where it is
 * not. */
lw_status cli_clearance_passes(const cli_clearance *c, const char *path, lw_error *e);

/* The one run of a call of one law and one speed, in full: what of `history` (CSV), `path` (of the pin in its bush) and
 * `force` (over time) is not NULL. */
lw_status cli_clearance_detail(cli_clearance *c, const char *history, const char *path, const char *force, lw_error *e);

#endif
