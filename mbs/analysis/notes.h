/* mbs/analysis/notes.h - what is to be said about a run, planar or spatial, in sentences: what was assumed, how accurate it is, which events it had. */
#ifndef LW_MBS_ANALYSIS_NOTES_H
#define LW_MBS_ANALYSIS_NOTES_H

#include "linkwright.h"       /* lw_note_sink */
#include "mbs/dynamics/dynamics.h"

/* All notes about the run of d that ended with the report r. */
void lw_dynamics_notes(lw_note_sink c, const lw_dynamics *d, const lw_dynamics_report *r);

/* Joints of an overconstrained linkage were adjusted: places [m], directions of axes [rad] (0: not said). */
void lw_note_adjusted(lw_note_sink c, double moved, double turned);

/* The drives lose control of the links between these values of the input or the time, in multiples of `unit`, which has this name.  how: what moves
 * there, "link ... turns about ..."; empty: not known. */
void lw_note_lost(lw_note_sink c, const char *what, const double between[2], double unit, const char *name, const char *how);

#endif
