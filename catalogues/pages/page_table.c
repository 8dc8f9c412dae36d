/* catalogues/pages/page_table.c - the ranked results of a target as a table */
#include <math.h>
#include <stdio.h>

#include "catalogues/pages/page_internal.h"

typedef enum lw_column {
    TYPE, CLASS, MEAN, MAX, PERCENT, OBJECTIVE, DIMENSIONS, N_COLUMN
} lw_column;

static const struct { const char *title; bool number, length; } columns[N_COLUMN] = {
    [TYPE]       = { "Type", false, false },
    [CLASS]      = { "Class", false, false },
    [MEAN]       = { "Mean error", true, true },
    [MAX]        = { "Largest error", true, true },
    [PERCENT]    = { "% of path", true, false },
    [OBJECTIVE]  = { "Objective", true, false },
    [DIMENSIONS] = { "Dimensions", false, false },
};

static const lw_units *units_of(const lw_page_result *r)
{
    static const lw_units metre = { "m", "rad", 1, 1 };
    return r->scene ? &r->scene->linkage.units : &metre;
}

static double number_in(const lw_page_result *r, lw_column c)
{
    switch (c) {
    case MEAN:      return r->error_mean/units_of(r)->metre;
    case MAX:       return r->error_max/units_of(r)->metre;
    case PERCENT:   return r->error_percent;
    case OBJECTIVE: return r->objective;
    default:        return NAN;
    }
}

static const char *text_in(const lw_page_result *r, lw_column c)
{
    return c == TYPE ? r->type : c == CLASS ? r->class_name : NULL;
}

static bool has(const lw_page_result *r, lw_column c)
{
    return c == DIMENSIONS ? r->scene && r->scene->n_dim > 0
                           : text_in(r, c) || !isnan(number_in(r, c));
}

static bool is_used(const lw_page_target *t, lw_column c)
{
    for (int i = 0; i < t->n_result; i++)
        if (has(&t->result[i], c))
            return true;
    return false;
}

static void dimensions(lw_bytes *b, const lw_page_result *r)
{
    const lw_scene *s = r->scene;
    for (int i = 0; s && i < s->n_dim; i++) {
        lw_bytes_text(b, "<span>");
        lw_bytes_xml(b, s->dim_name[i]);
        lw_bytes_text(b, " = ");
        lw_bytes_number(b, lw_scene_dimension(s, i), 6);
        lw_bytes_text(b, "</span> ");
    }
}

/* "Mean error [mm]": the unit of the first result, which all of a target share. */
static void column_title(lw_bytes *b, const lw_page_target *t, lw_column c)
{
    const lw_units *u = units_of(&t->result[0]);
    lw_bytes_text(b, columns[c].title);
    if ((!columns[c].length && c != DIMENSIONS) || !u->length[0])
        return;
    lw_bytes_text(b, " [");
    lw_bytes_xml(b, u->length);
    lw_bytes_text(b, c == DIMENSIONS ? ", " : "]");
    if (c == DIMENSIONS) {
        lw_bytes_xml(b, u->angle);
        lw_bytes_text(b, "]");
    }
}

static void column_heads(lw_bytes *b, const lw_page_target *t)
{
    lw_bytes_text(b, "<thead><tr><th scope=\"col\">Rank</th>");
    for (int c = 0; c < N_COLUMN; c++) {
        if (!is_used(t, (lw_column)c))
            continue;
        lw_bytes_text(b, columns[c].number ? "<th scope=\"col\" class=\"number\">" : "<th scope=\"col\">");
        column_title(b, t, (lw_column)c);
        lw_bytes_text(b, "</th>");
    }
    lw_bytes_text(b, "</tr></thead>\n");
}

/* data-label: what stands before the cell where the page is too narrow for columns. */
static void cell(lw_bytes *b, const lw_page_target *t, const lw_page_result *r, lw_column c)
{
    lw_bytes_text(b, columns[c].number ? "<td class=\"number\" data-label=\""
                   : c == DIMENSIONS ? "<td class=\"dimensions\" data-label=\""
                   : "<td class=\"name\" data-label=\"");
    column_title(b, t, c);
    lw_bytes_text(b, "\">");
    if (c == DIMENSIONS)
        dimensions(b, r);
    else if (text_in(r, c))
        lw_bytes_xml(b, text_in(r, c));
    else if (!isnan(number_in(r, c)))
        lw_bytes_number(b, number_in(r, c), 4);
    lw_bytes_text(b, "</td>");
}

void lw_page_table(lw_bytes *b, const lw_page_target *t, int target)
{
    char text[192];
    if (t->n_result == 0) {
        lw_bytes_text(b, "<p>No linkage was found.</p>\n");
        return;
    }
    lw_bytes_text(b, "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Results\">\n"
                     "<table>\n<caption>Results, best first. Choose one to see it move.</caption>\n");
    column_heads(b, t);
    lw_bytes_text(b, "<tbody>\n");
    for (int i = 0; i < t->n_result; i++) {
        snprintf(text, sizeof text, "<tr><td class=\"rank\"><label><input type=\"radio\" "
                 "name=\"shown-%d\"%s> %d</label></td>", target + 1, i ? "" : " checked", i + 1);
        lw_bytes_text(b, text);
        for (int c = 0; c < N_COLUMN; c++)
            if (is_used(t, (lw_column)c))
                cell(b, t, &t->result[i], (lw_column)c);
        lw_bytes_text(b, "</tr>\n");
    }
    lw_bytes_text(b, "</tbody></table>\n</div>\n");
}
