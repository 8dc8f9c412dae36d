/* catalogues/pages/atlas_html_internal.h - the pages of an atlas, each from what is known of its chain. */
#ifndef LW_CATALOGUES_PAGES_ATLAS_HTML_INTERNAL_H
#define LW_CATALOGUES_PAGES_ATLAS_HTML_INTERNAL_H

#include "catalogues/pages/atlas_html.h"
#include "base/bytes.h"
#include "catalogues/draw/chain_layout.h"

/* The texts of a chain, one behind the other in a block of the catalogue's own. */
typedef enum lw_leaf_text {
    LW_LEAF_LABEL, LW_LEAF_GRAPH6, LW_LEAF_ASSORTMENT, LW_LEAF_FRANKE, LW_LEAF_SENTENCE, LW_LEAF_MATRIX,
    LW_LEAF_FORM, LW_LEAF_DERIVATION, LW_LEAF_TEXTS
} lw_leaf_text;

typedef struct lw_leaf {                       /* of the atlas: a chain */
    long long       id, symmetry, n_linkage;
    int             links, dof, joints, loops, grounds, planar;
    int             number, of;                /* place among those with as many links and freedoms, from 1 */
    char           *text[LW_LEAF_TEXTS];       /* "" when there is none                                     */
    lw_mechanism    chain;
    lw_chain_layout layout;
    int             n_ground, ground[LW_LINK_MAX], alike[LW_LINK_MAX];   /* links, from 1                   */
    lw_chain_layout *grounded;                 /* with each of them as the frame (n_ground); while the page is made */
    lw_status       status;                    /* of the layouts                                            */
} lw_leaf;

typedef struct lw_atlas_html {
    lw_store       *store;
    const lw_atlas_html_options *options;
    const char     *dir;
    size_t          n, room;
    lw_leaf        *leaf;
    lw_bytes        style, chain_script, index_script;
    bool            has_linkages;              /* the catalogue has a table of them                         */
    long long       n_other;                   /* linkages of chains that are not in the atlas              */
    size_t          n_page, n_byte;
} lw_atlas_html;

#define LW_LEAF_FILE 64
/* "chain-10-1-23.html" */
void lw_leaf_file(const lw_leaf *l, const char *kind, char file[LW_LEAF_FILE]);

/* "10 links, F = 1" */
void lw_leaf_family(const lw_leaf *l, char *out, size_t size);

/* The page of leaf i; out is empty at first. */
lw_status lw_atlas_chain_page(lw_atlas_html *a, size_t i, lw_bytes *out, lw_error *e);

/* The overview. */
void lw_atlas_index_page(const lw_atlas_html *a, lw_bytes *out);

/* Linkages of the chain with this label, NULL: of chains that are not in the atlas.  *n: how many are on the page; 0: out
 * stays empty. */
lw_status lw_atlas_linkage_page(lw_atlas_html *a, const lw_leaf *l, lw_bytes *out, int *n, lw_error *e);

/* Ask with one value or none; row as in lw_store_query. */
lw_status lw_atlas_ask(lw_atlas_html *a, const char *sql, const lw_value *value,
                       lw_status (*row)(void *, int, const char *const *, const lw_value *), void *context,
                       lw_error *e);

/* A text of a row, never NULL. */
const char *lw_value_text(const lw_value *v);

/* A value that is bound to ?1. */
lw_value lw_value_of_text(const char *text);
lw_value lw_value_of_integer(long long i);

#endif
