/* Animations, read back with giflib: frames, loop, palette, and what a viewer would see. */
#include <gif_lib.h>

#include "catalogues/draw/diagram.h"
#include "catalogues/draw/gif.h"
#include "catalogues/draw/picture.h"
#include "tests/check.h"
#include "tests/scene_models.h"

typedef struct source { const char *data; size_t left; } source;

static int take(GifFileType *gif, GifByteType *data, int n)
{
    source *s = gif->UserData;
    size_t m = (size_t)n < s->left ? (size_t)n : s->left;
    memcpy(data, s->data, m);
    s->data += m;
    s->left -= m;
    return (int)m;
}

static GifFileType *read_back(const lw_bytes *b)
{
    int code = 0;
    source s = { b->data, b->size };
    GifFileType *gif = DGifOpen(&s, take, &code);
    CHECK(gif != NULL);
    if (gif)
        CHECK_INT(DGifSlurp(gif), GIF_OK);
    return gif;
}

static int delay_of(GifFileType *gif, int i)
{
    GraphicsControlBlock g = { 0 };
    CHECK_INT(DGifSavedExtensionToGCB(gif, i, &g), GIF_OK);
    return g.DelayTime;
}

TEST(frames_loop_and_size)
{
    OWN(lw_scene) s = { 0 };
    OWN(lw_bytes) b = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 10, &s), LW_OK);
    lw_gif_options o = { .width = 320, .height = 240, .n_frame = 40, .delay = 7 };
    CHECK_OK(lw_gif_write(&s, &o, &b, &check_error));
    GifFileType *gif = read_back(&b);
    CHECK_INT(gif->SWidth, 320);
    CHECK_INT(gif->SHeight, 240);
    CHECK_INT(gif->ImageCount, 40);
    CHECK(gif->SColorMap && gif->SColorMap->ColorCount == 256);
    for (int i = 0; i < gif->ImageCount; i++) {
        CHECK(gif->SavedImages[i].ImageDesc.ColorMap == NULL);            /* one palette for all */
        CHECK_INT(delay_of(gif, i), 7);
    }
    const SavedImage *first = &gif->SavedImages[0];
    CHECK_INT(first->ImageDesc.Width, 320);
    bool loops = false;
    for (int i = 0; i + 1 < first->ExtensionBlockCount; i++) {
        const ExtensionBlock *x = &first->ExtensionBlocks[i];
        if (x->Function == APPLICATION_EXT_FUNC_CODE && x->ByteCount == 11
            && memcmp(x->Bytes, "NETSCAPE2.0", 11) == 0) {
            CHECK_INT(x[1].ByteCount, 3);
            CHECK(x[1].Bytes[0] == 1 && x[1].Bytes[1] == 0 && x[1].Bytes[2] == 0);      /* for ever */
            loops = true;
        }
    }
    CHECK(loops);
    DGifCloseFile(gif, NULL);
}

/* Put a frame over what was there, as a viewer does. */
static void compose(GifFileType *gif, int i, uint32_t *screen)
{
    const SavedImage *p = &gif->SavedImages[i];
    const GifImageDesc *d = &p->ImageDesc;
    GraphicsControlBlock g = { .TransparentColor = NO_TRANSPARENT_COLOR };
    DGifSavedExtensionToGCB(gif, i, &g);
    for (int y = 0; y < d->Height; y++)
        for (int x = 0; x < d->Width; x++) {
            int c = p->RasterBits[y*d->Width + x];
            const GifColorType *rgb = &gif->SColorMap->Colors[c];
            if (c != g.TransparentColor)
                screen[(d->Top + y)*gif->SWidth + d->Left + x]
                    = (uint32_t)rgb->Red << 16 | (uint32_t)rgb->Green << 8 | rgb->Blue;
        }
}

static int channel_distance(uint32_t a, uint32_t b)
{
    int most = 0;
    for (int shift = 0; shift < 24; shift += 8) {
        int d = abs((int)(a >> shift & 255) - (int)(b >> shift & 255));
        most = d > most ? d : most;
    }
    return most;
}

/* What a viewer shows in each frame is what cairo drew, but for the rounding of colours: all but a few
 * pixels within 40 of 255, in the mean within 1. */
TEST(viewer_sees_what_was_drawn)
{
    OWN(lw_scene) s = { 0 };
    OWN(lw_bytes) b = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 10, &s), LW_OK);
    lw_gif_options o = { .width = 320, .height = 240, .n_frame = 12, .delay = 5 };
    CHECK_OK(lw_gif_write(&s, &o, &b, &check_error));
    GifFileType *gif = read_back(&b);
    lw_diagram_options drawn = lw_diagram_options_default();
    drawn.width = 320;
    drawn.height = 240;
    drawn.whole_motion = true;
    drawn.length_labels = false;
    OWN(lw_drawing) d = { 0 };
    CHECK_OK(lw_diagram_draw(&s, &drawn, &d, &check_error));
    uint32_t *screen = calloc(320*240, sizeof *screen), *want = calloc(320*240, sizeof *want);
    for (int i = 0; i < gif->ImageCount; i++) {
        compose(gif, i, screen);
        CHECK_OK(lw_picture_pixels(&d, &s, (size_t)i*s.n_frame/12, want, &check_error));
        long far = 0, sum = 0;
        for (int p = 0; p < 320*240; p++) {
            int distance = channel_distance(screen[p], want[p]);
            far += distance > 40;
            sum += distance;
        }
        CHECK(far < 320*240/200);
        CHECK(sum < 320*240);
    }
    free(screen);
    free(want);
    DGifCloseFile(gif, NULL);
}

TEST(there_and_back_when_it_cannot_go_round)
{
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    k.input[0].first = k.input[0].value;
    k.input[0].last = k.input[0].value + 1;
    OWN(lw_scene) s = { 0 };
    OWN(lw_bytes) b = { 0 };
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    lw_gif_options o = { .width = 200, .height = 150, .n_frame = 20, .delay = 5 };
    CHECK_OK(lw_gif_write(&s, &o, &b, &check_error));
    GifFileType *gif = read_back(&b);
    CHECK_INT(gif->ImageCount, 20);                                 /* 11 there, 9 between back */
    uint32_t *screen = calloc(200*150, sizeof *screen), *seen[20];
    for (int i = 0; i < 20; i++) {
        compose(gif, i, screen);
        seen[i] = malloc(200*150*sizeof *screen);
        memcpy(seen[i], screen, 200*150*sizeof *screen);
    }
    for (int i = 1; i < 10; i++)
        CHECK(memcmp(seen[i], seen[20 - i], 200*150*sizeof *screen) == 0);
    CHECK(memcmp(seen[0], seen[10], 200*150*sizeof *screen) != 0);
    for (int i = 0; i < 20; i++)
        free(seen[i]);
    free(screen);
    DGifCloseFile(gif, NULL);
}

TEST(a_still_scene_is_one_frame)
{
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    k.n_input = 0;
    OWN(lw_scene) s = { 0 };
    OWN(lw_bytes) b = { 0 };
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    CHECK_OK(lw_gif_write(&s, NULL, &b, &check_error));
    GifFileType *gif = read_back(&b);
    CHECK_INT(gif->ImageCount, 1);
    DGifCloseFile(gif, NULL);
}

/* Delays add up to the time of the motion, of a short one to half a second. */
TEST(true_time)
{
    static const struct { size_t n; double seconds, shown; } rows[] = {
        { 1001, 2, 2 }, { 101, 10, 10 }, { 201, 60, 60 }, { 5, 1, 1 }, { 51, 0.1, 0.5 }, { 3, 0.1, 0.12 } };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        double slower;
        lw_gif_options o = lw_gif_options_in_time(rows[i].n, rows[i].seconds, &slower);
        CHECK(o.n_frame <= rows[i].n && o.delay >= 2);
        CHECK_NEAR(0.01*(double)o.n_frame*o.delay, rows[i].shown, 0, 0.03);
        CHECK_NEAR(slower, rows[i].shown/rows[i].seconds, 0, 0.03);
    }
}

/* A bar that bends is drawn through its points. */
TEST(bars_bend)
{
    OWN(lw_scene) s = { 0 };
    OWN(lw_bytes) straight = { 0 }, bent = { 0 };
    lw_gif_options o = { .width = 160, .height = 120, .n_frame = 2, .delay = 5 };
    FREED lw_vec2 *p = NULL;
    CHECK_INT(model_scene("Crank-rocker", 10, &s), LW_OK);
    p = calloc(3*s.n_frame, sizeof *p);
    const lw_joint *j = s.linkage.joint;
    int link = j[0].link[0] == s.linkage.ground ? j[0].link[1] : j[0].link[0];
    lw_bent_bar bar = { link, 3, p };
    for (size_t f = 0; f < s.n_frame; f++)
        for (size_t i = 0; i < 3; i++)
            p[3*f + i] = lw_v2_add(j[0].at, lw_v2(i == 1 ? 0.01 : 0, 0));
    CHECK_OK(lw_gif_write(&s, &o, &straight, &check_error));
    s.bend = &bar;
    s.n_bend = 1;
    CHECK_OK(lw_gif_write(&s, &o, &bent, &check_error));
    CHECK(straight.size != bent.size || memcmp(straight.data, bent.data, bent.size) != 0);

    /* two bars of one link, in either order, are not joined to each other */
    OWN(lw_bytes) two = { 0 }, swapped = { 0 }, joined = { 0 };
    FREED lw_vec2 *q = calloc(2*s.n_frame, sizeof *q), *r = calloc(2*s.n_frame, sizeof *r), *all = calloc(4*s.n_frame, sizeof *all);
    lw_bent_bar pair[] = { { link, 2, q }, { link, 2, r } }, back[] = { pair[1], pair[0] }, one = { link, 4, all };
    for (size_t f = 0; f < s.n_frame; f++)
        for (size_t i = 0; i < 4; i++)
            all[4*f + i] = *(i < 2 ? &q[2*f + i] : &r[2*f + i - 2]) = lw_v2_add(j[0].at, lw_v2(i%2 ? 0.5 : 0, i < 2 ? 0 : 1));
    s.n_bend = 2, s.bend = pair;
    CHECK_OK(lw_gif_write(&s, &o, &two, &check_error));
    s.bend = back;
    CHECK_OK(lw_gif_write(&s, &o, &swapped, &check_error));
    s.n_bend = 1, s.bend = &one;
    CHECK_OK(lw_gif_write(&s, &o, &joined, &check_error));
    CHECK(two.size == swapped.size && memcmp(two.data, swapped.data, two.size) == 0);
    CHECK(two.size != joined.size || memcmp(two.data, joined.data, two.size) != 0);
    s.n_bend = 0, s.bend = NULL;             /* not of the heap */
}

TEST(a_stopped_animation_is_readable)
{
    OWN(lw_scene) s = { 0 };
    OWN(lw_bytes) b = { 0 };
    lw_gif_options o = { .width = 160, .height = 120, .n_frame = 8, .delay = 5 };
    const volatile sig_atomic_t now = 1;
    CHECK_INT(model_scene("Crank-rocker", 10, &s), LW_OK);
    s.stop = &now;
    CHECK_OK(lw_gif_write(&s, &o, &b, &check_error));
    GifFileType *gif = read_back(&b);
    CHECK_INT(gif->ImageCount, 1);
    int code;
    DGifCloseFile(gif, &code);
}

TEST(same_input_same_bytes)
{
    OWN(lw_scene) s = { 0 };
    lw_bytes a, b;
    lw_gif_options o = { .width = 160, .height = 120, .n_frame = 8, .delay = 5 };
    CHECK_INT(model_scene("Crank-rocker", 10, &s), LW_OK);
    CHECK_OK(lw_gif_write(&s, &o, &a, &check_error));
    CHECK_OK(lw_gif_write(&s, &o, &b, &check_error));
    CHECK(a.size == b.size && memcmp(a.data, b.data, a.size) == 0);
    lw_bytes_free(&a);
    lw_bytes_free(&b);
    o.width = 20;
    CHECK_INT(lw_gif_write(&s, &o, &b, &check_error), LW_E_ARG);
    CHECK(b.data == NULL);
}
