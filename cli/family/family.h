/* cli/family/family.h - the actions of `linkwright family`. */
#ifndef CLI_FAMILY_FAMILY_H
#define CLI_FAMILY_FAMILY_H

#include "cli/program/command.h"
#include "grammar/family/master.h"

typedef struct cli_family_settings {
    const char *configuration, *view, *set, *map, *vary, *measure, *plot, *speed, *require, *minimise, *maximise,
        *solver;
    bool        sensitivity, normalised;
    int         samples, steps, max_evals;
    double      from, to;
} cli_family_settings;

int cli_family_expand(const cli_call *call);
int cli_family_table(const cli_call *call);
int cli_family_check(const cli_call *call);
int cli_family_sweep(const cli_call *call);
int cli_family_optimise(const cli_call *call);

/* Read the master of the command and make the variant that its options choose. */
lw_status cli_family_open(const cli_call *call, lw_master **m, lw_variant **v, lw_error *e);

/* The variant that the options choose. */
lw_status cli_family_variant(const cli_call *call, const lw_master *m, lw_variant **v, lw_error *e);

/* Set the parameters of a list NAME=VALUE,...  LW_E_ARG. */
lw_status cli_family_set(const char *list, lw_variant *v, lw_error *e);

/* Is the text a whole model?  Errors name the place in the master. */
lw_status cli_family_read_back(const lw_expansion *x, lw_error *e);

/* The next of a list "a=1,b=max(2, 3)": commas in brackets do not count.  *at moves behind it; false: the end. */
bool cli_family_next(const char **at, char *item, size_t size);

#endif
