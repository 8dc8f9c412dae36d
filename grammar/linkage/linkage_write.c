/* grammar/linkage/linkage_write.c - a linkage as JSON text: one joint or tracer on each line, each number in the shortest
 * form that reads back the same. */
#include "grammar/linkage/assembly.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/number.h"
#include "grammar/text/json_internal.h"

typedef struct writer {
    FILE           *f;
    const lw_units *units;
    int             indent;      /* blanks for each level; 0: everything on one line */
} writer;

static void put_line(const writer *w, int level)
{
    if (w->indent > 0)
        fprintf(w->f, "\n%*s", w->indent*level, "");
}

/* Separator before element i of a list, each on its own line. */
static void put_step(const writer *w, int level, int i)
{
    if (i > 0)
        fputs(w->indent > 0 ? "," : ", ", w->f);
    put_line(w, level);
}

static void put_string(const writer *w, const char *s)
{
    char code[8];
    fputc('"', w->f);
    for (; *s; s++)
        fwrite(code, 1, (size_t)lw_json_character(*s, code), w->f);
    fputc('"', w->f);
}

static void put_text(const writer *w, const char *key, const char *value)
{
    fprintf(w->f, "\"%s\": ", key);
    put_string(w, value);
}

static void put_number(const writer *w, double v, double unit)
{
    char text[LW_NUMBER_SIZE];
    lw_number_print_in(v, unit, text);
    fputs(text, w->f);
}

static void put_pair(const writer *w, const char *key, lw_vec2 p, double unit)
{
    fprintf(w->f, ", \"%s\": [", key);
    put_number(w, p.x, unit);
    fputs(", ", w->f);
    put_number(w, p.y, unit);
    fputc(']', w->f);
}

static double ratio_unit(const writer *w, const lw_assembly *linkage, const lw_joint *j)
{
    lw_gear gear;
    bool carried = lw_assembly_gear(linkage, (int)(j - linkage->joint), &gear, NULL, NULL) == LW_OK;
    return carried ? lw_linkage_gear_unit(&gear, w->units->metre) : 1.0;
}

static void put_joint(const writer *w, const lw_assembly *linkage, const lw_joint *j)
{
    fputc('{', w->f);
    put_text(w, "name", j->name);
    fprintf(w->f, ", \"kind\": \"%c\", \"links\": [", (char)j->kind);
    put_string(w, linkage->link_name[j->link[0]]);
    fputs(", ", w->f);
    put_string(w, linkage->link_name[j->link[1]]);
    fputc(']', w->f);
    put_pair(w, "at", j->at, w->units->metre);
    if (lw_joint_slides(j->kind))
        put_pair(w, "along", j->along, 1);
    if (lw_joint_has_ratio(j->kind)) {
        fputs(", \"ratio\": ", w->f);
        put_number(w, j->ratio, ratio_unit(w, linkage, j));
    }
    fputc('}', w->f);
}

static void put_input(const writer *w, const lw_assembly *linkage, const lw_input *in)
{
    const lw_joint *j = &linkage->joint[in->joint];
    double unit = lw_joint_slides(j->kind) ? w->units->metre : w->units->radian;
    fputc('{', w->f);
    put_text(w, "joint", j->name);
    fputs(", \"value\": ", w->f);
    put_number(w, in->value, unit);
    if (in->first != 0 || in->last != 0) {
        fputs(", \"first\": ", w->f);
        put_number(w, in->first, unit);
        fputs(", \"last\": ", w->f);
        put_number(w, in->last, unit);
    }
    if (in->ratio != 0) {
        fputs(", \"ratio\": ", w->f);
        put_number(w, in->ratio, lw_assembly_tie_unit(linkage, (int)(in - linkage->input), w->units->metre));
    }
    fputc('}', w->f);
}

static void put_tracer(const writer *w, const lw_assembly *linkage, const lw_tracer *t)
{
    fputc('{', w->f);
    put_text(w, "name", t->name);
    fputs(", ", w->f);
    put_text(w, "link", linkage->link_name[t->link]);
    put_pair(w, "at", t->at, w->units->metre);
    fputs(", \"angle\": ", w->f);
    put_number(w, t->angle, w->units->radian);
    fputc('}', w->f);
}

static void put_head(const writer *w, const lw_assembly *linkage)
{
    put_line(w, 1);
    fputs("\"linkwright\": 1", w->f);
    put_step(w, 1, 1);
    put_text(w, "name", linkage->name);
    put_step(w, 1, 1);
    fputs("\"units\": {", w->f);
    if (linkage->units.length[0]) {
        put_text(w, "length", linkage->units.length);
        fputs(", ", w->f);
    }
    put_text(w, "angle", linkage->units.angle);
    fputc('}', w->f);
    put_step(w, 1, 1);
    fputs("\"links\": [", w->f);
    for (int i = 0; i < linkage->n_link; i++) {
        fputs(i > 0 ? ", " : "", w->f);
        put_string(w, linkage->link_name[i]);
    }
    fputc(']', w->f);
    put_step(w, 1, 1);
    put_text(w, "ground", linkage->link_name[linkage->ground]);
}

static void put_inputs(const writer *w, const lw_assembly *linkage)
{
    if (linkage->n_input == 0)
        return;
    put_step(w, 1, 1);
    fputs(linkage->n_input == 1 ? "\"input\": " : "\"inputs\": [", w->f);
    for (int i = 0; i < linkage->n_input; i++) {
        if (linkage->n_input > 1)
            put_step(w, 2, i);
        put_input(w, linkage, &linkage->input[i]);
    }
    if (linkage->n_input > 1) {
        put_line(w, 1);
        fputc(']', w->f);
    }
}

static void put_linkage(const writer *w, const lw_assembly *linkage)
{
    fputc('{', w->f);
    put_head(w, linkage);
    put_step(w, 1, 1);
    fputs("\"joints\": [", w->f);
    for (int i = 0; i < linkage->n_joint; i++) {
        put_step(w, 2, i);
        put_joint(w, linkage, &linkage->joint[i]);
    }
    put_line(w, 1);
    fputc(']', w->f);
    put_inputs(w, linkage);
    if (linkage->n_tracer > 0) {
        put_step(w, 1, 1);
        fputs("\"tracers\": [", w->f);
        for (int i = 0; i < linkage->n_tracer; i++) {
            put_step(w, 2, i);
            put_tracer(w, linkage, &linkage->tracer[i]);
        }
        put_line(w, 1);
        fputc(']', w->f);
    }
    put_line(w, 0);
    fputs(w->indent > 0 ? "}\n" : "}", w->f);
}

char *lw_assembly_write(const lw_assembly *linkage, int indent)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    put_linkage(&(writer){ .f = f, .units = &linkage->units, .indent = indent }, linkage);
    bool failed = ferror(f) != 0;
    if (fclose(f) != 0 || failed) {
        free(text);
        return NULL;
    }
    return text;
}

char *lw_linkage_write(const lw_linkage *linkage, int indent) { return lw_assembly_write(LW_VIEW(linkage), indent); }
