/* catalogues/build/release.h - a data set of chains, mechanisms and Assur groups that others can cite and check.
 *
 *     lw_release_size size = { .chains = 14, .mechanisms = 10, .groups = 12 };
 *     lw_release_write("release", &size, &control, &error);
 *
 * The folder gets (docs/catalogue.md, "A data set to cite"):
 *
 *     chains/links-08-dof-1.g6          one graph6 word a line, in the order of enumeration
 *     mechanisms/links-08-dof-1.csv     F > 0: chain, ground link, number of links equivalent to it
 *     assur-groups/links-04.csv         Baranov truss, link removed, class, order, assembly modes
 *     atlas.sqlite                      the same chains and mechanisms as a catalogue, for links up to `mechanisms`
 *     counts.csv, README.md, LICENSE.txt, CITATION.cff
 *     SHA256SUMS                        written last: a folder without it is not complete
 *
 * No file holds a date, a time or a name of the machine.  The same version of the program writes the same bytes for any
 * number of threads; atlas.sqlite also depends on the version of SQLite. */
#ifndef LW_CATALOGUES_BUILD_RELEASE_H
#define LW_CATALOGUES_BUILD_RELEASE_H

#include "catalogues/build/build.h"

/* Greatest numbers of links.  Mechanisms are chains of pins with a ground link; groups have an even number of links. */
typedef struct lw_release_size { int chains, mechanisms, groups; } lw_release_size;

/* Mechanisms with up to 4 links less than the chains, Assur groups with up to 2 less; and the command that makes this. */
#define LW_RELEASE_COMMAND 64
lw_release_size lw_release_sizes(int links, char command[LW_RELEASE_COMMAND]);

/* Write the data set into a folder that exists.  Files of the same names are replaced, each when it is complete.  What
 * was built of atlas.sqlite when a call was stopped is kept as atlas.sqlite.partial, and the same call goes on from it.
 * control->command should tell how to write the same folder again.
 * LW_E_ARG: chains or mechanisms below 3, mechanisms above chains, groups below 2; LW_E_IO, LW_E_MEMORY, LW_STOPPED. */
lw_status lw_release_write(const char *folder, const lw_release_size *size, const lw_build_control *control, lw_error *e);

#endif
