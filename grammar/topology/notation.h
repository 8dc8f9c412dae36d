/* grammar/topology/notation.h - all notations of a topology in one table, and streams of them.
 *
 * To add a notation, write its file and its row in notation.c; the command line finds it there.  A notation
 * leaves out what it cannot express: graph6 keeps freedoms but no joint kinds, the matrix and the sentence
 * keep no ground. */
#ifndef LW_GRAMMAR_TOPOLOGY_NOTATION_H
#define LW_GRAMMAR_TOPOLOGY_NOTATION_H

#include <stddef.h>
#include "grammar/topology/mechanism.h"

typedef struct lw_notation {
    const char *name;
    size_t      most;                  /* bytes that suffice for the text of any topology              */
    bool        lines;                 /* a text has several lines; else one line without line end     */
    bool        keeps_kinds;           /* joint kinds; else only the freedoms of each joint            */
    bool        keeps_choices;         /* ground link, inputs, output                                  */
    /* LW_E_NOTATION with line and column from the beginning of text; NULL: cannot be read. */
    lw_status (*read)(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e);
    /* *length as snprintf counts.  LW_E_KIND, LW_E_ARG: the notation cannot express this topology. */
    lw_status (*print)(const lw_mechanism *m, char *buf, size_t size, size_t *length);
} lw_notation;

/* Bytes that suffice for the text of any topology in any notation. */
#define LW_NOTATION_SIZE 16384

/* The rows; the last has name NULL. */
extern const lw_notation lw_notations[];

/* NULL when no notation has that name. */
const lw_notation *lw_notation_find(const char *name);

/* The notation of a text, judged by its beginning: '{' is JSON; '<' is GraphML; the word graph is DOT; '(' followed by '(' or a letter is a sentence,
 * any other '(' is Franke; digits followed by '-' are joints, other digits a matrix; anything else is graph6. */
const lw_notation *lw_notation_of(const char *text, size_t size);

/* A text with one topology after the other, in any mixture of notations that can be read.  Empty lines and lines
 * that begin with '#' may separate them.  A matrix ends at an empty line, a sentence, a JSON object and a DOT graph end at
 * their last bracket, GraphML with </graphml>, all others at the end of their line. */
typedef struct lw_topologies {
    const char *text, *file;           /* file for messages, may be NULL                               */
    size_t      size, at;              /* at: where reading continues                                  */
    long        line;                  /* of `at`, from 1                                              */
    size_t      length;                /* of the piece read last                                       */
    long        first_line;            /* line on which it begins                                      */
    const lw_notation *notation;       /* and its notation                                             */
    bool        more;                  /* more text follows later: a piece that reaches the end may be
                                          incomplete                                                   */
} lw_topologies;

lw_topologies lw_topologies_open(const char *text, size_t size, const char *file);

/* Read the next topology.  LW_NOTHING at the end.  LW_STOPPED if `more` is set and no complete piece is left: join
 * the text from `at` on with the text that follows, keep `line`, and call again.  After LW_E_NOTATION (with line
 * and column) the next call continues behind the faulty piece. */
lw_status lw_topologies_next(lw_topologies *t, lw_mechanism *m, lw_error *e);

#endif
