/* grammar/topology/sentence.h - a topology as a sentence (Makkonen 1999, paper F, eq. 18 and 19).
 *
 *     ((1 r 2 r 3 r 4 r 5 r 6 r) (1 r 2 r 3 r 4 r) (1 r 4 r 5 r 6 r))        Watt
 *
 * A word is one region of a drawing in the plane, its boundary read as part, joint, part, joint, ...;
 * the outer region comes first; there are a = L + 1 words (eq. 17).  A joint is in two words, a
 * bridge joint twice in one.  A word may begin anywhere and go round its region in either sense, since rules 3
 * and 4 of the source leave inner words in the opposite sense.
 *
 * A chain whose graph is not planar has no regions.  Its sentence is a list of circuits that form a
 * cycle basis, L of them, and begins with the atom `basis`; a bridge joint, which lies in no circuit,
 * is a word of two parts:
 *
 *     (basis (1 r 2 r 3 r 4 r) (1 r 2 r 5 r 6 r) ...)
 *
 * ';' begins a comment that ends with the line, as in LISP.  Plain data, copied with '='. */
#ifndef LW_GRAMMAR_TOPOLOGY_SENTENCE_H
#define LW_GRAMMAR_TOPOLOGY_SENTENCE_H

#include <stddef.h>
#include "grammar/topology/mechanism.h"

#define LW_WORD_MAX (LW_JOINT_MAX + 1)
#define LW_ATOM_MAX (LW_JOINT_MAX*LW_LINK_MAX)

/* Room for any sentence as text. */
#define LW_SENTENCE_SIZE (6*LW_ATOM_MAX)

typedef struct lw_sentence {
    bool    basis;                    /* words are circuits of a basis, not regions        */
    int     n_word;
    int     first[LW_WORD_MAX + 1];   /* word w holds atoms first[w] .. first[w+1]-1       */
    uint8_t part[LW_ATOM_MAX];        /* part numbers as written, from 1                   */
    char    joint[LW_ATOM_MAX];       /* kind of the joint from this part to the next one  */
} lw_sentence;

/* The sentence of a connected mechanism of two links or more, without ground, inputs and output.  If the graph is
 * planar the words are regions: the longest first, the inner words sorted, each beginning with its lowest part.
 * Otherwise they are a shortest cycle basis.  The same mechanism gives the same sentence.  LW_E_ARG: not
 * connected, one link only. */
lw_status lw_sentence_from_mechanism(const lw_mechanism *m, lw_sentence *s);

/* The mechanism that a sentence describes, without ground, inputs and output: part n is link n - 1.  LW_E_NOTATION
 * when the words do not fit together; the message names the word and the part. */
lw_status lw_sentence_mechanism(const lw_sentence *s, lw_mechanism *m, lw_error *e);

/* One line without line end; returns the length as snprintf does. */
size_t lw_sentence_print(const lw_sentence *s, char *buf, size_t size);

/* Read one sentence and nothing after it, and check it as lw_sentence_mechanism does.  LW_E_NOTATION
 * with line and column: an unclosed word, an unknown joint letter, a part joined to itself, a joint
 * of two kinds, a joint that is not a side of two words, parts not numbered 1..P, words that depend on
 * each other. */
lw_status lw_sentence_read(const char *text, size_t size, const char *file, lw_sentence *s, lw_error *e);

#endif
