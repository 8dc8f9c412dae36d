/* cli/chain_format.h - the ways a chain can be written, as a table. */
#ifndef LW_CLI_CHAIN_FORMAT_H
#define LW_CLI_CHAIN_FORMAT_H

#include <stdbool.h>
#include <stddef.h>
#include "grammar/chain.h"

typedef struct cli_chain_format {
    const char *name;
    size_t      size;                /* room for the longest text of a chain                    */
    bool        one_line;            /* a chain is one line                                     */
    size_t    (*print)(const lw_chain *c, char *text, size_t size);   /* with line end; its length */
} cli_chain_format;

/* As options name them, in the order of CLI_CHAIN_FORMATS. */
#define CLI_CHAIN_FORMATS "graph6|lam|sentence|franke|edges|json|dot|graphml"
enum { CLI_GRAPH6, CLI_LAM, CLI_SENTENCE, CLI_FRANKE, CLI_EDGES, CLI_JSON_LINES, CLI_DOT, CLI_GRAPHML };
extern const cli_chain_format cli_chain_formats[];

#endif
