#include "optimise/task/task_file.h"

#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "grammar/linkage/read_internal.h"
#include "optimise/task/target_internal.h"

/* ---- pieces --------------------------------------------------------------------------------------------- */

/* Read one of several words; *out is unchanged if the key is missing. */
static lw_status read_word(const lw_json_node *o, const char *key, const char *const *words, int n, int *out, bool *given, lw_error *e)
{
    lw_json_node node;
    if (given)
        *given = false;
    if (!lw_json_member(o, key, &node))
        return LW_OK;
    if (given)
        *given = true;
    return lw_read_look_up(&node, key, words, n, out, e);
}

static lw_status read_text(const lw_json_node *o, const char *key, char *out, size_t size, lw_error *e)
{
    lw_json_node node;
    return lw_json_member(o, key, &node) ? lw_json_name(&node, out, size, e) : LW_OK;
}

/* Read true or false; -1 if the key is missing. */
static lw_status read_yes(const lw_json_node *o, const char *key, int *out, lw_error *e)
{
    lw_json_node node;
    if (!lw_json_member(o, key, &node))
        return LW_OK;
    *out = lw_json_truth(&node);
    return *out >= 0 ? LW_OK : lw_json_fault(&node, e, "true or false is expected here");
}

/* Read a number in least .. most, in a unit; unchanged if the key is missing. */
static lw_status read_bounded(const lw_json_node *o, const char *key, double unit, double least, double most, double *out, lw_error *e)
{
    bool given;
    lw_json_node node;
    lw_status s = lw_read_optional(o, key, unit, out, &given, e);
    if (s != LW_OK || !given || (*out >= least*unit && *out <= most*unit))
        return s;
    lw_json_member(o, key, &node);
    return lw_json_fault(&node, e, "this must lie between %g and %g", least, most);
}

/* ---- conditions --------------------------------------------------------------------------------------------- */

static lw_status read_lengths(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    static const char *const known[] = { "least", "most", "ratio" };
    lw_json_node o;
    if (!lw_json_member(root, "lengths", &o))
        return LW_OK;
    lw_fit_spec *f = &b->spec;
    double m = b->units.metre;
    lw_status s = lw_json_expect(&o, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(&o, known, COUNT(known), e)) == LW_OK
        && (s = read_bounded(&o, "least", m, 0, 1e90, &f->length_lo, e)) == LW_OK
        && (s = read_bounded(&o, "most", m, 1e-90, 1e90, &f->length_hi, e)) == LW_OK)
        s = read_bounded(&o, "ratio", 1, 1, 1e9, &f->length_ratio, e);
    if (s == LW_OK && f->length_hi > 0 && f->length_lo > f->length_hi)
        s = lw_json_fault(&o, e, "the least length %g is above the greatest %g: no linkage can do both", f->length_lo/m, f->length_hi/m);
    return s;
}

static lw_status read_positions(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    static const char *const known[] = { "least", "most" };
    lw_json_node o, part;
    double m = b->units.metre, *lo = &b->spec.position_lo, *hi = &b->spec.position_hi;
    if (!lw_json_member(root, "positions", &o))
        return LW_OK;
    lw_status s = lw_json_expect(&o, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(&o, known, COUNT(known), e)) == LW_OK
        && (s = lw_read_need(&o, "least", &part, e)) == LW_OK && (s = lw_json_number(&part, lo, e)) == LW_OK
        && (s = lw_read_need(&o, "most", &part, e)) == LW_OK)
        s = lw_json_number(&part, hi, e);
    if (s == LW_OK && !(*lo < *hi))
        s = lw_json_fault(&o, e, "\"least\" must be below \"most\"");
    *lo *= m;
    *hi *= m;
    return s;
}

/* Read [[x, y], [x, y]], the lower left corner first. */
static lw_status read_box(const lw_json_node *n, double metre, lw_zone *z, lw_error *e)
{
    lw_status s = lw_read_list(n, 2, 2, e);
    for (size_t i = 0; i < 2 && s == LW_OK; i++) {
        lw_json_node corner = lw_json_element(n, i);
        s = lw_read_pair(&corner, metre, i ? &z->to : &z->at, e);
    }
    if (s == LW_OK && !(z->at.x < z->to.x && z->at.y < z->to.y))
        s = lw_json_fault(n, e, "the first corner must lie below and to the left of the second: this box holds nothing");
    return s;
}

static lw_status read_line(const lw_json_node *o, const lw_json_node *n, double metre, lw_zone *z, lw_error *e)
{
    lw_vec2 to;
    lw_status s = lw_read_list(n, 2, 2, e);
    for (size_t i = 0; i < 2 && s == LW_OK; i++) {
        lw_json_node point = lw_json_element(n, i);
        s = lw_read_pair(&point, metre, i ? &to : &z->at, e);
    }
    if (s != LW_OK)
        return s;
    double length = lw_v2_norm(lw_v2_sub(to, z->at));
    if (!(length > 0))
        return lw_json_fault(n, e, "a line goes through two different points");
    z->to = lw_v2_scale(lw_v2_sub(to, z->at), 1/length);
    z->reach = 1e-6*length;
    return read_bounded(o, "within", metre, 0, 1e90, &z->reach, e);
}

static lw_status read_circle(const lw_json_node *n, double metre, lw_zone *z, lw_error *e)
{
    lw_status s = lw_read_list(n, 2, 2, e);
    if (s != LW_OK)
        return s;
    lw_json_node centre = lw_json_element(n, 0), radius = lw_json_element(n, 1);
    s = lw_read_pair(&centre, metre, &z->at, e);
    if (s == LW_OK)
        s = lw_json_number(&radius, &z->reach, e);
    z->reach *= metre;
    return s == LW_OK && !(z->reach > 0) ? lw_json_fault(&radius, e, "a radius is greater than 0") : s;
}

/* Read [[x, y], [x, y], [x, y], ...]. */
static lw_status read_polygon(const lw_json_node *n, double metre, lw_zone *z, lw_error *e)
{
    lw_status s = lw_read_list(n, 3, LW_ZONE_CORNERS, e);
    lw_error why = { 0 };
    z->n_corner = s == LW_OK ? (int)lw_json_count(n) : 0;
    for (int i = 0; i < z->n_corner && s == LW_OK; i++) {
        lw_json_node corner = lw_json_element(n, (size_t)i);
        s = lw_read_pair(&corner, metre, &z->corner[i], e);
    }
    return s == LW_OK && lw_zone_settle(z, &why) != LW_OK ? lw_json_fault(n, e, "%s", why.text) : s;
}

static lw_status add_zone(const lw_json_node *n, lw_task_file *b, lw_zone z, lw_error *e)
{
    if (b->spec.n_zone == LW_ZONE_MAX)
        return lw_json_fault(n, e, "more than %d zones", LW_ZONE_MAX);
    b->spec.zone[b->spec.n_zone++] = z;
    return LW_OK;
}

/* Read {"box": ...} or {"polygon": ...}; or, if forbidden, {"circle": ...}; or, for pivots, {"line": ..., "within": ...}. */
static lw_status read_zone(const lw_json_node *o, bool forbidden, lw_task_file *b, lw_error *e)
{
    static const char *const known[] = { "box", "circle", "line", "polygon", "within" };
    lw_zone z = { .kind = forbidden ? LW_ZONE_NO_BOX : LW_ZONE_PIVOTS_BOX };
    lw_json_node shape;
    double m = b->units.metre;
    lw_status s = lw_json_expect(o, LW_JSON_OBJECT, e);
    if (s != LW_OK || (s = lw_json_known_keys(o, known, COUNT(known), e)) != LW_OK)
        return s;
    if (lw_json_member(o, "box", &shape))
        s = read_box(&shape, m, &z, e);
    else if (forbidden && lw_json_member(o, "circle", &shape)) {
        z.kind = LW_ZONE_NO_CIRCLE;
        s = read_circle(&shape, m, &z, e);
    } else if (lw_json_member(o, "polygon", &shape)) {
        z.kind = forbidden ? LW_ZONE_NO_POLYGON : LW_ZONE_PIVOTS_POLYGON;
        s = read_polygon(&shape, m, &z, e);
    } else if (!forbidden && lw_json_member(o, "line", &shape)) {
        z.kind = LW_ZONE_PIVOTS_LINE;
        s = read_line(o, &shape, m, &z, e);
    } else
        s = lw_json_fault(o, e, forbidden ? "a forbidden zone is a \"box\", a \"circle\" or a \"polygon\""
                                          : "pivots lie in a \"box\" or a \"polygon\", or on a \"line\"");
    return s == LW_OK ? add_zone(o, b, z, e) : s;
}

static lw_status read_zones(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    lw_json_node pivots, list;
    lw_status s = LW_OK;
    if (lw_json_member(root, "pivots", &pivots))
        s = read_zone(&pivots, false, b, e);
    if (s != LW_OK || !lw_json_member(root, "forbidden", &list))
        return s;
    s = lw_read_list(&list, 1, LW_ZONE_MAX, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&list); i++) {
        lw_json_node zone = lw_json_element(&list, i);
        s = read_zone(&zone, true, b, e);
    }
    return s;
}

/* ---- what has to be done ------------------------------------------------------------------------------------ */

static lw_status read_dwell(const lw_json_node *o, lw_task_file *b, lw_error *e)
{
    static const char *const known[] = { "from", "to", "theta", "at", "points", "weight" };
    lw_dwell *d = &b->dwell[b->n_dwell];
    lw_json_node n;
    double angle = b->units.radian, points = 8;
    *d = (lw_dwell){ .weight = 1, .theta = NAN, .at = { NAN, NAN } };
    lw_status s = lw_json_expect(o, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(o, known, COUNT(known), e)) == LW_OK
        && (s = lw_read_need(o, "from", &n, e)) == LW_OK && (s = lw_json_number(&n, &d->from, e)) == LW_OK
        && (s = lw_read_need(o, "to", &n, e)) == LW_OK && (s = lw_json_number(&n, &d->to, e)) == LW_OK
        && (s = read_bounded(o, "theta", angle, -1e6, 1e6, &d->theta, e)) == LW_OK
        && (s = read_bounded(o, "points", 1, 2, 1000, &points, e)) == LW_OK
        && (s = read_bounded(o, "weight", 1, 1e-9, 1e9, &d->weight, e)) == LW_OK && lw_json_member(o, "at", &n))
        s = lw_read_pair(&n, b->units.metre, &d->at, e);
    if (s == LW_OK && !(d->from < d->to))
        s = lw_json_fault(o, e, "a dwell goes from a smaller to a greater input; from %g to %g holds nothing", d->from, d->to);
    d->from *= angle;
    d->to *= angle;
    d->points = (int)points;
    for (int i = 0; s == LW_OK && i < b->n_dwell; i++)
        if (d->from <= b->dwell[i].to && b->dwell[i].from <= d->to)
            s = lw_json_fault(o, e, "two dwells share inputs: the output cannot rest at two places at a time");
    b->n_dwell++;
    return s;
}

static lw_status read_dwells(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    lw_json_node list;
    if (!lw_json_member(root, "dwell", &list))
        return LW_OK;
    lw_status s = lw_read_list(&list, 1, LW_DWELL_MAX, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&list); i++) {
        lw_json_node d = lw_json_element(&list, i);
        s = read_dwell(&d, b, e);
    }
    return s;
}

/* In the order of lw_target_field. */
static const char *const column_names[LW_TARGET_FIELD_COUNT] = {
    "x", "y", "theta", "angle", "weight", "x2", "y2", "theta2", "weight2", "x3", "y3", "theta3", "weight3",
    "x4", "y4", "theta4", "weight4"
};

static double column_unit(const lw_task_file *b, int column)
{
    lw_target_field f = lw_field_first((lw_target_field)column);
    return f == LW_TARGET_FIELD_X || f == LW_TARGET_FIELD_Y ? b->units.metre
         : f == LW_TARGET_FIELD_THETA || f == LW_TARGET_FIELD_ANGLE ? b->units.radian : 1;
}

/* Read {"x": 1, "y": 2, ...}; every station has the same keys as the first. */
static lw_status read_station(const lw_json_node *o, const lw_task_file *b, bool first, bool has[LW_TARGET_FIELD_COUNT],
                              double v[LW_TARGET_FIELD_COUNT], lw_error *e)
{
    lw_status s = lw_json_expect(o, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(o, column_names, LW_TARGET_FIELD_COUNT, e);
    for (int c = 0; c < LW_TARGET_FIELD_COUNT && s == LW_OK; c++) {
        lw_json_node n;
        bool given = lw_json_member(o, column_names[c], &n);
        if (first)
            has[c] = given;
        if (given != has[c])
            s = lw_json_fault(o, e, "every station has the same numbers as the first one: \"%s\" is %s",
                              column_names[c], given ? "new here" : "missing");
        else if (given && (s = lw_json_number(&n, &v[c], e)) == LW_OK)
            v[c] *= column_unit(b, c);
    }
    return s;
}

/* Collect the further points among the columns; *n_also of them. */
static lw_status gather_also(const lw_json_node *list, double *const column[LW_TARGET_FIELD_COUNT],
                             lw_also also[LW_ALSO_MAX], int *n_also, lw_error *e)
{
    *n_also = 0;
    for (int i = 0; i < LW_ALSO_MAX; i++) {
        double *const *c = column + lw_field_also(LW_TARGET_FIELD_X, i);
        if (!c[0] && !c[1] && !c[2] && !c[3])
            continue;
        if (*n_also < i)
            return lw_json_fault(list, e, "there are numbers of point %d but none of point %d; points are numbered "
                                 "without gaps", i + 2, *n_also + 2);
        also[(*n_also)++] = (lw_also){ .x = c[0], .y = c[1], .theta = c[2], .weight = c[3] };
    }
    return LW_OK;
}

static lw_status read_rows(const lw_json_node *list, const lw_task_file *b, size_t n, double *v, lw_target *t, lw_error *e)
{
    bool has[LW_TARGET_FIELD_COUNT] = { false };
    double one[LW_TARGET_FIELD_COUNT], *column[LW_TARGET_FIELD_COUNT];
    lw_also also[LW_ALSO_MAX];
    int n_also;
    lw_status s = LW_OK;
    for (size_t i = 0; i < n && s == LW_OK; i++) {
        lw_json_node o = lw_json_element(list, i);
        s = read_station(&o, b, i == 0, has, one, e);
        for (int c = 0; c < LW_TARGET_FIELD_COUNT && s == LW_OK; c++)
            v[(size_t)c*n + i] = has[c] ? one[c] : 0;
    }
    for (int c = 0; c < LW_TARGET_FIELD_COUNT; c++)
        column[c] = has[c] ? v + (size_t)c*n : NULL;
    lw_error why = { .text = "" };
    if (s == LW_OK)
        s = gather_also(list, column, also, &n_also, e);
    if (s == LW_OK && lw_target_make_all(n, column[LW_TARGET_FIELD_X], column[LW_TARGET_FIELD_Y],
                                         column[LW_TARGET_FIELD_THETA], column[LW_TARGET_FIELD_ANGLE],
                                         column[LW_TARGET_FIELD_WEIGHT], also, n_also, b->closed, t, &why) != LW_OK)
        s = lw_json_fault(list, e, "%.300s", why.text);
    t->units = b->units;
    return s;
}

/* Read a target that is written in the task itself. */
static lw_status read_stations(const lw_json_node *from, const lw_task_file *b, lw_target *t, lw_error *e)
{
    lw_json_node list;
    if (!lw_json_member(from, "stations", &list))
        return LW_OK;
    lw_status s = lw_read_list(&list, 1, LW_STATION_MAX, e);
    size_t n = s == LW_OK ? lw_json_count(&list) : 0;
    double *v = calloc(LW_TARGET_FIELD_COUNT*n + 1, sizeof *v);
    if (!v)
        return lw_error_set(e, LW_E_MEMORY, "no memory for %zu stations", n);
    if (s == LW_OK)
        s = read_rows(&list, b, n, v, t, e);
    free(v);
    return s;
}

static lw_status read_source(const lw_json_node *o, const lw_task_file *b, char *target, lw_target *stations, lw_error *e)
{
    lw_status s = read_text(o, "target", target, LW_TASK_FILE_TEXT, e);
    if (s == LW_OK)
        s = read_stations(o, b, stations, e);
    if (s == LW_OK && !target[0] == (stations->n == 0))
        s = lw_json_fault(o, e, target[0] ? "either \"target\" or \"stations\", not both"
                                          : "\"target\" (a CSV file) or \"stations\" is missing");
    return s;
}

static const char *const carrier_names[] = { "any", "input", "coupler", "output" };

/* Read "tracers": the first point and further points, each with its target; the further ones also with a link. */
static lw_status read_tracers(const lw_json_node *list, lw_task_file *b, lw_error *e)
{
    static const char *const known[] = { "target", "stations", "link" };
    lw_json_node link;
    lw_status s = lw_read_list(list, 1, 1 + LW_ALSO_MAX, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(list); i++) {
        lw_json_node o = lw_json_element(list, i);
        lw_task_file_tracer *a = i > 0 ? &b->also[b->n_also++] : NULL;
        int carrier = 0;
        if ((s = lw_json_expect(&o, LW_JSON_OBJECT, e)) == LW_OK
            && (s = lw_json_known_keys(&o, known, COUNT(known), e)) == LW_OK
            && (s = read_source(&o, b, a ? a->target : b->target, a ? &a->stations : &b->stations, e)) == LW_OK)
            s = read_word(&o, "link", carrier_names, COUNT(carrier_names), &carrier, NULL, e);
        if (s == LW_OK && !a && lw_json_member(&o, "link", &link))
            s = lw_json_fault(&link, e, "the first point lies on the coupler, of a function on the output; links are for the further ones");
        if (a)
            b->spec.carrier[b->n_also - 1] = (lw_carrier)carrier;
    }
    return s;
}

/* Read "point_links": the links of further points that are columns of the target. */
static lw_status read_carriers(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    lw_json_node list;
    if (!lw_json_member(root, "point_links", &list))
        return LW_OK;
    lw_status s = lw_read_list(&list, 1, LW_ALSO_MAX, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&list); i++) {
        lw_json_node o = lw_json_element(&list, i);
        int carrier = 0;
        s = lw_read_look_up(&o, "link", carrier_names, COUNT(carrier_names), &carrier, e);
        b->spec.carrier[i] = (lw_carrier)carrier;
    }
    return s;
}

/* Read where the points come from: "tracers", or one target with all columns. */
static lw_status read_sources(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    static const char *const other[] = { "target", "stations", "point_links" };
    lw_json_node list, too;
    if (!lw_json_member(root, "tracers", &list)) {
        lw_status s = read_source(root, b, b->target, &b->stations, e);
        return s == LW_OK ? read_carriers(root, b, e) : s;
    }
    for (int i = 0; i < COUNT(other); i++)
        if (lw_json_member(root, other[i], &too))
            return lw_json_fault(&too, e, "either \"tracers\" or \"%s\", not both", other[i]);
    return read_tracers(&list, b, e);
}

static lw_status read_wanted(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    const char *tasks[LW_TASKS];
    int task = 0, timing = 0;
    for (int i = 0; i < LW_TASKS; i++)
        tasks[i] = lw_task_table[i].name;
    lw_status s = read_word(root, "task", tasks, LW_TASKS, &task, &b->has_task, e);
    if (s == LW_OK)
        s = read_word(root, "timing", lw_timing_names, LW_TIMINGS, &timing, &b->has_timing, e);
    if (b->has_task)
        b->spec.task = (lw_task)task;
    if (b->has_timing)
        b->spec.timing = (lw_timing)timing;
    if (s == LW_OK && (s = read_yes(root, "closed", &b->closed, e)) == LW_OK && (s = read_sources(root, b, e)) == LW_OK)
        s = read_dwells(root, b, e);
    return s;
}

/* F = 3 (P - 1) - 2 n1 without joints of two freedoms (Makkonen 1999, eq. 2). */
static bool links_suit(const lw_task_file *b)
{
    int dof = b->dof > 0 ? b->dof : 1;
    return b->links == 0 || strpbrk(b->joints, "pg") || (3*(b->links - 1) - dof) % 2 == 0;
}

static lw_status links_fault(const lw_json_node *root, const lw_task_file *b, lw_error *e)
{
    static const char *const links[] = { "one freedom and pins have 4, 6, 8 or 10",
                                         "two freedoms and pins have 5, 7 or 9",
                                         "three freedoms and pins have 8 or 10" };
    lw_json_node o;
    if (!lw_json_member(root, "links", &o))
        lw_json_member(root, "dof", &o);
    return lw_json_fault(&o, e, "linkages of %s links; with joints of two freedoms, p or g, others too",
                         links[b->dof > 0 ? b->dof - 1 : 0]);
}

/* Limits that hold by default, given instead or switched off. */
static lw_status read_limits(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    static const struct { const char *key; unsigned limit; } given[] = {
        { "transmission", LW_LIMIT_TRANSMISSION }, { "max_size", LW_LIMIT_SIZE }, { "class_margin", LW_LIMIT_MARGIN }
    };
    lw_fit_spec *f = &b->spec;
    int through = -1, unlimited = -1;
    lw_json_node o;
    lw_status s = read_bounded(root, "max_size", 1, 0.1, 1e9, &f->max_size, e);
    if (s == LW_OK && (s = read_bounded(root, "class_margin", 1, 0, 0.5, &f->class_margin, e)) == LW_OK
        && (s = read_bounded(root, "tolerance", b->units.metre, 1e-90, 1e90, &f->tolerance, e)) == LW_OK
        && (s = read_yes(root, "through_limits", &through, e)) == LW_OK)
        s = read_yes(root, "unlimited", &unlimited, e);
    for (size_t i = 0; i < COUNT(given); i++)
        b->limits |= lw_json_member(root, given[i].key, &o) ? given[i].limit : 0;
    b->limits |= (f->length_ratio > 0 ? LW_LIMIT_RATIO : 0) | (through == 1 ? LW_LIMIT_MOTION : 0)
               | (unlimited == 1 ? LW_LIMIT_ALL : 0);
    if (s == LW_OK && unlimited == 1 && lw_json_member(root, "tolerance", &o))
        s = lw_json_fault(&o, e, "\"tolerance\" chooses among linkages by size, which does not go together with \"unlimited\"");
    return s;
}

/* How the path of a target file becomes stations. */
static lw_status read_sampling(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    double n = 0;
    char word[8] = "";
    lw_json_node o;
    lw_status s = LW_OK;
    if (lw_json_member(root, "smooth", &o) && lw_json_expect(&o, LW_JSON_TEXT, NULL) == LW_OK
        && lw_json_name(&o, word, sizeof word, NULL) == LW_OK && strcmp(word, "auto") == 0)
        b->smooth = -1;
    else
        s = read_bounded(root, "smooth", 1, 0, 1e90, &b->smooth, e);
    if (s == LW_OK && !b->target[0] && (lw_json_member(root, "smooth", &o) || lw_json_member(root, "resample", &o)))
        return lw_json_fault(&o, e, "this is about the path of a \"target\" file, and this task names none");
    if (s != LW_OK || !lw_json_member(root, "resample", &o))
        return s;
    if (lw_json_expect(&o, LW_JSON_TEXT, NULL) == LW_OK && lw_json_name(&o, word, sizeof word, NULL) == LW_OK
        && strcmp(word, "drawn") == 0) {
        b->resample = -1;
        return LW_OK;
    }
    s = read_bounded(root, "resample", 1, 2, 10000, &n, e);
    b->resample = (int)n;
    return s == LW_OK && n != b->resample ? lw_json_fault(&o, e, "a whole number of stations, or \"drawn\", is expected here") : s;
}

static lw_status read_conditions(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    static const char *const known[] = { "path", "angle", "angle_length" };
    lw_fit_spec *f = &b->spec;
    lw_json_node o;
    int crank = -1;
    double m = b->units.metre, links = 0, dof = 0;
    lw_status s = read_yes(root, "crank", &crank, e);
    f->crank_only = crank == 1;
    f->a /= m*m;
    f->b = 0;                                            /* by the target, if nothing is said */
    if (s == LW_OK && lw_json_member(root, "weights", &o)
        && (s = lw_json_expect(&o, LW_JSON_OBJECT, e)) == LW_OK && (s = lw_json_known_keys(&o, known, 3, e)) == LW_OK
        && (s = read_bounded(&o, "angle_length", m, 1e-90, 1e90, &f->angle_length, e)) == LW_OK
        && (s = read_bounded(&o, "path", 1/(m*m), 0, 1e300, &f->a, e)) == LW_OK)
        s = read_bounded(&o, "angle", 1, 0, 1e300, &f->b, e);
    if (s == LW_OK && (s = read_bounded(root, "transmission", b->units.radian, 0, 1.55/b->units.radian,
                                        &f->min_transmission, e)) == LW_OK
        && (s = read_bounded(root, "acceleration", m, 0, 1e90, &f->max_acceleration, e)) == LW_OK
        && (f->max_slide_acceleration = f->max_acceleration/(m*m)) >= 0
        && (s = read_bounded(root, "links", 1, 4, 10, &links, e)) == LW_OK
        && (s = read_bounded(root, "dof", 1, 1, 3, &dof, e)) == LW_OK
        && (s = read_text(root, "joints", b->joints, sizeof b->joints, e)) == LW_OK
        && (s = read_text(root, "topology", b->topology, sizeof b->topology, e)) == LW_OK
        && (s = read_lengths(root, b, e)) == LW_OK && (s = read_positions(root, b, e)) == LW_OK)
        s = read_zones(root, b, e);
    if (s == LW_OK && (s = read_limits(root, b, e)) == LW_OK)
        s = read_sampling(root, b, e);
    const char *why = s == LW_OK ? lw_contradiction(f) : NULL;
    if (why && (lw_json_member(root, "forbidden", &o) || lw_json_member(root, "pivots", &o)))
        s = lw_json_fault(&o, e, "%s: no linkage can do both", why);
    if (s != LW_OK)
        return s;
    b->links = (int)links;
    b->dof = (int)dof;
    return links != b->links || dof != b->dof || !links_suit(b) ? links_fault(root, b, e) : LW_OK;
}

static lw_status read_root(const lw_json_node *root, lw_task_file *b, lw_error *e)
{
    static const char *const known[] = {
        "linkwright-task", "$schema", "name", "units", "target", "stations", "tracers", "point_links", "closed", "task",
        "timing", "links", "dof", "joints", "topology", "crank", "weights", "transmission", "acceleration", "lengths",
        "positions", "pivots", "forbidden", "dwell", "max_size", "class_margin", "through_limits", "unlimited",
        "tolerance", "smooth", "resample"
    };
    lw_json_node version;
    double number;
    lw_status s = lw_json_expect(root, LW_JSON_OBJECT, e);
    if (s == LW_OK && !lw_json_member(root, "linkwright-task", &version))
        s = lw_json_fault(root, e, "this is no task: \"linkwright-task\": 1 is missing. A target is a task, a table (CSV) or a drawing (SVG, DXF)");
    if (s == LW_OK && (s = lw_json_known_keys(root, known, COUNT(known), e)) == LW_OK
        && (s = lw_json_number(&version, &number, e)) == LW_OK && number != 1)
        s = lw_json_fault(&version, e, "version %g of the task notation is not known; this program knows 1", number);
    if (s == LW_OK && (s = read_text(root, "name", b->name, sizeof b->name, e)) == LW_OK
        && (s = lw_read_units(root, &b->units, e)) == LW_OK && (s = read_wanted(root, b, e)) == LW_OK)
        s = read_conditions(root, b, e);
    return s;
}

lw_status lw_task_file_read(const char *text, size_t size, const char *file, lw_task_file *b, lw_error *e)
{
    lw_json json;
    *b = (lw_task_file){ .closed = -1, .spec = lw_fit_spec_default(), .units = lw_units_si() };
    lw_status s = lw_json_open(text, size, file, &json, e);
    if (s != LW_OK)
        return s;
    lw_json_node root = lw_json_root(&json);
    s = read_root(&root, b, e);
    lw_json_close(&json);
    if (s != LW_OK)
        lw_task_file_free(b);
    return s;
}

void lw_task_file_free(lw_task_file *b)
{
    lw_target_free(&b->stations);
    for (int i = 0; i < LW_ALSO_MAX; i++)
        lw_target_free(&b->also[i].stations);
}

/* ---- the target ------------------------------------------------------------------------------------------------- */

static lw_status check_point(const lw_task_file *b, const double *x, const double *y, size_t n, int point, lw_error *e)
{
    for (int i = 0; i < b->spec.n_zone; i++)
        for (size_t k = 0; x && k < n; k++)
            if (lw_zone_forbids(&b->spec.zone[i]) && lw_zone_outside(&b->spec.zone[i], lw_v2(x[k], y[k])) < 0)
                return lw_error_set(e, LW_E_ARG, point > 0 ? "station %zu of point %d lies inside a forbidden zone: no "
                                    "linkage can do both" : "station %zu lies inside a forbidden zone: no linkage can "
                                    "do both", k + 1, point + 1);
    return LW_OK;
}

static lw_status check_stations(const lw_task_file *b, const lw_target *t, lw_error *e)
{
    lw_status s = check_point(b, t->x, t->y, t->n, 0, e);
    for (int i = 0; i < t->n_also && s == LW_OK; i++)
        s = check_point(b, t->also[i].x, t->also[i].y, t->n, i + 1, e);
    return s;
}

typedef struct station { double v[LW_TARGET_FIELD_ALSO]; } station;

static int by_angle(const void *a, const void *b)
{
    const station *p = a, *q = b;
    double u = p->v[LW_TARGET_FIELD_ANGLE], v = q->v[LW_TARGET_FIELD_ANGLE];
    return u < v ? -1 : u > v;
}

static lw_status add_dwell(const lw_dwell *d, const lw_target *from, station *s, size_t *n, lw_error *e)
{
    if (from->theta && isnan(d->theta))
        return lw_error_set(e, LW_E_ARG, "a dwell of this task needs \"theta\", where the output rests");
    if (from->x && isnan(d->at.x))
        return lw_error_set(e, LW_E_ARG, "a dwell of this task needs \"at\", where the point rests");
    for (size_t k = 0; k < *n; k++)
        if (s[k].v[LW_TARGET_FIELD_ANGLE] >= d->from && s[k].v[LW_TARGET_FIELD_ANGLE] <= d->to)
            return lw_error_set(e, LW_E_ARG, "station %zu has an input within a dwell: leave it out", k + 1);
    for (int i = 0; i < d->points; i++)
        s[(*n)++] = (station){ { d->at.x, d->at.y, d->theta, d->from + (d->to - d->from)*i/(d->points - 1),
                                 d->weight } };
    return LW_OK;
}

/* Make the target with the stations of its dwells. */
static lw_status add_dwells(const lw_task_file *b, const lw_target *from, lw_target *t, lw_error *e)
{
    enum { COLUMNS = LW_TARGET_FIELD_ALSO };
    size_t n = from->n, room = n;
    lw_status st = LW_OK;
    for (int i = 0; i < b->n_dwell; i++)
        room += (size_t)b->dwell[i].points;
    station *s = malloc(sizeof *s*(room + 1));
    double *v = malloc(sizeof *v*(COLUMNS*room + 1)), *column[COLUMNS];
    if (!s || !v)
        st = lw_error_set(e, LW_E_MEMORY, "no memory for %zu stations", room);
    for (size_t k = 0; k < n && st == LW_OK; k++)
        for (int c = 0; c < COLUMNS; c++) {
            const double *have = lw_target_array(from, (lw_target_field)c);
            s[k].v[c] = have ? have[k] : 0;
        }
    for (int i = 0; i < b->n_dwell && st == LW_OK; i++)
        st = add_dwell(&b->dwell[i], from, s, &n, e);
    if (st == LW_OK)
        qsort(s, n, sizeof *s, by_angle);
    for (int c = 0; c < COLUMNS && st == LW_OK; c++) {
        column[c] = lw_target_array(from, (lw_target_field)c) ? v + (size_t)c*n : NULL;
        for (size_t k = 0; k < n && column[c]; k++)
            column[c][k] = s[k].v[c];
    }
    if (st == LW_OK)
        st = lw_target_make(n, column[LW_TARGET_FIELD_X], column[LW_TARGET_FIELD_Y], column[LW_TARGET_FIELD_THETA],
                            column[LW_TARGET_FIELD_ANGLE], column[LW_TARGET_FIELD_WEIGHT], from->closed, t, e);
    free(s);
    free(v);
    return st;
}

lw_status lw_task_file_target(const lw_task_file *b, const lw_target *from, lw_target *t, lw_error *e)
{
    memset(t, 0, sizeof *t);
    if (b->n_dwell > 0 && !from->angle)
        return lw_error_set(e, LW_E_ARG, "a dwell needs the input angles of the stations (angle)");
    if (b->n_dwell > 0 && from->n_also > 0)
        return lw_error_set(e, LW_E_ARG, "a dwell says where one point rests, and the target has %d; write the "
                            "stations of the dwell out", 1 + from->n_also);
    lw_status st = b->n_dwell > 0 ? add_dwells(b, from, t, e) : lw_target_join(&from, 1, t, e);
    if (st != LW_OK)
        return st;
    t->units = from->units;
    if ((st = check_stations(b, t, e)) != LW_OK)
        lw_target_free(t);
    return st;
}
