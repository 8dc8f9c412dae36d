/* surface/surface.h - what the files behind linkwright.h share. */
#ifndef LW_SURFACE_SURFACE_H
#define LW_SURFACE_SURFACE_H

#include "base/bytes.h"
#include "catalogues/draw/scene.h"
#include "optimise/task/target.h"

/* Size bytes at `from` as an allocated copy; *out NULL: out of memory. */
#define LW_SURFACE_COPY(from, out) lw_surface_copy((from), sizeof *(from), (void **)(out))
lw_status lw_surface_copy(const void *from, size_t size, void **out);

/* Hand the bytes over to a caller, who frees them; b is empty afterwards. */
lw_status lw_surface_give(lw_bytes *b, char **out, size_t *size, lw_error *e);

/* Place of a word in a list that ends with NULL; -1, with a text that names `what` and the list: it is not there. */
int lw_surface_word(const char *what, const char *word, const char *const *list, lw_error *e);

/* A whole file through a reader: read(text, size, path, context, e). */
typedef lw_status lw_surface_reader(const char *text, size_t size, const char *file, void *context, lw_error *e);
lw_status lw_surface_load(const char *path, lw_surface_reader *read, void *context, lw_error *e);

/* Options of a simulation as the library has them (NULL: the defaults), and its report. */
struct lw_dynamics_options;
struct lw_dynamics_report;
lw_status lw_surface_options(const lw_simulation_options *options, struct lw_dynamics_options *out, lw_error *error);
void      lw_surface_report(const struct lw_dynamics_report *r, lw_simulation_report *out);

/* The notes about a run of d, to the sink of its options (all 0: none). */
struct lw_dynamics;
void      lw_surface_notes(lw_note_sink to, const struct lw_dynamics *d, const struct lw_dynamics_report *r);

/* Samples of a spatial model: the arrays hold until the next one. */
typedef struct lw_surface_spatial {
    struct lw_dynamics *d;
    lw_frame_motion    *link, *tracer;
    lw_spatial_sample   sample;
} lw_surface_spatial;

struct lw_moment;
lw_status lw_surface_spatial_make(struct lw_dynamics *d, lw_surface_spatial *s, lw_error *error);       /* all 0: free does nothing */
void      lw_surface_spatial_free(lw_surface_spatial *s);
lw_status lw_surface_spatial_take(lw_surface_spatial *s, const struct lw_moment *m, lw_error *error);

/* A new object of `room` bytes, all 0, filled by a reader from a text or a file: its context is the object.  *out NULL
 * with every status but LW_OK. */
lw_status lw_surface_parse_new(const char *text, size_t size, const char *file, lw_surface_reader *read, size_t room,
                               void **out, lw_error *e);
lw_status lw_surface_load_new(const char *path, lw_surface_reader *read, size_t room, void **out, lw_error *e);

/* The functions kind_parse, kind_load and kind_destroy of linkwright.h, by kind_read, which leaves nothing to free after a failure,
 * and kind_free of the library. */
#define LW_SURFACE_FILE(kind)                                                                                             \
    static lw_status kind##_reader(const char *text, size_t size, const char *file, void *out, lw_error *e)              \
    {                                                                                                                     \
        return kind##_read(text, size, file, out, e);                                                                     \
    }                                                                                                                     \
    lw_status kind##_parse(const char *text, size_t size, const char *file, kind **out, lw_error *error)                  \
    {                                                                                                                     \
        return lw_surface_parse_new(text, size, file, kind##_reader, sizeof **out, (void **)out, error);                  \
    }                                                                                                                     \
    lw_status kind##_load(const char *path, kind **out, lw_error *error)                                                  \
    {                                                                                                                     \
        return lw_surface_load_new(path, kind##_reader, sizeof **out, (void **)out, error);                               \
    }                                                                                                                     \
    void kind##_destroy(kind *object)                                                                                     \
    {                                                                                                                     \
        if (object)                                                                                                       \
            kind##_free(object);                                                                                          \
        free(object);                                                                                                     \
    }

#endif
