/* cli/motion/clearance.c - laws and speeds of a sweep, run side by side. */
#include "cli/motion/clearance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/parallel.h"
#include "base/suggest.h"
#include "cli/program/progress.h"
#include "mbs/dynamics/contact.h"

/* ---- lists --------------------------------------------------------------------------------------- */

static lw_status add(double **list, int *n, double v, const char *name, lw_error *e)
{
    if (*n == CLI_CLEARANCE_LIST_MAX)
        return lw_error_set(e, LW_E_ARG, "--%s lists more than %d numbers", name, CLI_CLEARANCE_LIST_MAX);
    if ((*n & (*n - 1)) == 0) {                      /* room doubles */
        double *more = realloc(*list, sizeof **list*(size_t)(*n ? 2**n : 1));
        if (!more)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        *list = more;
    }
    (*list)[(*n)++] = v;
    return LW_OK;
}

static lw_status add_range(double **list, int *n, const double v[3], const char *name, const char *text, lw_error *e)
{
    double count = (v[1] - v[0])/v[2];
    if (!(count >= 0) || count > CLI_CLEARANCE_LIST_MAX)
        return lw_error_set(e, LW_E_ARG, "--%s: '%s' is no range FROM:TO:STEP of at most %d numbers", name, text,
                            CLI_CLEARANCE_LIST_MAX);
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i <= (int)floor(count + 1e-9); i++)
        s = add(list, n, v[0] + i*v[2], name, e);
    return s;
}

/* One item: a number or FROM:TO:STEP */
static lw_status add_item(double **list, int *n, char *item, const char *name, lw_error *e)
{
    static const cli_option real = { .kind = CLI_REAL };
    double v[3];
    int parts = 0;
    char whole[128];
    snprintf(whole, sizeof whole, "%s", item);
    for (char *p = item; p; parts++) {
        char *colon = strchr(p, ':');
        if (colon)
            *colon++ = 0;
        lw_status s = parts < 3 ? cli_value(&real, name, p, &v[parts], e)
                    : lw_error_set(e, LW_E_ARG, "--%s: '%s' has too many colons; a range is FROM:TO:STEP", name, whole);
        if (s != LW_OK)
            return s;
        p = colon;
    }
    if (parts == 2)
        return lw_error_set(e, LW_E_ARG, "--%s: '%s' lacks a step; a range is FROM:TO:STEP", name, whole);
    return parts == 1 ? add(list, n, v[0], name, e) : add_range(list, n, v, name, whole, e);
}

lw_status cli_clearance_list(const char *name, const char *text, double **list, int *n, lw_error *e)
{
    lw_status s = LW_OK;
    char *copy = strdup(text), *p = copy;
    *list = NULL;
    *n = 0;
    if (!copy)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    while (s == LW_OK && p) {
        char *comma = strchr(p, ',');
        if (comma)
            *comma++ = 0;
        s = add_item(list, n, p, name, e);
        p = comma;
    }
    free(copy);
    if (s != LW_OK) {
        free(*list);
        *list = NULL;
    }
    return s;
}

static lw_status list_models(const char *text, lw_clearance_model *list, int *n, lw_error *e)
{
    static const char *const names[] = { "zero", "link", "mlsd", "impact", "hunt-crossley", "lankarani-nikravesh" };
    const int n_name = (int)(sizeof names/sizeof *names);
    *n = 0;
    for (const char *p = text; p; ) {
        size_t size = strcspn(p, ",");
        char word[32];
        snprintf(word, sizeof word, "%.*s", (int)(size < 31 ? size : 31), p);
        lw_clearance_model m = lw_clearance_named(word);
        const char *near = lw_suggest(word, names, n_name);
        if (m == LW_CLEARANCE_NONE)
            return lw_error_set(e, LW_E_ARG, "--model: there is no model of clearance '%s'; %s%s", word,
                                near ? "did you mean " : "they are zero, link, mlsd, impact, hunt-crossley, "
                                "lankarani-nikravesh", near ? near : "");
        if (*n == n_name)
            return lw_error_set(e, LW_E_ARG, "--model lists more than %d models", n_name);
        list[(*n)++] = m;
        p = p[size] ? p + size + 1 : NULL;
    }
    return LW_OK;
}

/* ---- laws ---------------------------------------------------------------------------------------- */

/* A law: the model with every joint's clearance as asked; NAN: as the file has it. */
static lw_status make_law(const cli_clearance *c, cli_clearance_law *l, lw_error *e)
{
    l->m = malloc(sizeof *l->m);
    if (!l->m)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    *l->m = *c->model;
    bool any = false;
    for (int j = 0; j < l->m->linkage.n_joint; j++) {
        lw_clearance *p = &l->m->clearance[j];
        if (p->model == LW_CLEARANCE_NONE)
            continue;
        p->model = l->model != LW_CLEARANCE_NONE ? l->model : p->model;
        p->stiffness = isnan(l->stiffness) ? p->stiffness : l->stiffness;
        p->damping = isnan(l->damping) ? p->damping : l->damping;
        if (!any) {                                  /* what the table says of this law */
            l->model = p->model;
            l->stiffness = p->stiffness;
            l->damping = p->damping;
        }
        any = true;
    }
    return lw_clearance_make(l->m, &l->scene, e);
}

static lw_status make_laws(cli_clearance *c, const lw_clearance_model *model, int n_model, const double *stiffness,
                           int n_stiffness, const double *damping, int n_damping, lw_error *e)
{
    c->law = calloc((size_t)n_model*(size_t)n_stiffness*(size_t)n_damping, sizeof *c->law);
    if (!c->law)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status s = LW_OK;
    for (int m = 0; m < n_model; m++)
        for (int k = 0; k < n_stiffness; k++)
            for (int d = 0; s == LW_OK && d < n_damping; d++) {
                cli_clearance_law *l = &c->law[c->n_law++];
                *l = (cli_clearance_law){ .model = model[m], .stiffness = stiffness[k], .damping = damping[d] };
                s = make_law(c, l, e);
            }
    return s;
}

static lw_status positive(const double *v, int n, bool zero, const char *name, lw_error *e)
{
    for (int i = 0; i < n; i++)
        if (!(v[i] > 0 || (zero && v[i] == 0)))
            return lw_error_set(e, LW_E_ARG, "--%s: %g is out of range: %s", name, v[i], zero ? "0 or "
                                "more" : "above 0");
    return LW_OK;
}

/* A list of an option, or the one number NAN that stands for what the file says */
static lw_status option_list(const char *name, const char *text, bool zero, double **list, int *n, lw_error *e)
{
    static const double none = NAN;
    if (text) {
        lw_status s = cli_clearance_list(name, text, list, n, e);
        return s == LW_OK ? positive(*list, *n, zero, name, e) : s;
    }
    *n = 0;
    *list = NULL;
    return add(list, n, none, name, e);
}

lw_status cli_clearance_make(cli_clearance *c, const char *models, const char *stiffness, const char *damping,
                             const char *speeds, lw_error *e)
{
    lw_clearance_model model[8] = { LW_CLEARANCE_NONE };
    int n_model = 1, n_k = 0, n_d = 0;
    double *k = NULL, *d = NULL;
    lw_status s = models ? list_models(models, model, &n_model, e) : LW_OK;
    if (s == LW_OK)
        s = option_list("stiffness", stiffness, false, &k, &n_k, e);
    if (s == LW_OK)
        s = option_list("damping", damping, true, &d, &n_d, e);
    if (s == LW_OK && speeds)
        s = cli_clearance_list("speed", speeds, &c->speed, &c->n_speed, e);
    else if (s == LW_OK)
        s = add(&c->speed, &c->n_speed, c->model->has_speed[0] ? c->model->speed[0]/c->unit_size : 0, "speed", e);
    if (s == LW_OK && (long)n_model*n_k*n_d*c->n_speed > 1000000)
        s = lw_error_set(e, LW_E_ARG, "the lists make more than 1000000 runs");
    if (s == LW_OK)
        s = make_laws(c, model, n_model, k, n_k, d, n_d, e);
    free(k);
    free(d);
    if (s != LW_OK)
        return s;
    c->n_row = c->n_law*c->n_speed;
    c->row = calloc((size_t)c->n_row, sizeof *c->row);
    c->limit = calloc((size_t)c->n_law*LW_CLEARANCE_JOINT_MAX, sizeof *c->limit);
    if (!c->row || !c->limit)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < c->n_row; i++)
        c->row[i] = (cli_clearance_row){ .law = i/c->n_speed, .speed = c->speed[i%c->n_speed] };
    return LW_OK;
}

void cli_clearance_free(cli_clearance *c)
{
    for (int i = 0; i < c->n_law; i++) {
        lw_clearance_free(c->law[i].scene);
        free(c->law[i].m);                           /* what it points to is the first model's */
    }
    for (int i = 0; c->row && i < c->n_row; i++)
        free(c->row[i].pass);
    free(c->law);
    free(c->row);
    free(c->limit);
    free(c->speed);
}

/* ---- runs ---------------------------------------------------------------------------------------- */

static bool out_of_time(const cli_clearance *c)
{
    return cli_interrupted() || (c->until > 0 && lw_clock_wall() > c->until);
}

typedef struct passer { cli_clearance_row *row; double settle; } passer;

static lw_status keep_pass(void *context, const lw_clearance_sample *s)
{
    passer *p = context;
    cli_clearance_row *r = p->row;
    if (s->t < p->settle || s->n_point == 0)
        return LW_OK;
    if (r->n_pass == r->room_pass) {
        int room = 2*r->room_pass + 16;
        cli_clearance_pass *more = realloc(r->pass, (size_t)room*sizeof *more);
        if (!more)
            return LW_E_MEMORY;
        r->pass = more;
        r->room_pass = room;
    }
    const lw_clearance_point *at = &s->point[0];
    double turn = atan2(at->in_bush.y, at->in_bush.x)*180/LW_PI;
    r->pass[r->n_pass++] = (cli_clearance_pass){ turn, at->force, at->touching };
    return LW_OK;
}

static void run_row(const cli_clearance *c, cli_clearance_row *row)
{
    lw_clearance_options o = c->o;
    passer p = { row, o.settle };
    if (c->passes)
        o.strobe = keep_pass, o.context = &p;
    lw_error e = { 0 };
    if (out_of_time(c))
        return;
    o.speed = c->model->motion[0] ? NAN : row->speed*c->unit_size;
    row->status = lw_clearance_run(c->law[row->law].scene, &o, &row->r, &e);
    snprintf(row->why, sizeof row->why, "%.255s", row->status == LW_OK ? "" : e.text);
    row->done = row->status != LW_STOPPED || !out_of_time(c);    /* a run cut short is no result */
}

typedef struct work { cli_clearance *c; cli_progress progress; int n_done; } work;

static void run_job(void *context, size_t job, int thread)
{
    work *w = context;
    run_row(w->c, &w->c->row[job]);
    int n = __atomic_add_fetch(&w->n_done, 1, __ATOMIC_RELAXED);
    if (thread == 0)
        cli_progress_show(&w->progress, n, w->c->n_row, NULL);
}

static bool is_lost(const cli_clearance_row *r, int joint) { return r->r.joint[joint].lost; }

/* Rows of one law that ran, slow ones first, whichever way they turn */
static int by_speed(const void *a, const void *b)
{
    const cli_clearance_row *const *x = a, *const *y = b;
    double u = fabs((*x)->speed), v = fabs((*y)->speed);
    return (u > v) - (u < v);
}

static void find_limit(const cli_clearance *c, int law, int joint, cli_clearance_row **sorted,
                       cli_clearance_limit *l)
{
    int n = 0;
    for (int i = law*c->n_speed; i < (law + 1)*c->n_speed; i++)
        if (c->row[i].done && c->row[i].status == LW_OK)
            sorted[n++] = &c->row[i];
    qsort(sorted, (size_t)n, sizeof *sorted, by_speed);
    *l = (cli_clearance_limit){ law, joint, NAN, NAN, NAN, NAN, 0, n };
    for (int i = 0; i < n; i++) {
        bool lost = is_lost(sorted[i], joint), before = i > 0 && is_lost(sorted[i - 1], joint);
        l->n_lost += lost;
        if (i > 0 && lost && !before && isnan(l->lost)) {
            l->kept = sorted[i - 1]->speed;
            l->lost = sorted[i]->speed;
        }
        if (i > 0 && !lost && before) {
            l->lost_again = sorted[i - 1]->speed;
            l->kept_again = sorted[i]->speed;
        }
    }
    if (n > 0 && is_lost(sorted[n - 1], joint))
        l->lost_again = l->kept_again = NAN;         /* not regular at the top: no upper limit here */
}

/* Halve the interval between two speeds of which one keeps contact and one does not. */
static void refine(const cli_clearance *c, int law, int joint, double *kept, double *lost)
{
    cli_clearance_row row = { .law = law };
    while (fabs(*lost - *kept) > c->refine && !out_of_time(c)) {
        row.speed = 0.5*(*kept + *lost);
        if (row.speed == *kept || row.speed == *lost)
            break;
        run_row(c, &row);
        if (!row.done || row.status != LW_OK)
            break;
        *(is_lost(&row, joint) ? lost : kept) = row.speed;
    }
    free(row.pass);
}

static void refine_job(void *context, size_t job, int thread)
{
    cli_clearance *c = context;
    cli_clearance_limit *l = &c->limit[job/2];
    (void)thread;
    if (job%2 == 0 && !isnan(l->lost))
        refine(c, l->law, l->joint, &l->kept, &l->lost);
    if (job%2 == 1 && !isnan(l->kept_again))
        refine(c, l->law, l->joint, &l->kept_again, &l->lost_again);
}

lw_status cli_clearance_run(cli_clearance *c, lw_error *e)
{
    int jobs = c->call->common.jobs;
    work w = { c, cli_progress_begin(c->call, "clearance", "runs"), 0 };
    lw_status s = lw_parallel(jobs, (size_t)c->n_row, run_job, &w);
    cli_progress_end(&w.progress);
    cli_clearance_row **sorted = malloc(sizeof *sorted*(size_t)(c->n_speed + 1));
    if (s != LW_OK || !sorted) {
        free(sorted);
        return lw_error_set(e, s != LW_OK ? s : LW_E_MEMORY, "the runs cannot be started: out of memory");
    }
    int n_joint = 0;
    for (int i = 0; i < c->n_row; i++)
        n_joint = c->row[i].done && c->row[i].r.n_joint > n_joint ? c->row[i].r.n_joint : n_joint;
    for (int law = 0; law < c->n_law; law++)
        for (int joint = 0; joint < n_joint; joint++)
            find_limit(c, law, joint, sorted, &c->limit[c->n_limit++]);
    free(sorted);
    return c->refine > 0 ? lw_parallel(jobs, 2*(size_t)c->n_limit, refine_job, c) : LW_OK;
}
