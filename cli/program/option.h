/* cli/program/option.h - options are declared once, as a table; parsing, defaults and --help come from it.
 *
 * A row says where in the command's settings the value belongs.  Defaults are written as a user
 * would type them and go through the same parser, so that what --help shows is what happens.
 * Understood: --name value, --name=value, -x value, -xvalue; "--" ends options; a word such as -3.5
 * is a number, never an option; the value may be negative.  An option given twice, options that
 * exclude each other and values outside their range are refused with a text that says what to do. */
#ifndef CLI_PROGRAM_OPTION_H
#define CLI_PROGRAM_OPTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include "base/error.h"

typedef enum cli_kind {
    CLI_FLAG,                 /* bool                                                              */
    CLI_TEXT,                 /* const char *; points into argv                                    */
    CLI_INPUT,                /* the same: the name of a file that is read                         */
    CLI_OUTPUT,               /* the same: the name of a file that is written                      */
    CLI_INT,                  /* int                                                               */
    CLI_SEED,                 /* uint64_t                                                          */
    CLI_REAL,                 /* double, finite                                                    */
    CLI_RANGE,                /* double[2], "MIN:MAX", MIN <= MAX                                  */
    CLI_SIZE,                 /* int[2], "WIDTHxHEIGHT"                                            */
    CLI_CHOICE                /* int, which of `argument` "path|function|motion"                   */
} cli_kind;

typedef struct cli_option {
    const char *name;         /* without dashes; NULL ends a table                                 */
    char        letter;       /* 'o' for -o; 0 for none                                            */
    cli_kind    kind;
    size_t      place;        /* offsetof(settings, member)                                        */
    const char *argument;     /* "FILE", "MIN:MAX", or the choices; NULL for a flag                */
    const char *fallback;     /* the default as typed; NULL leaves the member zero                 */
    const char *help;         /* what it does, no default (that is added)                          */
    double      least, most;  /* range of INT, REAL, RANGE, SIZE; both 0: any                      */
    const char *needs;        /* name of an option that must stand beside it; NULL                 */
    const char *excludes;     /* name of an option that must not; NULL                             */
} cli_option;

/* Settings every command has.  A command may declare a row of the same name with a default of its
 * own; its row then wins, and the member here stays at zero. */
typedef struct cli_common {
    uint64_t    seed;
    int         jobs;         /* 0: one per core                                                   */
    double      time;         /* [s]; 0: no limit                                                  */
    bool        json, force, quiet, help;
    const char *output;       /* NULL: standard output                                             */
} cli_common;

extern const cli_option cli_common_options[];

#define CLI_OPTION_MAX 64

typedef struct cli_parsed {
    const cli_option *options;          /* the command's own                                       */
    uint64_t          given;            /* bit i: row i of the command's table was given           */
    uint64_t          given_common;     /* the same for cli_common_options                         */
    int               n_word;
    const char      **word;             /* what is no option, in order (n_word); free with free()  */
} cli_parsed;

/* Read argv[0 .. argc-1] (without program and command name).  `settings` is the command's zeroed
 * struct.  LW_E_ARG with a text: wrong usage. */
lw_status cli_parse(const cli_option *options, int argc, char **argv, void *settings,
                    cli_common *common, cli_parsed *p, lw_error *e);

/* Was --name given by the user? */
bool cli_given(const cli_parsed *p, const char *name);

/* One value of the given kind, as the parser reads it: for lists inside a CLI_TEXT.  `name` is for
 * the message. */
lw_status cli_value(const cli_option *row, const char *name, const char *text, void *value,
                    lw_error *e);

/* What a row does, with its default, partners and opponents. */
#define CLI_HELP_SIZE 1024
void cli_option_text(const cli_option *row, char text[CLI_HELP_SIZE]);

/* A row as it stands in --help; the common rows that `shadow` does not replace. */
void cli_option_help(const cli_option *row, FILE *f);
void cli_common_help(const cli_option *shadow, FILE *f);

#endif
