#include "cli/chain_format.h"

#include "grammar/edges.h"
#include "grammar/franke.h"
#include "grammar/graph6.h"
#include "grammar/lam.h"
#include "grammar/mechanism_json.h"
#include "grammar/sentence.h"

/* The text has `length` bytes; end its line. */
static size_t end_line(char *text, size_t length)
{
    text[length] = '\n';
    return length + 1;
}

static size_t print_graph6(const lw_chain *c, char *text, size_t size)
{
    return end_line(text, lw_graph6_print(c, text, size));
}

/* Matrices are kept apart by an empty line. */
static size_t print_lam(const lw_chain *c, char *text, size_t size)
{
    lw_mechanism m;
    lw_lam a;
    (void)lw_mechanism_from_chain(c, &m);
    lw_lam_from_mechanism(&m, &a);
    return end_line(text, lw_lam_print(&a, text, size));
}

static size_t print_sentence(const lw_chain *c, char *text, size_t size)
{
    lw_mechanism m;
    lw_sentence s;
    (void)lw_mechanism_from_chain(c, &m);
    return lw_sentence_from_mechanism(&m, &s) == LW_OK ? end_line(text, lw_sentence_print(&s, text, size)) : 0;
}

static size_t print_franke(const lw_chain *c, char *text, size_t size)
{
    lw_franke f;
    return lw_franke_from_chain(c, &f) == LW_OK ? end_line(text, lw_franke_print(&f, text, size)) : 0;
}

static size_t print_edges(const lw_chain *c, char *text, size_t size)
{
    lw_mechanism m;
    (void)lw_mechanism_from_chain(c, &m);
    return end_line(text, lw_edges_print(&m, text, size));
}

static size_t print_json(const lw_chain *c, char *text, size_t size)
{
    lw_mechanism m;
    (void)lw_mechanism_from_chain(c, &m);
    return end_line(text, lw_mechanism_write(&m, text, size));
}

static size_t print_dot(const lw_chain *c, char *text, size_t size)
{
    lw_mechanism m;
    (void)lw_mechanism_from_chain(c, &m);
    return lw_dot_print(&m, "chain", text, size);
}

static size_t print_graphml(const lw_chain *c, char *text, size_t size)
{
    lw_mechanism m;
    (void)lw_mechanism_from_chain(c, &m);
    return lw_graphml_print(&m, text, size);
}

/* Sizes leave a byte for the line end. */
const cli_chain_format cli_chain_formats[] = {
    [CLI_GRAPH6]     = { "graph6",   LW_GRAPH6_SIZE + 1,    true,  print_graph6   },
    [CLI_LAM]        = { "lam",      LW_LAM_SIZE + 2,       false, print_lam      },
    [CLI_SENTENCE]   = { "sentence", LW_SENTENCE_SIZE + 1,  true,  print_sentence },
    [CLI_FRANKE]     = { "franke",   LW_FRANKE_SIZE + 1,    true,  print_franke   },
    [CLI_EDGES]      = { "edges",    LW_EDGES_SIZE + 1,     true,  print_edges    },
    [CLI_JSON_LINES] = { "json",     LW_JOINT_MAX*16 + 128, true,  print_json     },
    [CLI_DOT]        = { "dot",      LW_DOT_SIZE,           false, print_dot      },
    [CLI_GRAPHML]    = { "graphml",  LW_GRAPHML_SIZE,       false, print_graphml  },
};
