/* cli/robot/robot.h - the robot command: a model with a tool and drives, moved to a posture; its actions. */
#ifndef CLI_ROBOT_ROBOT_H
#define CLI_ROBOT_ROBOT_H

#include "base/vec3.h"
#include "cli/program/output.h"
#include "mbs/analysis/budget.h"
#include "mbs/space/robot.h"
#include "mbs/space/space_adjust.h"

/* Values of the options, in the units of the user. */
typedef struct cli_robot_settings {
    const char *tool, *at, *turn, *drives, *plot, *force;
    double      max_condition, gap, play, slide_play;
    int         rays, grid;
    bool        links_only, frequency, budget, volume;
} cli_robot_settings;

typedef struct cli_robot {
    const cli_call   *call;
    const cli_robot_settings *s;
    lw_spatial       *given, *m;             /* read; its joints adjusted                            */
    lw_space_adjusted adjusted;
    bool              flat;                  /* read from a planar model                             */
    lw_robot          r;
    const char       *unit;
    double            metre;
    lw_quaternion     drawn;                 /* orientation of the tool in the file                  */
    lw_vec3           up, right, ahead;      /* of the level plane: right and ahead lie in it        */
    double           *q, *near, *more;       /* the posture in which all ways begin; numbers of the action (begin_ways) */
    lw_error          e;
} cli_robot;

/* ---- robot.c: the robot in its posture, and straight ways from there --------------------------------------- */

/* What drive i moves; is that an angle? */
static inline lw_spatial_measure cli_robot_drive_of(const cli_robot *j, int i)
{
    return j->m->n_drive ? j->m->drive[i] : j->m->input[i].measure;
}

static inline bool cli_robot_turns(const cli_robot *j, int i) { return cli_robot_drive_of(j, i).of == LW_OF_TURN; }

/* Read the model and move the tool or the drives where the options say.  Returns the exit code; _end frees in any case. */
int  cli_robot_begin(const cli_call *call, cli_robot *j);
void cli_robot_end(cli_robot *j);

/* Read three numbers, or two of a planar model, from the text of an option.  LW_E_ARG. */
lw_status cli_robot_read_numbers(const cli_robot *j, const char *option, const char *unit, const char *text, lw_vec3 *p, lw_error *e);

/* Begin an action whose ways all begin where the tool is now, with room for `more` numbers in j->more.  Returns the exit code. */
int  cli_robot_begin_ways(const cli_call *call, cli_robot *j, lw_robot_pose *p, size_t more);

/* Go back to where the ways begin. */
void cli_robot_go_back(cli_robot *j);

/* A direction of the level plane, at this angle from the right [rad].  Go there from where the ways begin until something stops the tool: *far [m]. */
lw_vec3   cli_robot_direction(const cli_robot *j, double angle);
lw_status cli_robot_follow_ray(cli_robot *j, double angle, double *far);

/* Can the drives not move the tool, whose longest way was `far`?  _cannot_move reports it (there is no workspace and no map) and
 * returns the exit code. */
bool cli_robot_gets_nowhere(const cli_robot *j, const lw_robot_pose *p, double far);
int  cli_robot_cannot_move(cli_robot *j, const lw_robot_pose *p);

/* v, or 0 where it is a rounding error beside `size`; print a unit vector. */
static inline double cli_robot_clean(double v, double size) { return fabs(v) < 1e-13*size ? 0 : v; }
void cli_robot_print_direction(FILE *f, lw_vec3 a);

/* ---- robot_budget.c ---------------------------------------------------------------------------------------- */

/* LW_E_ARG: nothing lets the tool stray. */
lw_status   cli_robot_budget_options(const cli_robot *j, lw_budget_options *o, lw_error *e);
const char *cli_robot_source_name(const lw_budget_source *s, char *text, size_t size);      /* "clearance of P1a" */

/* ---- actions; each returns the exit code ------------------------------------------------------------------- */

int cli_robot_budget(const cli_call *call);
int cli_robot_workspace(const cli_call *call);             /* robot_workspace.c */
int cli_robot_reachability(const cli_call *call);          /* the same          */
int cli_robot_map(const cli_call *call);                   /* robot_map.c       */

#endif
