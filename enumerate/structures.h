/* enumerate/structures.h - all Franke structures, each once, with a derivation.
 *
 * They are grown level by level from the theta structure with the ears of grow.h; duplicates are removed by
 * canonical form after every step.  The order and the numbering of circles do not depend on the number of threads
 * nor on the library behind canon.h: fewer circles first, then by parent, then by ear (rule, a, b).  Of isomorphic
 * children the first is kept.
 *
 * Numbers for 2 .. 8 loops: 1, 4, 17, 118, 1198, 17133, 311757. */
#ifndef LW_ENUMERATE_STRUCTURES_H
#define LW_ENUMERATE_STRUCTURES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include "grammar/topology/structure.h"

/* Levels 2 .. loops.  A structure takes eight bytes: its last ear and its parent.  Read-only once made, so threads
 * can share it. */
typedef struct lw_structures lw_structures;

/* loops 2 .. LW_LOOP_MAX.  n_thread < 1: one per core.  LW_E_ARG, LW_E_MEMORY. */
lw_status lw_structures_create(int loops, int n_thread, lw_structures **set);

/* The same; tick is called from time to time in the calling thread, with the level at work and the number of
 * structures found there.  If it returns false: LW_STOPPED, nothing made. */
typedef bool lw_structures_tick(void *context, int loops, size_t found);
lw_status lw_structures_create_while(int loops, int n_thread, lw_structures_tick *tick, void *context, lw_structures **set);
/* The same, but only structures with at most `most_circles` circles; others are not grown. */
lw_status lw_structures_create_within(int loops, int most_circles, int n_thread, lw_structures_tick *tick,
                                      void *context, lw_structures **set);
void      lw_structures_free(lw_structures *set);

/* How many structures there are with a number of circles, and the sum of 1/|automorphisms of circles and lines| over
 * them, which generating functions give too (tests/test_structure.c). */
typedef struct lw_structures_tally { uint64_t n; long double weight; } lw_structures_tally;

/* Count the structures with one loop more than the set has, by circles, without storing them: the children that
 * lw_grow_once gives parent number part, part + n_part, ...  Parts have no structure in common and together are all.
 * by_circles (LW_CIRCLE_MAX + 1) does not depend on n_thread.  LW_E_ARG: the set has LW_LOOP_MAX loops; LW_E_MEMORY;
 * LW_STOPPED. */
lw_status lw_structures_count_next(const lw_structures *set, int part, int n_part, int n_thread, lw_structures_tick *tick,
                                   void *context, lw_structures_tally *by_circles);

/* Write the set to f, and read it again, so that work in many parts grows it once.  Growing nine loops takes a minute
 * of a core, reading them half a second.  The file holds, in little-endian order: "lwstruct", format 1 and loops (4
 * bytes each); for each level from 3 the number of structures (8 bytes) and their records of 8 bytes (parent, rule, a,
 * b, circles); the digest (8 bytes).  _write: LW_E_IO.  _read: LW_E_IO, LW_E_NOTATION for another or damaged file,
 * LW_E_MEMORY; path is for messages. */
lw_status lw_structures_write(const lw_structures *set, FILE *f);
lw_status lw_structures_read(FILE *f, const char *path, lw_structures **set, lw_error *e);

/* Read the file `path`, which must hold `loops` loops or more; if there is none, make the set as by _create_while and
 * write the file.  path NULL: only make the set. */
lw_status lw_structures_stored(const char *path, int loops, int n_thread, lw_structures_tick *tick, void *context,
                               lw_structures **set, lw_error *e);

/* A 64-bit fingerprint of the structures with 3 .. loops loops and their order. */
uint64_t lw_structures_digest(const lw_structures *set, int loops);

/* The most loops in the set; how many structures have `loops` loops. */
int    lw_structures_loops(const lw_structures *set);
size_t lw_structures_count(const lw_structures *set, int loops);

/* Structure number `index` (from 0) of those with `loops` loops, and its derivation. */
void lw_structures_get(const lw_structures *set, int loops, size_t index, lw_structure *s);
void lw_structures_derive(const lw_structures *set, int loops, size_t index, lw_derivation *d);

#endif
