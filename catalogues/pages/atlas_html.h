/* catalogues/pages/atlas_html.h - a catalogue as a folder of web pages that work from a disk, without a server.
 *
 *     index.html             overview by links and assortment; search and filter over all chains, with pictures
 *     chain-P-F-N.html       a chain: picture, properties, notations to copy, ground links with inputs and Assur groups
 *     sliders-P-F-N.html     pictures of its mechanisms with sliders, if the catalogue has them
 *     linkages-P-F-N.html    linkages found for that chain, moving (page.h); linkages-other.html: all others
 *
 *     chain.html#P-F-N       the same for families (P, F) of many chains, whose contents stand in blocks of 32 chains,
 *     chains-P-F-K.js        loaded when a page or a picture needs them
 *
 * Every page contains its style sheet and its script, named by their hashes in a policy that lets it load nothing (but
 * the blocks).  All texts of the catalogue are escaped.  The pages of families without blocks can be read without scripts. */
#ifndef LW_CATALOGUES_PAGES_ATLAS_HTML_H
#define LW_CATALOGUES_PAGES_ATLAS_HTML_H

#include "catalogues/store/store.h"

typedef struct lw_atlas_html_options {
    const char *title;             /* of the overview                                  ("Atlas of mechanisms") */
    int         links;             /* only chains with this number of links; 0: all (0) */
    int         limit;             /* greatest number of chains; 0: all (0) */
    int         jobs;              /* threads; 0: one per core (0) */
    int         single_pages;      /* families of more chains are written in blocks (1000) */
    int         n_linkage;         /* moving linkages shown for a chain, the best first                   (12) */
    bool      (*goes_on)(void *context, double done, double total);   /* after each chain; NULL         (NULL) */
    void       *context;
} lw_atlas_html_options;

lw_atlas_html_options lw_atlas_html_options_default(void);

/* Number of chains, and the expected bytes of their pages (to about a quarter, without moving linkages). */
lw_status lw_atlas_html_expect(lw_store *s, const lw_atlas_html_options *o, size_t *n_chain, double *n_byte, lw_error *e);

/* Write the pages into folder `dir`, which is made if needed; the overview comes last. *n_page: number of pages
 * written; *n_byte: their size. LW_NOTHING: there is no chain; LW_STOPPED: goes_on returned false; LW_E_IO;
 * LW_E_MEMORY. */
lw_status lw_atlas_html_write(lw_store *s, const char *dir, const lw_atlas_html_options *o, size_t *n_page, size_t *n_byte, lw_error *e);

#endif
