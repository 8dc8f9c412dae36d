/* catalogues/draw/gif.h - the bridge to giflib: the motion of a scene as an animation that loops for ever,
 * with one palette for all frames. */
#ifndef LW_CATALOGUES_DRAW_GIF_H
#define LW_CATALOGUES_DRAW_GIF_H

#include <stdint.h>
#include "base/bytes.h"
#include "catalogues/draw/scene.h"

typedef struct lw_gif_options {
    int    width, height;      /* [px]                                                (640, 480)  */
    size_t n_frame;            /* at most; taken evenly from the scene's frames              (60)  */
    int    delay;              /* of each frame, in 1/100 s                                   (5)  */
} lw_gif_options;

lw_gif_options lw_gif_options_default(void);

/* Frames and delay that show a motion of n_frame frames in `seconds` in true time, at most 50 in a second; of a motion of less
 * than half a second slower: *slower (may be NULL) is the factor. */
lw_gif_options lw_gif_options_in_time(size_t n_frame, double seconds, double *slower);

/* The frames of a motion; render fills pixels 0x00RRGGBB of the size of the animation. */
typedef struct lw_gif_motion {
    size_t n_frame, first_frame;   /* the frame that comes first, if the motion loops */
    bool   loops;
    const volatile sig_atomic_t *stop;     /* the frame that is drawn is the last; may be NULL */
    lw_status (*render)(void *context, size_t frame, uint32_t *pixel, lw_error *e);
    void  *context;
} lw_gif_motion;

/* A motion that does not loop is shown there and back.  LW_E_ARG for sizes outside 64 .. 2048. */
lw_status lw_gif_encode(const lw_gif_motion *motion, const lw_gif_options *o, lw_bytes *out, lw_error *e);

/* The same of a scene; o NULL: the defaults. */
lw_status lw_gif_write(const lw_scene *s, const lw_gif_options *o, lw_bytes *out, lw_error *e);

#endif
