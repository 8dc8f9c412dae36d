/* catalogues/draw/gif.h - the bridge to giflib: the motion of a scene as an animation that loops for ever,
 * with one palette for all frames. */
#ifndef LW_CATALOGUES_DRAW_GIF_H
#define LW_CATALOGUES_DRAW_GIF_H

#include "base/bytes.h"
#include "catalogues/draw/scene.h"

typedef struct lw_gif_options {
    int    width, height;      /* [px]                                                (640, 480)  */
    size_t n_frame;            /* at most; taken evenly from the scene's frames              (60)  */
    int    delay;              /* of each frame, in 1/100 s                                   (5)  */
} lw_gif_options;

lw_gif_options lw_gif_options_default(void);

/* A motion that does not loop is shown there and back.  LW_E_ARG for sizes outside 64 .. 2048. */
lw_status lw_gif_write(const lw_scene *s, const lw_gif_options *o, lw_bytes *out, lw_error *e);

#endif
