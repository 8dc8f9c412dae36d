/* Drawings of chains and sheets of them: everything inside its cell, every link and joint there once, signs
 * of the frame below everything else, captions cut to their cell. */
#include "catalogues/draw/chain_drawing.h"
#include "catalogues/draw/picture.h"
#include "catalogues/draw/sheet.h"
#include "catalogues/draw/svg.h"
#include "grammar/topology/edges.h"
#include "tests/all_chains.h"
#include "tests/check.h"
#include "tests/xml_scan.h"

static lw_mechanism read_edges(const char *text)
{
    lw_mechanism m;
    lw_error e = { 0 };
    if (lw_edges_read(text, strlen(text), NULL, &m, &e) != LW_OK)
        fprintf(stderr, "%s\n", e.text);
    return m;
}

static int count_role(const lw_drawing *d, lw_role role, int item)
{
    int n = 0;
    for (size_t i = 0; i < d->n_shape; i++)
        n += d->shape[i].role == role && (item < 0 || d->shape[i].item == item);
    return n;
}

/* Corners of the smallest box around all shapes but the paper. */
static lw_box extent_of(const lw_drawing *d)
{
    lw_box b = { 1e9, 1e9, -1e9, -1e9 };
    for (size_t i = 0; i < d->n_shape; i++) {
        const lw_shape *s = &d->shape[i];
        double half = s->kind == LW_SHAPE_TEXT ? 0 : s->kind == LW_SHAPE_CIRCLE ? s->radius + s->width/2 : s->width/2;
        for (size_t k = 0; k < (s->kind == LW_SHAPE_PATH ? s->n : 1) && s->role != LW_ROLE_PAPER; k++) {
            lw_vec2 p = s->kind == LW_SHAPE_PATH ? d->point[s->first + k] : s->at;
            b.x0 = fmin(b.x0, p.x - half);
            b.x1 = fmax(b.x1, p.x + half);
            b.y0 = fmin(b.y0, p.y - half);
            b.y1 = fmax(b.y1, p.y + half);
        }
    }
    return b;
}

TEST(inside_its_page)
{
    static const char *const topology[] = {
        "1-2 2-3 3-4 4-1", "1-2! 1-4:t 2-3 3-4 @1 >3", "1-2! 1-4 2-3:p 3-4 @1", "1-2! 1-3 2-3:g @1", "1-2 2-3",
        "1-2:t 2-3:t 3-4:t 1-4:t", "1-2! 1-4 1-6:t 2-3 3-4 3-5 5-6 @1 >6",
    };
    for (size_t i = 0; i < sizeof topology/sizeof *topology; i++)
        for (int wide = 0; wide < 2; wide++) {
            lw_mechanism m = read_edges(topology[i]);
            lw_chain_layout l;
            OWN(lw_drawing) d = { 0 };
            lw_chain_style s = { wide ? 400 : 120, wide ? 100 : 300, true, "a caption" };
            CHECK_INT(lw_chain_layout_make(&m, &l, NULL), LW_OK);
            CHECK_INT(lw_chain_draw(&m, &l, &s, &d, NULL), LW_OK);
            lw_box b = extent_of(&d);
            CHECK(b.x0 >= 0 && b.y0 >= 0 && b.x1 <= s.width && b.y1 <= s.height);
            for (int k = 0; k < m.n_link; k++)
                CHECK_INT(count_role(&d, LW_ROLE_LINK, k), k != m.ground && l.end[k].x == l.end[k].x);
            CHECK_INT(count_role(&d, LW_ROLE_NOTE, -1), m.n_link);
            CHECK_INT(count_role(&d, LW_ROLE_INPUT, -1) > 0, m.n_input > 0);
        }
}

/* What the frame's hatching covers is below every link. */
TEST(frame_below_links)
{
    chain_list list = all_chains(6, 1);
    for (int i = 0; i < list.n; i++)
        for (int g = 0; g < 6; g++) {
            lw_mechanism m;
            lw_chain_layout l;
            OWN(lw_drawing) d = { 0 };
            lw_chain_style s = { .width = 320, .height = 240 };
            lw_mechanism_from_chain(&list.chain[i], &m);
            m.ground = g;
            CHECK_INT(lw_chain_layout_make(&m, &l, NULL), LW_OK);
            CHECK_INT(lw_chain_draw(&m, &l, &s, &d, NULL), LW_OK);
            double lowest_link = 0, highest_hatch = 1e9;
            for (size_t k = 0; k < d.n_shape; k++)
                for (size_t q = 0; q < d.shape[k].n && d.shape[k].kind == LW_SHAPE_PATH; q++) {
                    double y = d.point[d.shape[k].first + q].y;
                    if (d.shape[k].role == LW_ROLE_LINK)
                        lowest_link = fmax(lowest_link, y);
                    if (d.shape[k].role == LW_ROLE_HATCH)
                        highest_hatch = fmin(highest_hatch, y);
                }
            CHECK(highest_hatch > lowest_link);
            CHECK_INT(count_role(&d, LW_ROLE_GROUND, -1), l.first[g + 1] - l.first[g]);
        }
    free(list.chain);
}

static lw_status chain_svg(const lw_mechanism *m, const lw_chain_style *s, lw_bytes *out)
{
    lw_chain_layout l;
    OWN(lw_drawing) d = { 0 };
    CHECK_INT(lw_chain_layout_make(m, &l, NULL), LW_OK);
    lw_status st = lw_chain_draw(m, &l, s, &d, NULL);
    if (st == LW_OK)
        st = lw_svg_write(&d, out, NULL);
    return st;
}

TEST(svg_is_well_formed)
{
    lw_mechanism m = read_edges("1-2! 1-4:t 2-3 3-4 @1");
    lw_chain_style s = { .width = 320, .height = 240 };
    lw_bytes a, b;
    s.caption = "<script>alert(1)</script> & \"x\"";
    CHECK_INT(chain_svg(&m, &s, &a), LW_OK);
    CHECK_INT(chain_svg(&m, &s, &b), LW_OK);
    CHECK(xml_scan(a.data, NULL, NULL) > 10);
    CHECK(!strstr(a.data, "<script"));
    CHECK_TEXT(a.data, b.data);
    lw_bytes_free(&a);
    lw_bytes_free(&b);
    s.width = 5;
    CHECK_INT(chain_svg(&m, &s, &a), LW_E_ARG);
}

TEST(sheets)
{
    chain_list list = all_chains(8, 1);
    lw_mechanism m[16];
    lw_sheet_item item[16];
    lw_sheet_style s = lw_sheet_style_default();
    lw_drawing d;
    OWN(lw_bytes) b = { 0 };
    for (int i = 0; i < 16; i++) {
        lw_mechanism_from_chain(&list.chain[i], &m[i]);
        item[i] = (lw_sheet_item){ &m[i], "a caption that is by far too long for the cell it stands in" };
    }
    s.title = "Eight links";
    CHECK_OK(lw_sheet_draw(item, 16, &s, 3, &d, &check_error));
    CHECK_INT(count_role(&d, LW_ROLE_LINK, -1), 16*8);
    CHECK_INT(count_role(&d, LW_ROLE_JOINT, -1), 16*10);
    CHECK(d.height < s.height && d.width == s.width);                            /* three rows of eight */
    lw_box x = extent_of(&d);
    CHECK(x.x0 >= 0 && x.y0 >= 0 && x.x1 <= d.width && x.y1 <= d.height);
    for (size_t i = 0; i < d.n_shape; i++)
        if (d.shape[i].kind == LW_SHAPE_TEXT)
            CHECK(lw_text_width(d.text + d.shape[i].first, d.shape[i].width) < d.width/6 || d.shape[i].width > 12);
    lw_drawing two[2] = { d, d };
    CHECK_OK(lw_picture_pdf_pages(two, 2, &b, &check_error));
    CHECK(b.size > 1000 && memmem(b.data, b.size, "/Count 2", 8) != NULL);
    lw_drawing_free(&d);
    CHECK_INT(lw_sheet_draw(item, 49, &s, 0, &d, &check_error), LW_E_ARG);
    s.columns = 60;
    CHECK_FAILS(lw_sheet_draw(item, 16, &s, 0, &d, &check_error), LW_E_ARG, "too small");
    s.columns = 0;
    CHECK_INT(lw_sheet_draw(item, 16, &s, 0, &d, &check_error), LW_E_ARG);
    free(list.chain);
}
