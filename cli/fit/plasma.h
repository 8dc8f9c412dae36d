/* cli/fit/plasma.h - the tables that PLASMA prints (Makkonen 1999, paper F section 7). */
#ifndef CLI_FIT_PLASMA_H
#define CLI_FIT_PLASMA_H

#include <stdio.h>
#include "grammar/linkage/linkage.h"
#include "grammar/topology/lam.h"

/* The matrix, "Parts: 6 Joints: 7". */
void cli_plasma_matrix(const lw_lam *a, FILE *f);

/* Jnt Prt1 Prt2 Mar1 Mar2 Jtyp X Y F: joint number n of the matrix is joint n - 1 of the linkage; markers as in the
 * data set; types 11 pin, 12 slider, 13 pin in a slot; F the direction of a slide [rad].  Lengths in its units. */
void cli_plasma_joints(const lw_linkage *linkage, FILE *f);

/* Print the dimensions by name. */
lw_status cli_plasma_dimensions(const lw_linkage *linkage, FILE *f, lw_error *e);

/* PNT Time PosX PosY VelM VelX VelY AccM AccX AccY of the tracer over a second, as the data set drives it; then PNT and
 * the acceleration of each joint.  Its units and seconds.  LW_OPEN: it does not close somewhere, and says so. */
lw_status cli_plasma_path(const lw_linkage *linkage, int points, FILE *f, lw_error *e);

#endif
