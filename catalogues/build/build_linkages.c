/* catalogues/build/build_linkages.c - store results of fits in a catalogue (bridge to jansson). */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/real.h"
#include "catalogues/build/build_internal.h"
#include "catalogues/curves/descriptor.h"
#include "catalogues/draw/scene.h"
#include "catalogues/store/sha256.h"
#include "enumerate/canon.h"
#include "grammar/text/json_internal.h"
#include "grammar/topology/graph6.h"
#include "mbs/kinematics/fourbar.h"
#include "mbs/plan/types.h"

#define CURVE_POINTS 180               /* requested of a scene                                        */
#define CURVE_MAX    (8*CURVE_POINTS)  /* greatest number stored: a scene halves long steps             */

typedef struct job {
    const char             *file;
    const lw_build_control *control;
    lw_build_counts        *counts;
    lw_build_transaction    transaction;
    bool                    run;              /* the run is recorded                                  */
    long                    line;             /* line where the current value begins                  */
    lw_error                e;
} job;

/* The memory that the texts of a row point to. */
typedef struct entry {
    lw_store_linkage row;
    lw_assembly      k;
    char             hash[LW_SHA256_TEXT], label[LW_GRAPH6_SIZE], type[8];
    char            *json, *kinds;
    float            curve[2*CURVE_MAX];
    lw_packed        terms;
} entry;

/* ---- one linkage -------------------------------------------------------------------------------------- */

static const char *text_of(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

/* A number of the object times `unit`; NaN if there is none. */
static double number_of(const json_t *object, const char *key, double unit)
{
    const json_t *v = json_object_get(object, key);
    return json_is_number(v) ? json_number_value(v)*unit : NAN;
}

static int flag_of(const json_t *object, const char *key)
{
    const json_t *v = json_object_get(object, key);
    return json_is_boolean(v) ? json_is_true(v) : json_is_integer(v) ? (int)json_integer_value(v) : -1;
}

/* The joint letters of a four-link chain in loop order, from the driven joint at the ground; "" for other chains. */
static void set_type(const lw_assembly *linkage, char type[8])
{
    int link = linkage->ground, joint = linkage->n_input == 1 ? linkage->input[0].joint : -1;
    type[0] = 0;
    if (linkage->n_link != 4 || linkage->n_joint != 4 || joint < 0)
        return;
    for (int i = 0; i < 4; i++) {
        const lw_joint *j = &linkage->joint[joint];
        int next = -1;
        if (!lw_joint_can_drive(j->kind) || (j->link[0] != link && j->link[1] != link)) {
            type[0] = 0;
            return;
        }
        type[i] = lw_joint_turns(j->kind) ? 'R' : 'P';
        type[i + 1] = 0;
        link = j->link[0] == link ? j->link[1] : j->link[0];
        for (int n = 0; n < 4; n++)
            if (n != joint && (linkage->joint[n].link[0] == link || linkage->joint[n].link[1] == link))
                next = n;
        joint = next;
        if (joint < 0)
            return;
    }
}

/* Canonical label of the chain of the links; "" when the links form no chain (welded links, two joints between the same
 * two links, more links than a chain has). */
static lw_status set_label(entry *x)
{
    lw_chain c, form;
    x->label[0] = 0;
    if (lw_chain_clear(&c, x->k.n_link) != LW_OK)
        return LW_OK;
    for (int j = 0; j < x->k.n_joint; j++) {
        int a = x->k.joint[j].link[0], b = x->k.joint[j].link[1], freedom = lw_joint_freedoms(x->k.joint[j].kind);
        if (freedom == 0 || lw_chain_freedom(&c, a, b) || lw_chain_join(&c, a, b, freedom) != LW_OK)
            return LW_OK;
    }
    lw_status s = lw_chain_canonical(&c, &form);
    if (s == LW_OK)
        lw_graph6_print(&form, x->label, sizeof x->label);
    return s;
}

static int pin_between(const lw_assembly *linkage, int a, int b)
{
    for (int j = 0; j < linkage->n_joint; j++)
        if (lw_joint_turns(linkage->joint[j].kind)
            && ((linkage->joint[j].link[0] == a && linkage->joint[j].link[1] == b)
                || (linkage->joint[j].link[0] == b && linkage->joint[j].link[1] == a)))
            return j;
    return -1;
}

/* The link that a pin joins to `link`; -1: joint j is no pin of it, or leads to the ground or to the driven link. */
static int pinned_to(const lw_assembly *linkage, int j, int link, int driven)
{
    const lw_joint *q = &linkage->joint[j];
    int other = q->link[q->link[0] == link];
    bool pin = lw_joint_turns(q->kind) && (q->link[0] == link || q->link[1] == link);
    return pin && other != linkage->ground && other != driven ? other : -1;
}

/* Lengths of the first loop of four pins through the ground and the driven link: frame, input, coupler, output. */
static bool driven_four_bar(const lw_assembly *linkage, double r[4])
{
    int first = linkage->n_input == 1 ? linkage->input[0].joint : -1, found[2] = { -1, -1 };
    if (first < 0 || !lw_joint_turns(linkage->joint[first].kind))
        return false;
    const int *side = linkage->joint[first].link;
    if (side[0] != linkage->ground && side[1] != linkage->ground)
        return false;
    int driven = side[0] == linkage->ground ? side[1] : side[0];
    for (int i = 0; i < linkage->n_joint; i++) {
        int b = pinned_to(linkage, i, driven, driven);
        for (int k = 0; b >= 0 && k < linkage->n_joint; k++) {
            int c = pinned_to(linkage, k, b, driven);
            bool sooner = found[0] < 0 || b < found[0] || (b == found[0] && c < found[1]);
            if (c >= 0 && sooner && pin_between(linkage, c, linkage->ground) >= 0)
                found[0] = b, found[1] = c;
        }
    }
    if (found[0] < 0)
        return false;
    int loop[4] = { first, pin_between(linkage, driven, found[0]), pin_between(linkage, found[0], found[1]),
                    pin_between(linkage, found[1], linkage->ground) };
    for (int i = 0; i < 4; i++)
        r[i] = lw_v2_norm(lw_v2_sub(linkage->joint[loop[i]].at, linkage->joint[loop[(i + 3) % 4]].at));
    return true;
}

static void set_class(entry *x)
{
    double r[4];
    lw_fourbar_class c;
    if (!driven_four_bar(&x->k, r) || lw_fourbar_classify(r, LW_FOURBAR_TOLERANCE, &c, NULL) != LW_OK)
        return;
    x->row.four_bar = c.symbol;
    if (x->k.n_link == 4)
        x->row.crank = c.crank;
}

/* Compute the curve of the linkage's first tracer and its Fourier terms. */
static lw_status set_curve(entry *x)
{
    lw_scene scene;
    lw_scene_options o = lw_scene_options_default();
    lw_descriptor d;
    o.n_curve_point = CURVE_POINTS;
    o.n_frame = 2;
    lw_status s = lw_scene_make_any(&x->k, NULL, NULL, &o, &scene, NULL);
    if (s == LW_E_MEMORY)
        return s;
    const lw_curve *c = s == LW_OK && scene.n_curve > 0 ? &scene.curve[0] : NULL;
    size_t n = 0;
    while (c && n < c->n && n < CURVE_MAX && isfinite(c->p[n].x)) {
        x->curve[2*n] = (float)c->p[n].x;
        x->curve[2*n + 1] = (float)c->p[n].y;
        n++;
    }
    if (c && n == c->n && lw_descriptor_make(c->p, c->n, c->closed, &d) == LW_OK) {
        x->row.curve = x->curve;
        x->row.n_curve = n;
        x->row.closed = c->closed;
        x->row.size = d.size;
        lw_descriptor_pack(&d, &x->terms);
        if (x->k.n_link <= LW_LINK_MAX && x->k.n_joint <= LW_JOINT_MAX && x->k.n_input <= LW_INPUT_MAX
            && x->k.n_tracer <= LW_TRACER_MAX) {      /* nearest.c lays linkages on targets */
            x->row.terms = &x->terms;
            x->row.terms_size = sizeof x->terms;
        }
    }
    lw_scene_free(&scene);
    return LW_OK;
}

static void set_fit(entry *x, const json_t *result, const json_t *whole)
{
    const json_t *target = json_object_get(whole, "target");
    const char *unit = text_of(target, "length_unit"), *type = text_of(result, "type");
    lw_units u = lw_units_si();
    lw_store_linkage *r = &x->row;
    if (unit)
        lw_units_set_length(&u, unit);
    const lw_type *known = lw_type_find(type);
    r->type = known ? known->letters : type ? type : x->type[0] ? x->type : NULL;
    r->family = text_of(result, "family");
    if (text_of(result, "class"))
        r->four_bar = text_of(result, "class");
    r->task = text_of(whole, "task");
    r->timing = text_of(whole, "timing");
    r->target = json_is_string(target) ? json_string_value(target) : text_of(target, "file");
    r->objective = number_of(result, "objective", 1);
    r->error = number_of(result, "error_percent", 0.01);
    r->error_mean = number_of(result, "error_mean", u.metre);
    r->error_rms = number_of(result, "error_rms", u.metre);
    r->error_max = number_of(result, "error_max", u.metre);
    r->error_curve = number_of(result, "error_curve", u.metre);
    r->angle_error = number_of(result, "angle_error_mean", 1);
    r->transmission_min = number_of(result, "transmission_min", 1);
    r->transmission_max = number_of(result, "transmission_max", 1);
    r->crank = flag_of(result, "crank") >= 0 ? flag_of(result, "crank") : r->crank;
    r->circuits = flag_of(result, "circuits");
}

/* Hash by which the same linkage for the same target and task, with the same objective, is stored once. */
static lw_status set_hash(entry *x)
{
    char number[40];
    lw_bytes b = { 0 };
    const char *part[] = { x->json, x->row.target, x->row.task, number };
    snprintf(number, sizeof number, "%.9g", x->row.objective);
    for (size_t i = 0; i < sizeof part/sizeof *part; i++) {
        lw_bytes_text(&b, part[i] ? part[i] : "");
        lw_bytes_text(&b, "\n");
    }
    if (b.failed)
        return LW_E_MEMORY;
    lw_sha256_base64(b.data, b.size, x->hash);
    lw_bytes_free(&b);
    return LW_OK;
}

static lw_status read_linkage(job *j, const json_t *linkage, entry *x)
{
    char *text = json_dumps(linkage, JSON_COMPACT | JSON_REAL_PRECISION(17));
    if (!text)
        return lw_error_set(&j->e, LW_E_MEMORY, "out of memory");
    lw_status s = lw_assembly_read_result(text, strlen(text), j->file, 0, &x->k, &j->e);
    free(text);
    if (s == LW_E_NOTATION)                     /* the reader does not know some columns of the compact text */
        j->e.line = j->line, j->e.column = 0;
    if (s == LW_OK && !(x->json = lw_assembly_write(&x->k, 0)))
        s = lw_error_set(&j->e, LW_E_MEMORY, "out of memory");
    return s;
}

static lw_status describe(const job *j, entry *x)
{
    lw_store_linkage *r = &x->row;
    if (!(x->kinds = calloc((size_t)x->k.n_joint + 1, 1)))
        return LW_E_MEMORY;
    for (int i = 0; i < x->k.n_joint; i++) {
        x->kinds[i] = (char)x->k.joint[i].kind;
        r->sliders += lw_joint_translates(x->k.joint[i].kind);
    }
    r->hash = x->hash;
    r->json = x->json;
    r->name = x->k.name;
    r->kinds = x->kinds;
    r->links = x->k.n_link;
    r->joints = x->k.n_joint;
    r->dof = lw_assembly_mobility(&x->k);
    r->source = j->file;
    if (!r->four_bar)
        set_class(x);
    lw_status s = set_label(x);
    r->label = x->label[0] ? x->label : NULL;
    return s == LW_OK ? set_curve(x) : s;
}

/* ---- writing ------------------------------------------------------------------------------------------ */

static lw_status open_transaction(job *j)
{
    char what[160];
    lw_status s = lw_build_open(&j->transaction, &j->e);
    if (s != LW_OK || j->run)
        return s;
    snprintf(what, sizeof what, "linkages of %.140s", j->file);
    lw_store_run run = { "add", what, lw_build_command(j->control), j->control->seed };
    j->run = true;
    return lw_store_run_begin(j->transaction.store, &run, &j->e);
}

static lw_status add_one(job *j, const json_t *linkage, const json_t *result, const json_t *whole)
{
    lw_store *store = j->transaction.store;
    bool has = false;
    entry *x = calloc(1, sizeof *x);
    if (!x)
        return lw_error_set(&j->e, LW_E_MEMORY, "out of memory");
    x->row = (lw_store_linkage){ .crank = -1, .circuits = -1, .closed = -1, .size = NAN };
    lw_status s = read_linkage(j, linkage, x);
    if (s == LW_OK) {
        set_type(&x->k, x->type);
        set_fit(x, result, whole);
        s = set_hash(x);
    }
    if (s == LW_OK)
        s = lw_store_has_linkage(store, x->hash, &has, &j->e);
    if (s == LW_OK && !has)
        s = describe(j, x);
    if (s == LW_OK && !has)
        s = open_transaction(j);
    if (s == LW_OK && !has)
        s = lw_store_put_linkage(store, &x->row, &j->e);
    j->counts->done += s == LW_OK;
    j->counts->added += s == LW_OK && !has;
    free(x->json);
    free(x->kinds);
    lw_assembly_free(&x->k);
    free(x);
    if (s == LW_OK && lw_build_due(&j->transaction))
        s = lw_build_commit(&j->transaction, &j->e);
    return s == LW_OK && !lw_build_goes_on(j->control, (double)j->counts->done, 0) ? LW_STOPPED : s;
}

static lw_status add_value(job *j, const json_t *v)
{
    const json_t *results = json_object_get(v, "results"), *linkage = json_object_get(v, "linkage");
    lw_status s = LW_OK;
    if (json_is_object(linkage))
        return add_one(j, linkage, v, v);
    if (json_is_object(v) && json_object_get(v, "joints"))
        return add_one(j, v, NULL, NULL);
    if (!json_is_array(results))
        return lw_error_at(&j->e, LW_E_NOTATION, j->file, j->line, 0, "this is neither a linkage nor a result of a "
                           "fit: give an object with 'results', 'linkage' or 'joints'");
    for (size_t i = 0; i < json_array_size(results) && s == LW_OK; i++) {
        const json_t *r = json_array_get(results, i);
        linkage = json_object_get(r, "linkage");
        s = json_is_object(linkage) ? add_one(j, linkage, r, v)
            : lw_error_at(&j->e, LW_E_NOTATION, j->file, j->line, 0, "result %zu has no linkage", i + 1);
    }
    return s;
}

static lw_status add_text(job *j, const char *text, size_t size)
{
    size_t at = 0;
    lw_status s = LW_OK;
    j->line = 1;
    while (s == LW_OK) {
        for (; at < size && text[at] && strchr(" \t\r\n", text[at]); at++)
            j->line += text[at] == '\n';
        if (at == size)
            break;
        json_error_t fault;
        json_t *v;
        s = lw_json_load(text + at, size - at, JSON_DISABLE_EOF_CHECK | JSON_REJECT_DUPLICATES, &v, &fault);
        if (s == LW_E_MEMORY)
            return lw_error_set(&j->e, s, "out of memory");
        if (s != LW_OK)
            return lw_error_at(&j->e, LW_E_NOTATION, j->file, j->line + fault.line - 1, fault.column, "%s", fault.text);
        s = add_value(j, v);
        json_decref(v);
        for (size_t end = at + (size_t)fault.position; at < end && at < size; at++)
            j->line += text[at] == '\n';
    }
    return s;
}

/* ---- the whole ---------------------------------------------------------------------------------------- */

/* Commit what was added, also if the work was stopped; after a failure roll the transaction back. */
static lw_status finish(job *j, lw_status s)
{
    if (s < 0) {
        lw_build_rollback(&j->transaction);
        return s;
    }
    if (s == LW_OK && j->run && open_transaction(j) == LW_OK)
        s = lw_store_run_end(j->transaction.store, &j->e);
    lw_status t = lw_build_commit(&j->transaction, &j->e);
    return t == LW_OK ? s : t;
}

lw_status lw_build_linkages(lw_store *s, const char *file, const char *text, size_t size,
                            const lw_build_control *control, lw_build_counts *counts, lw_error *e)
{
    *counts = (lw_build_counts){ 0 };
    job *j = calloc(1, sizeof *j);
    if (!j)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    *j = (job){ .file = file, .control = control, .counts = counts,
                .transaction = { .store = s, .commit = control->commit } };
    lw_status status = lw_build_fault(finish(j, add_text(j, text, size)), &j->e, e);
    free(j);
    return status;
}
