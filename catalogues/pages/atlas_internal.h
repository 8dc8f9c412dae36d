/* catalogues/pages/atlas_internal.h - the chains of an atlas, as atlas_html.c reads them and atlas_pages.c writes them. */
#ifndef LW_CATALOGUES_PAGES_ATLAS_INTERNAL_H
#define LW_CATALOGUES_PAGES_ATLAS_INTERNAL_H

#include "catalogues/draw/chain_drawing.h"
#include "catalogues/pages/atlas_html.h"

#define LW_LEAF_FILE 64        /* bytes of the name of a page */
#define LW_LEAF_BLOCK 32       /* chains of a block, whose pictures are computed together, by all threads; atlas_block.js
                                * knows this number */

/* The texts of a chain, one after the other in one block of memory. */
typedef enum lw_html_text_of {
    LW_LEAF_LABEL, LW_LEAF_GRAPH6, LW_LEAF_ASSORTMENT, LW_LEAF_FRANKE, LW_LEAF_SENTENCE, LW_LEAF_MATRIX,
    LW_LEAF_FORM, LW_LEAF_DERIVATION, LW_LEAF_TEXTS
} lw_html_text_of;

typedef struct lw_html_leaf {                /* a chain of the atlas */
    long long       id, symmetry, n_linkage;
    int             n_slider;                  /* mechanisms with sliders, known when its page is written   */
    int             links, dof, joints, loops, grounds, planar;
    bool            in_block;                  /* its family is written in blocks                           */
    bool            multiple;                  /* it has multiple joints: LW_LEAF_LABEL is the links on each pin */
    uint32_t        axes;                      /* of `chain`: grammar/topology/multiple.h                            */
    int             number, of;               /* number among the `of` chains of its family, from 1         */
    char           *text[LW_LEAF_TEXTS];       /* "" if there is none                                       */
    lw_mechanism    chain;
    lw_chain_layout layout;
    int             n_ground, ground[LW_LINK_MAX], alike[LW_LINK_MAX];   /* links, from 1                   */
    lw_chain_layout *grounded;   /* layouts with each of them as the frame (n_ground); only while the page is written */
    lw_status       status;                    /* of the layouts                                            */
} lw_html_leaf;

typedef struct lw_html_atlas {
    lw_store       *store;
    const lw_atlas_html_options *options;
    const char     *dir;
    size_t          n, capacity;
    lw_html_leaf   *leaf;
    lw_bytes        style, chain_script, index_script, block_script;
    bool            has_blocks;                /* some family is written in blocks                          */
    bool            has_linkages;              /* the catalogue has a table of linkages                     */
    size_t          n_multiple;                /* chains with multiple joints                               */
    long long       n_other;                   /* linkages of chains that are not in the atlas              */
    size_t          n_page, n_byte;
} lw_html_atlas;

static inline const char *lw_html_text(const lw_value *v)
{
    return v->kind == LW_VALUE_TEXT && v->text ? v->text : "";
}

static inline lw_value lw_html_integer_value(long long i)
{
    return (lw_value){ .kind = LW_VALUE_INTEGER, .integer = i };
}

/* The name of a page of a chain: "chain", "sliders", "linkages". */
void lw_html_page_file(const lw_html_leaf *l, const char *kind, char file[LW_LEAF_FILE]);

/* Ask the catalogue; value: the only one of the question, NULL: none. */
lw_status lw_html_ask(lw_html_atlas *a, const char *sql, const lw_value *value,
                      lw_status (*row)(void *, int, const char *const *, const lw_value *), void *context,
                      lw_error *e);

/* The overview. */
void lw_html_index_page(const lw_html_atlas *a, lw_bytes *b);

/* The page of chain i. */
lw_status lw_html_chain_page(lw_html_atlas *a, size_t i, lw_bytes *b, lw_error *e);

/* The page of the mechanisms of a chain that have sliders; empty if there are none.  *n: their number. */
lw_status lw_html_slider_page(lw_html_atlas *a, const lw_html_leaf *l, lw_bytes *b, int *n, lw_error *e);

/* One chain of a block: [linkages, places, rings, properties, notations, ground links]; a ground link is [link, alike,
 * places, rings, mechanisms listed, all mechanisms]. */
lw_status lw_html_json_chain(lw_html_atlas *a, const lw_html_leaf *l, lw_bytes *b, lw_error *e);

/* The page that shows any chain of the blocks. */
void lw_html_block_page(const lw_html_atlas *a, lw_bytes *b);

/* The page of the linkages of a chain, or with NULL of those of chains that are not in the atlas; empty if there are none.  *n: their number. */
lw_status lw_html_linkage_page(lw_html_atlas *a, const lw_html_leaf *l, lw_bytes *out, int *n, lw_error *e);

#endif
