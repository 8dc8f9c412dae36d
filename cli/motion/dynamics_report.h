/* cli/motion/dynamics_report.h - what simulate says about a run, planar or spatial. */
#ifndef CLI_MOTION_DYNAMICS_REPORT_H
#define CLI_MOTION_DYNAMICS_REPORT_H

#include <stdio.h>
#include "cli/program/command.h"
#include "cli/program/json.h"
#include "mbs/dynamics/dynamics.h"
#include "mbs/elastic/chain.h"

/* The formulation chosen, and why. */
void cli_dynamics_explain(const cli_call *call, const lw_dynamics_report *r);

/* Notes to standard error after a run. */
void cli_dynamics_notes(const cli_call *call, const lw_dynamics *d, const lw_dynamics_report *r);

/* The lowest pressure of a cylinder in the rows so far: 0 where none is below that of the air. */
typedef struct cli_suction { const char *state; double pressure, t; } cli_suction;

void cli_suction_see(cli_suction *low, const lw_states *states, const double *z, double t);
void cli_suction_note(const cli_call *call, const cli_suction *low);     /* if it is below vacuum */

/* Comment lines at the end of CSV rows; the end of the rows of a JSON object, and the object's end. */
void cli_dynamics_remarks(FILE *f, const lw_dynamics_report *r, lw_status status, const lw_error *e);
void cli_dynamics_tail(cli_json *j, const lw_dynamics *d, const lw_dynamics_report *r, lw_status status, const lw_error *e);

/* A piece of a condensed bar bends as if it had no axial force.  The greatest such force over the buckling load of the piece with hinged ends
 * [-], negative in compression, and the bar; at first { 0, NULL }. */
typedef struct cli_pull { double share; const lw_elastic_chain *chain; } cli_pull;

/* Look at a piece with this axial force [N], length [m] and least second moment [m^4]. */
void cli_pull_see(cli_pull *p, const lw_elastic_chain *c, double normal, double length, double second);

/* Say so where the bending may be off by a hundredth: of a cantilever by 0.3 to 0.6 of the share in tension, by more in compression.  node: name of
 * the first node of the bar, NAME.0. */
void cli_note_pull(const cli_call *c, const cli_pull *p, const char *node);

#endif
