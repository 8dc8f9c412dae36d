/* catalogues/store/store.h - a catalogue: enumerated mechanisms and linkages that were found, kept in one SQLite
 * file.
 *
 * The file carries an application number and a schema version (docs/catalogue.md describes every table). Older files
 * are brought up to date when they are opened. Newer files, and files of other programs, are refused. Everything
 * written between lw_store_begin and lw_store_commit is stored together or not at all: a program that is killed loses
 * only what it had not committed, and the file stays whole.
 *
 * One program writes at a time. It holds FILE-lock, which contains its process number and command line and
 * disappears with it. Any number of programs may read meanwhile. A store belongs to one thread. */
#ifndef LW_CATALOGUES_STORE_STORE_H
#define LW_CATALOGUES_STORE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "base/error.h"

#define LW_STORE_APPLICATION 0x6C776361      /* "lwca": PRAGMA application_id                      */

typedef struct lw_store lw_store;

typedef struct lw_store_options {
    bool        write;       /* false: nothing in the file can be changed                           */
    bool        create;      /* make the file if it does not exist or is empty                      */
    double      wait;        /* at most so long for another program that writes [s]                 */
    const char *command;     /* command line of this program, shown to programs that wait           */
    const volatile int *stop;   /* queries end with LW_STOPPED when it becomes nonzero; NULL: nothing stops them */
} lw_store_options;

/* LW_E_IO: the file cannot be opened, is read-only, or another program writes to it (the text names the program);
 * LW_E_NOTATION: not a catalogue, written by a newer program, or damaged; LW_E_MEMORY. */
lw_status lw_store_open(const char *path, const lw_store_options *o, lw_store **store, lw_error *e);
void      lw_store_close(lw_store *s);       /* changes without commit are lost; NULL is allowed     */

const char *lw_store_path(const lw_store *s);

/* The schema version of the file when it was opened. */
int lw_store_found_version(const lw_store *s);

/* A transaction; transactions do not nest.  LW_E_IO when the disk is full or fails: then nothing of it is kept. */
lw_status lw_store_begin(lw_store *s, lw_error *e);
lw_status lw_store_commit(lw_store *s, lw_error *e);
void      lw_store_rollback(lw_store *s);

/* A run says which action of which program wrote the rows: every row written later points to it. An unfinished run
 * with the same values is continued. `what` says what is made ("links 8, dof 1, joints r"). Inside a transaction. */
typedef struct lw_store_run { const char *action, *what, *command; uint64_t seed; } lw_store_run;
lw_status lw_store_run_begin(lw_store *s, const lw_store_run *r, lw_error *e);
lw_status lw_store_run_end(lw_store *s, lw_error *e);

/* Copy the catalogue to another file, packed and without the times of its runs: the bytes depend on the rows and on the
 * version of SQLite, and not on when the rows were written.  Outside a transaction; the times are lost here, too. */
lw_status lw_store_copy_undated(lw_store *s, const char *path, lw_error *e);

/* ---- topologies ---------------------------------------------------------------------------------- */

/* A build: chains with this number of links and freedoms, joints of these kinds ("r", "rt").  *done: number of chains
 * committed so far, in the order of enumeration; *complete: whether these are all.  Inside a transaction. */
lw_status lw_store_build_begin(lw_store *s, int links, int dof, const char *joints, uint64_t *done, bool *complete, lw_error *e);
lw_status lw_store_build_done(lw_store *s, uint64_t done, bool complete, lw_error *e);

typedef struct lw_store_structure {
    int         loops, number;               /* number among structures with as many loops, from 1  */
    int         circles, lines;
    bool        planar;
    const char *form, *derivation;           /* as grammar/topology/derivation.h prints them                 */
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
    int            structure;                /* its number in lw_store_structure; 0: none           */
    const int     *n_with;                   /* links with 2 .. 6 joints                      (5)   */
    const char    *assortment;               /* "4 4 0": links with 2, 3, 4, ... joints             */
    uint64_t       symmetry;                 /* order of the automorphism group                     */
    bool           planar;
    int            n_ground;
    const uint8_t *ground, *alike;           /* link from 1; number of links alike      (n_ground)  */
    size_t         n_mechanism;
    const lw_store_mechanism *mechanism;     /* (n_mechanism)                                       */
    const void    *layout;                   /* places of joints for a picture; NULL: none          */
    size_t         layout_size;
} lw_store_chain;

/* Inside a transaction.  Rows that exist already stay as they are, so that nothing is stored twice. */
lw_status lw_store_put_structure(lw_store *s, const lw_store_structure *t, lw_error *e);
lw_status lw_store_put_chain(lw_store *s, const lw_store_chain *c, lw_error *e);

/* A chain with multiple joints (grammar/topology/multiple.h). */
typedef struct lw_store_multiple {
    const char *pins;                        /* canonical: the links on each pin                    */
    int         links, dof, joints, loops;
    const char *assortment;                  /* "6 2": links with 2, 3, ... pins                    */
    uint64_t    symmetry;
    bool        planar;                      /* it can be drawn without crossings                   */
    int         n_ground;
    const char *ground_links;                /* "1:2 3:1": link from 1, number of links alike       */
} lw_store_multiple;

lw_status lw_store_put_multiple(lw_store *s, const lw_store_multiple *m, lw_error *e);       /* as the two above */

/* ---- linkages that were found -------------------------------------------------------------------- */

/* NULL texts and numbers that are not finite (or -1 for crank, circuits, closed) are unknown. */
typedef struct lw_store_linkage {
    const char *hash;                        /* identifies the linkage: none is stored twice        */
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
/* Inside a transaction.  A linkage that exists already stays as it is. */
lw_status lw_store_put_linkage(lw_store *s, const lw_store_linkage *k, lw_error *e);

/* ---- asking -------------------------------------------------------------------------------------- */

typedef struct lw_store_query {
    const char     *sql;                     /* one SELECT                                          */
    const lw_value *value;                   /* for ?1, ?2, ...                            (n_value) */
    int             n_value;
    bool            foreign;                 /* written by a person: may only read tables           */
    bool          (*goes_on)(void *context); /* called now and then; false stops: LW_STOPPED.  NULL */
    /* Called for each row: name (n_column), value (n_column).  A status other than LW_OK ends the query and is
     * returned. */
    lw_status     (*row)(void *context, int n_column, const char *const *name, const lw_value *value);
    /* Called once with the names, before the first row; may be NULL. */
    lw_status     (*head)(void *context, int n_column, const char *const *name);
    void           *context;
} lw_store_query;

/* LW_E_NOTATION with SQLite's text and the column: a fault in the SQL; LW_E_ARG: the SQL would change something. */
lw_status lw_store_ask(lw_store *s, const lw_store_query *q, lw_error *e);

/* The number that a SELECT of one number gives; 0 when it gives no row. */
lw_status lw_store_number(lw_store *s, const char *sql, const lw_value *value, int n_value, long long *number, lw_error *e);

/* Has the file this table?  Files of older versions lack some. */
lw_status lw_store_has_table(lw_store *s, const char *table, bool *has, lw_error *e);

/* Let SQLite check every page, index and reference.  LW_E_NOTATION with the first fault. */
lw_status lw_store_verify(lw_store *s, lw_error *e);

#endif
