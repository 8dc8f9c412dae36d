/* cli/family/family.h - the actions of `linkwright family`. */
#ifndef CLI_FAMILY_FAMILY_H
#define CLI_FAMILY_FAMILY_H

#include "cli/program/command.h"
#include "grammar/master.h"

typedef struct cli_family_settings {
    const char *configuration, *view, *set, *map, *vary, *measure, *plot, *speed, *keep, *minimise, *maximise;
    bool        sensitivity, normalised;
    int         samples, steps, max_evals, solver;
    double      from, to;
} cli_family_settings;

int cli_family_expand(const cli_call *call);
int cli_family_table(const cli_call *call);
int cli_family_check(const cli_call *call);

/* Read the master of the command and make the variant that its options choose.  Free *text after the master. */
lw_status cli_family_open(const cli_call *call, lw_master **m, lw_variant **v, lw_error *e);

/* Is the text a whole model?  Errors name the place in the master. */
lw_status cli_family_read_back(const lw_expansion *x, lw_error *e);

/* The next of a list "a=1,b=max(2, 3)": commas in brackets do not count.  *at moves behind it; false: the end. */
bool cli_family_next(const char **at, char *item, size_t size);

#endif
