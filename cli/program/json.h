/* cli/program/json.h - JSON written as it is made: nothing is collected, so streams of any length work.
 *
 *     cli_json j = cli_json_begin(f, 2);
 *     cli_json_object(&j, NULL);
 *         cli_json_text(&j, "class", "GCRR");
 *         cli_json_array(&j, "limits");  cli_json_real(&j, NULL, 0.5);  cli_json_end(&j);
 *     cli_json_end(&j);
 *
 * Keys are given inside objects and NULL inside arrays.  Doubles read back bit-equal; NaN and
 * infinities, which JSON does not have, become null. */
#ifndef CLI_PROGRAM_JSON_H
#define CLI_PROGRAM_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define CLI_JSON_DEPTH 16

typedef struct cli_json {
    FILE *f;
    int   indent;                       /* spaces per level; 0: all on one line                    */
    int   depth;
    char  close[CLI_JSON_DEPTH];        /* '}' or ']' of each open level                           */
    bool  any[CLI_JSON_DEPTH];          /* the level already holds a value                         */
    bool  flat[CLI_JSON_DEPTH];         /* this level is written on one line                       */
} cli_json;

cli_json cli_json_begin(FILE *f, int indent);

/* Open the object of a whole answer: version and command line come first. */
void cli_json_head(cli_json *j, const char *command);

void cli_json_object(cli_json *j, const char *key);
void cli_json_array(cli_json *j, const char *key);
void cli_json_end(cli_json *j);                        /* the last one also ends the line          */

void cli_json_text(cli_json *j, const char *key, const char *text);          /* NULL: null         */
void cli_json_real(cli_json *j, const char *key, double v);
void cli_json_int(cli_json *j, const char *key, long long v);
void cli_json_seed(cli_json *j, const char *key, uint64_t v);
void cli_json_bool(cli_json *j, const char *key, bool v);
void cli_json_raw(cli_json *j, const char *key, const char *json);           /* text that is JSON  */
void cli_json_reals(cli_json *j, const char *key, const double *v, size_t n);   /* on one line     */

#endif
