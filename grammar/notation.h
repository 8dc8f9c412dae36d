/* grammar/notation.h - all notations of a topology in one table, and streams of them.
 *
 * To add a notation, write its file and its row in notation.c; the command line finds it there.  What a
 * notation has no sign for is left out: graph6 keeps freedoms but no kinds, the matrix and the sentence
 * no ground. */
#ifndef LW_GRAMMAR_NOTATION_H
#define LW_GRAMMAR_NOTATION_H

#include <stddef.h>
#include "grammar/mechanism.h"

typedef struct lw_notation {
    const char *name, *about;          /* "graph6", one line for a list                                */
    size_t      most;                  /* bytes that hold the text of any topology                     */
    bool        lines;                 /* several lines each; else one line without line end           */
    /* LW_E_NOTATION with line and column from the beginning of text; NULL: cannot be read. */
    lw_status (*read)(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e);
    /* *length as snprintf counts.  LW_E_KIND, LW_E_ARG: the notation cannot say this. */
    lw_status (*print)(const lw_mechanism *m, char *buf, size_t size, size_t *length);
} lw_notation;

/* Room for the text of any topology in any notation. */
#define LW_NOTATION_SIZE 16384

/* The rows; the last has name NULL. */
extern const lw_notation lw_notations[];

/* NULL when there is none of that name. */
const lw_notation *lw_notation_find(const char *name);

/* The notation that a text is in, told by how it begins: '{' JSON, '(' with '(' or a letter behind it a
 * sentence, other '(' Franke, digits and '-' joints, other digits a matrix, else graph6. */
const lw_notation *lw_notation_of(const char *text, size_t size);

/* A text that holds one topology after the other, in any mixture of notations that can be read.  Empty
 * lines and lines that begin with '#' stand between; a matrix ends at an empty line, a sentence and a JSON
 * object at their last bracket, all others with their line. */
typedef struct lw_topologies {
    const char *text, *file;           /* file for messages, may be NULL                               */
    size_t      size, at;              /* at: what is still to be read begins here                     */
    long        line;                  /* of `at`, from 1                                              */
    size_t      first, length;         /* the piece that was read last                                 */
    long        first_line;            /* where it begins                                              */
    const lw_notation *notation;       /* and its notation                                             */
    bool        more;                  /* the text goes on behind `size`: a piece that reaches the end is
                                          not whole yet                                                */
} lw_topologies;

lw_topologies lw_topologies_open(const char *text, size_t size, const char *file);

/* The next one.  LW_NOTHING at the end; LW_STOPPED when there is `more` and no whole piece is left: bring what
 * stands from `at` on together with what follows, keep `line`, and go on.  After a fault (LW_E_NOTATION with its
 * place) one can go on too. */
lw_status lw_topologies_next(lw_topologies *t, lw_mechanism *m, lw_error *e);

#endif
