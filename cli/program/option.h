/* cli/program/option.h - options are declared once, in a table; parsing, defaults and --help come from it.
 *
 * A row says where in the command's settings the value belongs. Defaults are written as a user would type them and go
 * through the same parser, so --help shows the true defaults. Accepted forms: --name value, --name=value, -x value,
 * -xvalue; "--" ends options. A word such as -3.5 is a number and never an option; values may be negative. An option
 * given twice, options that exclude each other, and values outside their range are errors with a text that says what to
 * do. */
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
    CLI_INPUT,                /* as TEXT: the name of a file that is read                          */
    CLI_STORE,                /* as INPUT: a file that is written if there is none                  */
    CLI_OUTPUT,               /* as TEXT: the name of a file that is written                       */
    CLI_PLOT,                 /* as OUTPUT: a plot; the name ends in .svg, .pdf or .png            */
    CLI_GIF,                  /* as OUTPUT: an animation; the name ends in .gif                    */
    CLI_INT,                  /* int                                                               */
    CLI_SEED,                 /* uint64_t                                                          */
    CLI_REAL,                 /* double, finite                                                    */
    CLI_RANGE,                /* double[2], "MIN:MAX", MIN <= MAX                                  */
    CLI_SIZE,                 /* int[2], "WIDTHxHEIGHT"                                            */
    CLI_CHOICE                /* int, index of a word in `argument` "path|function|motion"         */
} cli_kind;

typedef struct cli_option {
    const char *name;         /* without dashes; NULL ends a table                                 */
    char        letter;       /* 'o' for -o; 0 for none                                            */
    cli_kind    kind;
    size_t      place;        /* offsetof(settings, member)                                        */
    const char *argument;     /* "FILE", "MIN:MAX", or the choices; NULL for a flag                */
    const char *fallback;     /* the default as typed; NULL leaves the member zero                 */
    const char *help;         /* what it does, without the default, which is added                 */
    double      least, most;  /* range of INT, REAL, RANGE, SIZE; both 0: any                      */
    const char *needs;        /* name of an option that must also be given; NULL                   */
    const char *excludes;     /* name of an option that must not be given; NULL                    */
} cli_option;

/* Settings of every command. If a command declares a row of the same name with its own default, that row is used, and
 * the member here stays zero. */
typedef struct cli_common {
    uint64_t    seed;
    int         jobs;         /* 0: one per core                                                   */
    double      time;         /* [s]; 0: no limit                                                  */
    double      memory;       /* [GB]; 0: three quarters of the machine's (cli_memory)             */
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
    const char      **word;             /* words that are no options, in order (n_word); free with free() */
} cli_parsed;

/* Read argv[0 .. argc-1], without the names of program and command. settings: the command's struct, zeroed. LW_E_ARG
 * with a text: wrong usage. */
lw_status cli_parse(const cli_option *options, int argc, char **argv, void *settings, cli_common *common, cli_parsed *p, lw_error *e);

/* Was --name given by the user? */
bool cli_given(const cli_parsed *p, const char *name);

/* Read one value as the parser does, for lists inside a CLI_TEXT. name: for the message. */
lw_status cli_value(const cli_option *row, const char *name, const char *text, void *value, lw_error *e);

/* Text of a row, with its default and the options it needs or excludes. */
#define CLI_HELP_SIZE 1024
void cli_option_text(const cli_option *row, char text[CLI_HELP_SIZE]);

/* Print a row as in --help. Common rows are printed unless `shadow` replaces them. */
void cli_option_help(const cli_option *row, FILE *f);
void cli_common_help(const cli_option *shadow, FILE *f);

#endif
