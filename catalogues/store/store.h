/* catalogues/store/store.h - a catalogue: what was enumerated and what was found, kept in one SQLite file.
 *
 * The file carries an application number and a schema version (docs/catalogue.md has every table).  Older
 * files are brought up to date when they are opened; newer ones, and files of other programs, are refused.
 * All that is written between lw_store_begin and lw_store_commit arrives together or not at all: a program
 * that is killed loses what it had not committed, never more, and leaves a whole file.
 *
 * One program writes at a time: it holds FILE-lock, in which its process number and command line stand, and
 * which disappears with it.  Any number may read meanwhile.  A store belongs to one thread. */
#ifndef LW_CATALOGUES_STORE_STORE_H
#define LW_CATALOGUES_STORE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "base/error.h"

#define LW_STORE_APPLICATION 0x6C776361      /* "lwca": PRAGMA application_id                      */

typedef struct lw_store lw_store;

typedef struct lw_store_options {
    bool        write;       /* else nothing in the file can be changed                             */
    bool        create;      /* make the file when there is none (or an empty one)                  */
    double      wait;        /* for another program that writes [s]                                 */
    const char *command;     /* of the program that writes, for those who wait                      */
} lw_store_options;

/* LW_E_IO: cannot be opened, is read-only, is being written by another program (the text names it);
 * LW_E_NOTATION: no catalogue, one of a newer program, damaged; LW_E_MEMORY. */
lw_status lw_store_open(const char *path, const lw_store_options *o, lw_store **store, lw_error *e);
void      lw_store_close(lw_store *s);       /* what was not committed is gone; NULL is fine         */

const char *lw_store_path(const lw_store *s);

/* The schema version that this program writes, and that of the file when it was opened. */
int lw_store_version(void);
int lw_store_found_version(const lw_store *s);

/* A transaction; they do not nest.  LW_E_IO when the disk is full or fails: then nothing of it was kept. */
lw_status lw_store_begin(lw_store *s, lw_error *e);
lw_status lw_store_commit(lw_store *s, lw_error *e);
void      lw_store_rollback(lw_store *s);

/* Who writes, why, and how: every row written later points to it.  An unfinished run with all the same is
 * gone on with.  `what` says what is made ("links 8, dof 1, joints r").  Inside a transaction. */
typedef struct lw_store_run { const char *action, *what, *command; uint64_t seed; } lw_store_run;
lw_status lw_store_run_begin(lw_store *s, const lw_store_run *r, lw_error *e);
lw_status lw_store_run_end(lw_store *s, lw_error *e);

/* ---- topologies ---------------------------------------------------------------------------------- */

/* Chains with so many links and freedoms, their joints of these kinds ("r", "rt").  *done: how many chains were
 * committed before, in the order of enumeration; *complete: all of them.  Inside a transaction. */
lw_status lw_store_build_begin(lw_store *s, int links, int dof, const char *joints, uint64_t *done, bool *complete,
                               lw_error *e);
lw_status lw_store_build_done(lw_store *s, uint64_t done, bool complete, lw_error *e);

typedef struct lw_store_structure {
    int         loops, number;               /* place among those with so many loops, from 1        */
    int         circles, lines;
    bool        planar;
    const char *form, *derivation;           /* as grammar/derivation.h prints them                 */
} lw_store_structure;

typedef struct lw_store_mechanism {
    int         ground;                      /* link, from 1                                        */
    const char *kinds;                       /* letters, joint by joint                             */
    const char *inputs;                      /* "1-2", "1-2 3-4"                                    */
    const char *groups;                      /* "I1:2 II2:3,4": class, order and links              */
    int         n_slider, n_group, highest;  /* class of the highest group; 0: not known            */
    long        modes;                       /* assembly modes in all; 0: not known                 */
} lw_store_mechanism;

typedef struct lw_store_chain {
    const char    *label;                    /* canonical, graph6: two chains have the same one
                                              * exactly when they are isomorphic                    */
    const char    *graph6, *franke, *sentence, *matrix;       /* in the numbering of the rest       */
    int            links, dof, joints, loops;
    int            structure;                /* its number among those with so many loops; 0: none  */
    const int     *n_with;                   /* links with 2 .. 6 joints                      (5)   */
    const char    *assortment;               /* "4 4 0": links with 2, 3, 4, ... joints             */
    uint64_t       symmetry;                 /* order of the automorphism group                     */
    bool           planar;
    int            n_ground;
    const uint8_t *ground, *alike;           /* link from 1; how many are like it       (n_ground)  */
    size_t         n_mechanism;
    const lw_store_mechanism *mechanism;     /* (n_mechanism)                                       */
    const void    *layout;                   /* places of joints for a picture; NULL: none          */
    size_t         layout_size;
} lw_store_chain;

/* Inside a transaction.  What is in the file already stays as it is, so that nothing is there twice. */
lw_status lw_store_put_structure(lw_store *s, const lw_store_structure *t, lw_error *e);
lw_status lw_store_put_chain(lw_store *s, const lw_store_chain *c, lw_error *e);

/* ---- linkages that were found -------------------------------------------------------------------- */

/* NULL texts and numbers that are not finite (or -1 for crank, circuits, closed) are unknown. */
typedef struct lw_store_linkage {
    const char *hash;                        /* of all that tells it from others: no linkage is there twice */
    const char *json;                        /* docs/notation.md, "Linkage"                         */
    const char *name, *kinds;                /* kinds: letters, joint by joint                      */
    int         links, dof, joints, sliders;
    const char *label;                       /* of its chain, as in lw_store_chain                  */
    const char *type, *family, *four_bar;    /* "RRRR", "crank-rocker", "GCRR"                      */
    const char *task, *timing, *target;      /* what it was fitted to                               */
    const char *source;                      /* the file it came from                               */
    double      objective, error;            /* error: mean distance over the length of the path [1] */
    double      error_mean, error_rms, error_max, error_curve;                     /* [m]           */
    double      angle_error;                 /* mean [rad]                                          */
    double      transmission_min, transmission_max;                                /* [rad]         */
    double      size;                        /* root mean square distance of its curve's points from their mean [m] */
    int         crank, circuits, closed;
    const float *curve;                      /* x, y one after the other [m]              (2*n_curve) */
    size_t      n_curve;
    const void *terms;                       /* the lw_packed of its curve; NULL: none              */
    size_t      terms_size;
} lw_store_linkage;

lw_status lw_store_has_linkage(lw_store *s, const char *hash, bool *has, lw_error *e);
/* Inside a transaction; one that is there already stays. */
lw_status lw_store_put_linkage(lw_store *s, const lw_store_linkage *k, lw_error *e);

/* ---- asking -------------------------------------------------------------------------------------- */

typedef struct lw_store_query {
    const char     *sql;                     /* one SELECT                                          */
    const lw_value *value;                   /* for ?1, ?2, ...                            (n_value) */
    int             n_value;
    bool            foreign;                 /* a person's own: reading tables is all it may do     */
    bool          (*goes_on)(void *context); /* asked now and then; false: LW_STOPPED.  NULL        */
    /* Each row; anything but LW_OK ends it and is returned.  name (n_column), value (n_column). */
    lw_status     (*row)(void *context, int n_column, const char *const *name, const lw_value *value);
    /* The names once, before the first row; may be NULL. */
    lw_status     (*head)(void *context, int n_column, const char *const *name);
    void           *context;
} lw_store_query;

/* LW_E_NOTATION with SQLite's text and the column for a fault of the SQL; LW_E_ARG: it would change something. */
lw_status lw_store_ask(lw_store *s, const lw_store_query *q, lw_error *e);

/* The one number a SELECT gives; 0 for none. */
lw_status lw_store_number(lw_store *s, const char *sql, const lw_value *value, int n_value, long long *number,
                          lw_error *e);

/* SQLite's own examination of every page, index and reference.  LW_E_NOTATION with its first complaint. */
lw_status lw_store_verify(lw_store *s, lw_error *e);

#endif
