/* Draw sheets of chains and mechanisms; pages are written while the rest of the input is still being read. */
#include "cli/draw/draw.h"

#include <stdlib.h>
#include <string.h>

#include "catalogues/draw/picture.h"
#include "catalogues/draw/sheet.h"
#include "cli/program/topology.h"
#include "grammar/topology/edges.h"

#define CAPTION_SIZE 320
#define EACH_WIDTH   320
#define EACH_HEIGHT  240

typedef struct press {
    const cli_call *call;
    const cli_draw_settings *s;
    lw_draw_kind    kind;
    lw_sheet_style  style;
    int             capacity;                 /* pictures on a page                                        */
    int             n;                    /* pictures on the current page                              */
    lw_mechanism   *m;                    /* (capacity)                                                */
    char          (*caption)[CAPTION_SIZE];
    lw_sheet_item  *item;
    uint64_t        n_read;
    size_t          n_page, page_capacity;    /* pages finished                                            */
    lw_drawing     *page;                 /* PDF: all pages; else the first one, until a second follows */
    cli_watch       watch;
} press;

/* ---- captions ----------------------------------------------------------------------------------- */

/* Print "5 binary, 4 ternary", or "5, 4, 0, 1" from binary links on, as in tables of assortments. */
static void print_assortment(const lw_mechanism *m, char *out, size_t size)
{
    lw_chain c;
    int n_with[LW_LINK_MAX], last = 2;
    size_t used = 0;
    lw_mechanism_chain(m, &c);
    lw_chain_assortment(&c, n_with);
    for (int d = 2; d < LW_LINK_MAX; d++)
        last = n_with[d] ? d : last;
    out[0] = 0;
    for (int d = 2; d <= last && used + 8 < size; d++)
        used += (size_t)snprintf(out + used, size - used, "%s%d", d > 2 ? ", " : "", n_with[d]);
}

static void print_caption(const press *p, const lw_mechanism *m, char out[CAPTION_SIZE])
{
    char text[LW_NOTATION_SIZE];
    size_t length;
    switch (p->s->caption) {
    case CLI_CAPTION_GRAPH6:
        if (lw_notation_find("graph6")->print(m, text, sizeof text, &length) != LW_OK)
            text[0] = 0;
        break;
    case CLI_CAPTION_JOINTS:
        lw_edges_print(m, text, sizeof text);
        break;
    case CLI_CAPTION_ASSORTMENT:
        print_assortment(m, text, sizeof text);
        break;
    default:
        snprintf(text, sizeof text, "%llu", (unsigned long long)p->n_read);
        break;
    }
    lw_text_clean(out, CAPTION_SIZE, text);
}

/* ---- pages -------------------------------------------------------------------------------------- */

/* Path of a page: "sheet.svg" gives "sheet-002.svg". */
static void page_path(const press *p, size_t number, char *out, size_t size)
{
    const char *path = p->call->common.output, *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    int stem = dot ? (int)(dot - path) : (int)strlen(path);
    snprintf(out, size, "%.*s-%03zu%s", stem, path, number, dot ? dot : "");
}

static lw_status write_page(press *p, const lw_drawing *d, size_t number, lw_error *e)
{
    char path[CLI_PATH_SIZE];
    lw_bytes b;
    page_path(p, number, path, sizeof path);
    if (cli_may_write(p->call, path) != CLI_DONE)
        return lw_error_at(e, LW_E_ARG, path, 0, 0, "this page is not written");
    lw_status s = lw_draw_still(d, p->kind, &b, e);
    if (s == LW_OK)
        s = lw_file_write(path, b.data, b.size, e);
    lw_bytes_free(&b);
    return s;
}

static lw_status keep_page(press *p, const lw_drawing *d, lw_error *e)
{
    if (p->n_page == p->page_capacity) {
        size_t capacity = 2*p->page_capacity + 4;
        lw_drawing *more = realloc(p->page, capacity*sizeof *more);
        if (!more)
            return lw_error_set(e, LW_E_MEMORY, "out of memory for %zu pages", capacity);
        p->page = more;
        p->page_capacity = capacity;
    }
    p->page[p->n_page++] = *d;
    return LW_OK;
}

/* The first page is kept back: it gets a number only if there is a second one. */
static lw_status add_page(press *p, lw_drawing *d, lw_error *e)
{
    lw_status s = LW_OK;
    if (p->kind == LW_DRAW_PDF || p->n_page == 0) {
        s = keep_page(p, d, e);
        if (s != LW_OK)
            lw_drawing_free(d);
        return s;
    }
    if (!p->call->common.output || strcmp(p->call->common.output, "-") == 0)
        s = lw_error_set(e, LW_E_ARG, "more than one page: name a file with -o, from which every page gets a numbered "
                         "one, or take --format pdf, or more on a page with --grid");
    if (s == LW_OK && p->n_page == 1) {
        s = write_page(p, &p->page[0], 1, e);
        lw_drawing_free(&p->page[0]);
    }
    if (s == LW_OK)
        s = write_page(p, d, ++p->n_page, e);
    lw_drawing_free(d);
    return s;
}

static lw_status print_page(press *p, lw_error *e)
{
    lw_drawing d;
    int number = p->s->each || (p->n_page == 0 && p->n < p->capacity) ? 0 : (int)p->n_page + 1;
    lw_status s = lw_sheet_draw(p->item, p->n, &p->style, number, &d, e);
    p->n = 0;
    return s == LW_OK ? add_page(p, &d, e) : s;
}

/* Add a picture; a full page is printed first. */
static lw_status add_picture(void *context, const lw_mechanism *m, lw_error *e)
{
    press *p = context;
    lw_chain c;
    lw_mechanism_chain(m, &c);
    p->n_read++;
    if (m->n_link < 2 || !lw_chain_is_connected(&c))
        return lw_error_set(e, LW_E_ARG, m->n_link < 2 ? "a single link is no chain to draw"
                                                       : "the links do not hang together: draw each part alone");
    if (p->n == p->capacity) {
        lw_status s = print_page(p, e);
        if (s != LW_OK) {
            e->line = -1;                        /* the line itself has no fault */
            return s;
        }
    }
    p->m[p->n] = *m;
    print_caption(p, m, p->caption[p->n]);
    p->item[p->n] = (lw_sheet_item){ &p->m[p->n], p->s->caption == CLI_CAPTION_NONE ? NULL : p->caption[p->n] };
    p->n++;
    return cli_watch_goes_on(&p->watch, (double)p->n_read) ? LW_OK : LW_STOPPED;
}

/* Write what is left: a single page, or all pages of a PDF. */
static int write_rest(press *p, int code)
{
    lw_bytes b = { 0 };
    lw_output o;
    lw_error e = { 0 };
    if (p->kind != LW_DRAW_PDF && p->n_page > 1) {
        cli_note(p->call, "%zu pages", p->n_page);
        return code;
    }
    lw_status s = p->kind == LW_DRAW_PDF ? lw_picture_pdf_pages(p->page, p->n_page, &b, &e)
                                         : lw_draw_still(&p->page[0], p->kind, &b, &e);
    if (s == LW_OK)
        s = cli_open(p->call, &o, &e);
    if (s == LW_OK)
        fwrite(b.data, 1, b.size, o.f);                       /* cli_close checks the stream for errors */
    lw_bytes_free(&b);
    return s == LW_OK ? cli_close(p->call, &o, code) : cli_fail(p->call, &e);
}

static bool make_press(press *p)
{
    const cli_draw_settings *s = p->s;
    bool sized = s->size[0] > 0;
    p->style = lw_sheet_style_default();
    p->style.columns = s->each ? 1 : s->grid[0];
    p->style.rows = s->each ? 1 : s->grid[1];
    if (sized || s->each) {
        p->style.width = sized ? s->size[0] : EACH_WIDTH;
        p->style.height = sized ? s->size[1] : EACH_HEIGHT;
    }
    p->style.numbers = s->numbers;
    p->style.shrink = !s->each && p->kind != LW_DRAW_PDF;
    p->style.title = s->title;
    p->capacity = p->style.columns*p->style.rows;
    p->m = malloc((size_t)p->capacity*sizeof *p->m);
    p->caption = malloc((size_t)p->capacity*sizeof *p->caption);
    p->item = malloc((size_t)p->capacity*sizeof *p->item);
    return p->m && p->caption && p->item;
}

static void free_press(press *p)
{
    for (size_t i = 0; p->page && i < (p->kind == LW_DRAW_PDF ? p->n_page : p->n_page > 0); i++)
        lw_drawing_free(&p->page[i]);
    free(p->page);
    free(p->m);
    free(p->caption);
    free(p->item);
}

int cli_draw_chains(const cli_call *call, const char *file, lw_draw_kind kind)
{
    press p = { .call = call, .s = call->settings, .kind = kind };
    lw_error e = { 0 };
    if (kind != LW_DRAW_SVG && kind != LW_DRAW_PDF && kind != LW_DRAW_PNG)
        return cli_usage(call, "a chain has no dimensions and does not move: svg, pdf or png");
    int code = CLI_DONE;
    if (p.s->each && call->common.output) {
        char path[CLI_PATH_SIZE];
        page_path(&p, 1, path, sizeof path);
        if ((code = cli_may_write(call, path)) != CLI_DONE)
            return code;
    }
    if (!make_press(&p)) {
        lw_error_set(&e, LW_E_MEMORY, "out of memory for %d pictures on a page", p.capacity);
        code = cli_fail(call, &e);
    } else {
        p.watch = cli_watch_begin(call, "draw", "chains");
        code = cli_topologies_each(call, file, p.s->keep_going, add_picture, &p);
        code = cli_watch_end(&p.watch, code);
        bool go_on = code == CLI_DONE || code == CLI_LIMIT || p.s->keep_going;
        if (go_on && p.n > 0 && print_page(&p, &e) != LW_OK)
            code = cli_fail(call, &e);
        else if (go_on && p.n_page > 0)
            code = write_rest(&p, code);
        else if (code == CLI_DONE && p.n_page == 0)
            code = CLI_NOTHING;
    }
    free_press(&p);
    return code;
}
