/* cli/program/command.h - one row per command; main.c holds the table. */
#ifndef CLI_PROGRAM_COMMAND_H
#define CLI_PROGRAM_COMMAND_H

#include "cli/program/option.h"

/* Exit codes of the program (docs/linkwright.1.in). */
enum {
    CLI_DONE = 0, CLI_NOTHING = 1, CLI_USAGE = 2, CLI_BAD_INPUT = 3, CLI_NUMERIC = 4,
    CLI_LIMIT = 5                      /* main.c adds 128 + number of the signal that ended the command */
};

/* Kinds of content of a file; bits. */
typedef enum cli_kind_of_file {
    CLI_UNKNOWN = 0, CLI_LINKAGE = 1, CLI_RESULTS = 2, CLI_TARGET = 4, CLI_DRAWING = 8, CLI_TASK = 16,
    CLI_TOPOLOGIES = 32, CLI_CATALOGUE = 64,
    CLI_FOREIGN = 128,                 /* a linkage of Pyslvs or ADAMS                                 */
    CLI_BINARY = 256,
    CLI_LENGTHS = 512,                 /* lines of four lengths                                        */
    CLI_MASTER = 1024,                 /* a master file of a product family                            */
    CLI_CYCLE = 2048,                  /* a work cycle of axes                                         */
    CLI_SERVO = 4096,                  /* a servo axis                                                 */
    CLI_SPATIAL = 8192 | CLI_LINKAGE   /* a linkage in space                                           */
} cli_kind_of_file;

typedef struct cli_call {
    const struct cli_command *command;
    const void               *settings;     /* the command's own struct, filled                    */
    cli_common                common;
    cli_parsed                parsed;       /* words, and which options were given                 */
    const char               *line;         /* the whole command as typed in a shell               */
} cli_call;

/* If a command has actions, its first word chooses one: "catalogue build FILE". */
typedef struct cli_action {
    const char *name;                       /* "build"; NULL ends the list                         */
    const char *words;                      /* "FILE --links P"                                    */
    const char *about;                      /* lines of text                                       */
    int         least, most;                /* words after the name                                */
    int       (*run)(const cli_call *call); /* word[0] is the name; returns an exit code           */
    unsigned    reads;                      /* kinds of files among its words; 0: any              */
    const char *writes;                     /* as below                                            */
} cli_action;

typedef struct cli_command {
    const char       *name;                 /* "trace"                                             */
    const char       *words;                /* "MODEL.json"                                        */
    const char       *title;                /* one line for the list of commands                   */
    const char       *examples;             /* lines "command   # what it does", come first        */
    const char       *about;                /* what it prints, units, exit codes of its own        */
    const cli_option *options;
    size_t            settings_size;
    const cli_action *actions;              /* NULL: none; else the next three members are unused  */
    int               least_words, most_words;
    int             (*run)(const cli_call *call);   /* returns an exit code                        */
    unsigned          reads;                /* kinds of files among its words; 0: any              */
    bool              pictures;             /* -o takes pictures and files of other programs too   */
    const char       *writes;               /* kinds of data to -o: "text", "JSON"; NULL: tables (CSV) */
} cli_command;

extern const cli_command cli_simulate_command, cli_clearance_command, cli_fit_command, cli_classify_command,
                         cli_trace_command, cli_draw_command, cli_numbers_command, cli_structures_command,
                         cli_chains_command, cli_mechanisms_command, cli_grammar_command, cli_catalogue_command,
                         cli_bench_command, cli_mobility_command, cli_plasma_command, cli_convert_command, cli_profile_command, cli_robot_command,
                         cli_gallery_command, cli_drive_command, cli_family_command, cli_studio_command;

/* Help of one command, from its row, as a section of the manual page (cli/program/man.c). */
void cli_command_roff(const cli_command *c, FILE *f);
void cli_common_roff(FILE *f);

/* The completion script of bash for n commands. */
void cli_bash_completion(const cli_command *const *commands, int n, FILE *f);

#endif
