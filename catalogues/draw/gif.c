/* catalogues/draw/gif.c - see gif.h */
#include "catalogues/draw/gif.h"
#include "base/real.h"

#include <gif_lib.h>
#include <stdlib.h>
#include <string.h>

#include "catalogues/draw/diagram.h"
#include "catalogues/draw/picture.h"

#define COLOURS   256
#define CLEAR     255            /* index that means "as in the frame before"                       */
#define SHADES    18             /* of each ink, from the ink to the paper                          */
#define CUBE      (32*32*32)     /* five bits per channel: the index of every colour is kept         */

/* One palette for all frames: the colours that antialiasing makes of each ink on paper. */
typedef struct lw_palette {
    int           n;
    GifColorType  colour[COLOURS];
    unsigned char index[CUBE];   /* 0: not computed yet, else 1 + nearest entry                     */
} lw_palette;

typedef struct lw_film {
    const lw_gif_motion *motion;
    int         width, height;
    uint32_t   *pixel;           /* of one frame                          (width * height)          */
    GifByteType *now, *before;   /* palette indices of this frame, and of what the viewer shows     */
    GifByteType *row;            /* one line to write (width)                                       */
    lw_palette  palette;
} lw_film;

lw_gif_options lw_gif_options_default(void)
{
    return (lw_gif_options){ .width = 640, .height = 480, .n_frame = 60, .delay = 5 };
}

lw_gif_options lw_gif_options_in_time(size_t n_frame, double seconds, double *slower)
{
    enum { MOST = 250, LEAST = 25 };                       /* frames */
    lw_gif_options o = lw_gif_options_default();
    double ticks = 100*seconds, n = fmax((double)n_frame, 1);       /* of 1/100 s */
    o.delay = (int)fmin(fmax(2, ceil(ticks/fmin(n, MOST))), 65535);
    double frames = fmin(fmax(round(ticks/o.delay), LEAST), n);
    o.n_frame = (size_t)frames;
    if (slower)
        *slower = seconds > 0 ? o.delay*frames/ticks : 1;
    return o;
}

static int mix(unsigned ink, int shift, int shade)
{
    int c = (int)(ink >> shift & 255), paper = (int)(lw_ink_light(LW_INK_PAPER) >> shift & 255);
    return c + (paper - c)*shade/SHADES;
}

static void make_palette(lw_palette *p)
{
    memset(p, 0, sizeof *p);
    unsigned paper = lw_ink_light(LW_INK_PAPER);
    p->colour[p->n++] = (GifColorType){ paper >> 16 & 255, paper >> 8 & 255, paper & 255 };
    for (int i = LW_INK_TEXT; i < LW_INK_COUNT; i++)
        for (int shade = 0; shade < SHADES && p->n < CLEAR; shade++) {
            unsigned ink = lw_ink_light((lw_ink)i);
            p->colour[p->n++] = (GifColorType){ (GifByteType)mix(ink, 16, shade),
                                                (GifByteType)mix(ink, 8, shade),
                                                (GifByteType)mix(ink, 0, shade) };
        }
}

static int nearest(const lw_palette *p, int r, int g, int b)
{
    int best = 0, least = 1 << 30;
    for (int i = 0; i < p->n; i++) {
        int dr = p->colour[i].Red - r, dg = p->colour[i].Green - g, db = p->colour[i].Blue - b;
        int d = 3*dr*dr + 4*dg*dg + 2*db*db;                   /* rough weights of the eye's sensitivity */
        if (d < least) {
            least = d;
            best = i;
        }
    }
    return best;
}

static GifByteType palette_index(lw_palette *p, uint32_t rgb)
{
    unsigned r = rgb >> 19 & 31, g = rgb >> 11 & 31, b = rgb >> 3 & 31;
    unsigned char *slot = &p->index[r << 10 | g << 5 | b];
    if (*slot == 0)
        *slot = (unsigned char)(1 + nearest(p, (int)(r*255/31), (int)(g*255/31), (int)(b*255/31)));
    return (GifByteType)(*slot - 1);
}

static int append(GifFileType *gif, const GifByteType *data, int size)
{
    lw_bytes *out = gif->UserData;
    lw_bytes_add(out, data, (size_t)size);
    return out->failed ? 0 : size;
}

/* Find the box in which the picture differs from what the viewer shows. False: no difference. */
static bool changed_part(const lw_film *m, int box[4])
{
    box[0] = m->width;
    box[1] = m->height;
    box[2] = box[3] = -1;
    for (int y = 0; y < m->height; y++)
        for (int x = 0; x < m->width; x++) {
            size_t i = (size_t)y*(size_t)m->width + (size_t)x;
            if (m->now[i] == m->before[i])
                continue;
            box[0] = x < box[0] ? x : box[0];
            box[1] = y < box[1] ? y : box[1];
            box[2] = x > box[2] ? x : box[2];
            box[3] = y;
        }
    return box[3] >= 0;
}

/* Write the changed box. Pixels that stay the same get the index CLEAR, which compresses better. */
static bool put_frame(lw_film *m, GifFileType *gif, int delay, bool first)
{
    int box[4] = { 0, 0, m->width - 1, m->height - 1 };
    if (!first && !changed_part(m, box))
        box[0] = box[1] = box[2] = box[3] = 0;            /* a frame of one pixel keeps the timing */
    GraphicsControlBlock control = { .DisposalMode = DISPOSE_DO_NOT, .DelayTime = delay,
                                     .TransparentColor = first ? NO_TRANSPARENT_COLOR : CLEAR };
    GifByteType code[4];
    int width = box[2] - box[0] + 1, height = box[3] - box[1] + 1;
    bool ok = EGifGCBToExtension(&control, code) == sizeof code
           && EGifPutExtension(gif, GRAPHICS_EXT_FUNC_CODE, sizeof code, code) == GIF_OK
           && EGifPutImageDesc(gif, box[0], box[1], width, height, false, NULL) == GIF_OK;
    for (int y = box[1]; ok && y <= box[3]; y++) {
        for (int x = 0; x < width; x++) {
            size_t i = (size_t)y*(size_t)m->width + (size_t)(box[0] + x);
            m->row[x] = !first && m->now[i] == m->before[i] ? CLEAR : m->now[i];
        }
        ok = EGifPutLine(gif, m->row, width) == GIF_OK;
    }
    memcpy(m->before, m->now, (size_t)m->width*(size_t)m->height);
    return ok;
}

static lw_status render(lw_film *m, size_t frame, lw_error *e)
{
    lw_status st = m->motion->render(m->motion->context, frame, m->pixel, e);
    for (size_t i = 0; st == LW_OK && i < (size_t)m->width*(size_t)m->height; i++)
        m->now[i] = palette_index(&m->palette, m->pixel[i]);
    return st;
}

/* Write screen, palette, and the Netscape extension that makes the animation repeat for ever. */
static bool put_head(const lw_film *m, GifFileType *gif)
{
    ColorMapObject *map = GifMakeMapObject(COLOURS, m->palette.colour);
    if (!map)
        return false;
    EGifSetGifVersion(gif, true);
    bool ok = EGifPutScreenDesc(gif, m->width, m->height, 8, 0, map) == GIF_OK;
    GifFreeMapObject(map);
    const GifByteType for_ever[3] = { 1, 0, 0 };
    return ok && EGifPutExtensionLeader(gif, APPLICATION_EXT_FUNC_CODE) == GIF_OK
        && EGifPutExtensionBlock(gif, 11, "NETSCAPE2.0") == GIF_OK
        && EGifPutExtensionBlock(gif, sizeof for_ever, for_ever) == GIF_OK
        && EGifPutExtensionTrailer(gif) == GIF_OK;
}

/* Write all frames. A motion that does not loop then runs back over the same frames; its two ends are not repeated. */
static lw_status put_motion(lw_film *m, GifFileType *gif, const lw_gif_options *o, lw_error *e)
{
    const lw_gif_motion *g = m->motion;
    size_t most = g->loops ? o->n_frame : o->n_frame/2 + 1, all = g->n_frame;
    size_t n = all < most ? all : most < 2 ? 2 : most;
    size_t total = g->loops || n < 2 ? n : 2*n - 2;
    for (size_t i = 0; i < total && !(i > 0 && g->stop && *g->stop); i++) {
        size_t step = i < n ? i : total - i;
        size_t frame = g->loops || n < 2 ? (g->first_frame + step*all/n) % all : step*(all - 1)/(n - 1);
        lw_status st = render(m, frame, e);
        if (st != LW_OK)
            return st;
        if (!put_frame(m, gif, o->delay, i == 0))
            return lw_error_set(e, LW_E_MEMORY, "the animation could not be packed: %s",
                                GifErrorString(gif->Error) ? GifErrorString(gif->Error) : "?");
    }
    return LW_OK;
}

static lw_status encode(lw_film *m, const lw_gif_options *o, lw_bytes *out, lw_error *e)
{
    int code = 0;
    GifFileType *gif = EGifOpen(out, append, &code);
    if (!gif)
        return lw_error_set(e, LW_E_MEMORY, "not enough memory for an animation");
    make_palette(&m->palette);
    lw_status st = put_head(m, gif) ? put_motion(m, gif, o, e)
                 : lw_error_set(e, LW_E_MEMORY, "the animation could not be begun");
    if (EGifCloseFile(gif, &code) != GIF_OK && st == LW_OK)
        st = lw_error_set(e, LW_E_MEMORY, "the animation could not be ended");
    return st;
}

lw_status lw_gif_encode(const lw_gif_motion *motion, const lw_gif_options *o, lw_bytes *out, lw_error *e)
{
    *out = (lw_bytes){ 0 };
    if (o->width < 64 || o->width > 2048 || o->height < 64 || o->height > 2048)
        return lw_error_set(e, LW_E_ARG, "an animation of %d by %d px: sizes are 64 to 2048", o->width, o->height);
    lw_film *m = calloc(1, sizeof *m);
    if (!m)
        return lw_error_set(e, LW_E_MEMORY, "not enough memory for an animation");
    size_t area = (size_t)o->width*(size_t)o->height;
    m->motion = motion;
    m->width = o->width;
    m->height = o->height;
    m->pixel = malloc(area*sizeof *m->pixel);
    m->now = calloc(2*area + (size_t)o->width, 1);
    lw_status st = LW_OK;
    if (!m->pixel || !m->now) {
        st = lw_error_set(e, LW_E_MEMORY, "not enough memory for an animation");
    } else {
        m->before = m->now + area;
        m->row = m->before + area;
        st = encode(m, o, out, e);
    }
    free(m->pixel);
    free(m->now);
    free(m);
    if (st == LW_OK)
        return lw_bytes_end(out, e);
    lw_bytes_free(out);
    return st;
}

typedef struct planar_film { const lw_scene *s; lw_drawing drawing; } planar_film;

static lw_status render_scene(void *context, size_t frame, uint32_t *pixel, lw_error *e)
{
    planar_film *f = context;
    return lw_picture_pixels(&f->drawing, f->s, frame, pixel, e);
}

lw_status lw_gif_write(const lw_scene *s, const lw_gif_options *o, lw_bytes *out, lw_error *e)
{
    lw_gif_options standard = lw_gif_options_default();
    o = o ? o : &standard;
    planar_film f = { .s = s };
    lw_gif_motion motion = { .n_frame = s->n_frame, .first_frame = s->first_frame, .loops = s->loops, .stop = s->stop,
                             .render = render_scene, .context = &f };
    lw_diagram_options d = lw_diagram_options_default();
    d.width = o->width;
    d.height = o->height;
    d.whole_motion = true;
    d.length_labels = false;
    *out = (lw_bytes){ 0 };
    lw_status st = lw_diagram_draw(s, &d, &f.drawing, e);
    if (st == LW_OK)
        st = lw_gif_encode(&motion, o, out, e);
    lw_drawing_free(&f.drawing);
    return st;
}
