/* catalogues/exchange/format.h - all formats of linkages in one table: to add one, write its reader or writer and
 * its row. */
#ifndef LW_CATALOGUES_EXCHANGE_FORMAT_H
#define LW_CATALOGUES_EXCHANGE_FORMAT_H

#include "base/bytes.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/export_space.h"

typedef struct lw_format {
    const char *name;
    const char *end;                   /* of a file's name, ".json"; "": none                            */
    bool      (*begins)(const char *text);                       /* does a terminated text look like it?    */
    /* Numbers without a unit of their own count in `units`.  Free the linkage by lw_assembly_free.  NULL: written only. */
    lw_status (*read)(const char *text, size_t size, const char *file, const lw_units *units, lw_assembly *linkage, lw_error *e);
    /* Adds to out, freed after a failure.  LW_E_KIND: the format cannot say this.  NULL: read only. */
    lw_status (*write)(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);
    bool        loads;                 /* _write uses the model of the options                           */
    lw_status (*write_space)(const lw_spatial *m, lw_bytes *out, lw_error *e);     /* NULL: planar only    */
} lw_format;

/* Ends with a row without name.  Ask in this order whether a text is theirs: the last that can be read takes any. */
extern const lw_format lw_formats[];

/* f->write, after refusing with LW_E_KIND what no format but json can say: free links; and, where the format takes loads,
 * contacts, ropes, elastic links and states of the model.  Whoever writes a format calls this. */
lw_status lw_format_write(const lw_format *f, const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);

/* The same of a spatial model; LW_E_KIND also: the format holds planar linkages only. */
lw_status lw_format_write_space(const lw_format *f, const lw_spatial *m, lw_bytes *out, lw_error *e);

/* Read text of the format with this name, angles without unit in degrees; NULL: of the first that it looks like.  Free *parts by
 * lw_assembly_free, after a failure too.  LW_E_ARG: there is no such format. */
lw_status lw_format_parse(const char *text, size_t size, const char *file, const char *format, lw_assembly *parts, lw_error *e);

/* NULL: there is none of that name. */
const lw_format *lw_format_find(const char *name);

#endif
