/* studio/search.c - searches for linkages in threads of their own; the coupler curves nearest to a drawing. */
#include "studio/studio_internal.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include "base/clock.h"
#include "base/file.h"
#include "base/real.h"
#include "linkwright.h"
#include "optimise/task/task_file.h"

#define WAIT       10.0            /* a question for news waits so long for them [s]           */
#define FORGOTTEN  60.0            /* a search that no page asks about ends after this [s]     */
enum { KEPT = 16, ATLAS_CURVES = 40000 };

typedef struct studio_search {
    struct studio_search *next;
    int             id;
    studio         *s;
    pthread_t       thread;
    bool            over;
    volatile int    stop;
    long            version;             /* rises with every change                               */
    double          asked;               /* clock of the last question for news                   */
    double          done, seconds;
    lw_status       status;
    lw_error        error;
    lw_bytes        history;             /* seconds,error,seconds,error,...                        */
    lw_bytes        best, results;       /* a linkage; the elements of a list                      */
    double          unit;                /* [m]                                                    */
    size_t          n_station;
    char            types[128];
    lw_task_file   *task;
    lw_target      *target;
    lw_linkage     *start;
    lw_fit_request  request;
} studio_search;

/* ---- what is asked for ------------------------------------------------------------------------------------------ */

typedef enum option_kind { FLAG, NUMBER, WORD } option_kind;

/* Options beside the task file; `command` is that of linkwright fit. */
static const struct { const char *key, *command; option_kind kind; } options[] = {
    { "types", "--type", WORD },                { "crank_only", "--crank-only", FLAG },
    { "max_size", "--max-size", NUMBER },       { "through_limits", "--through-limits", FLAG },
    { "unlimited", "--unlimited", FLAG },       { "seed", "--seed", NUMBER },
    { "results", "--results", NUMBER },         { "budget", "--budget", NUMBER },
    { "rounds", "--rounds", NUMBER },
};

static void read_options(const json_t *ask, studio_search *q)
{
    lw_fit_request *r = &q->request;
    snprintf(q->types, sizeof q->types, "%s", studio_text(ask, "types", r->types));
    r->types = q->types;
    r->crank_only = studio_bool(ask, "crank_only");
    r->full_turn = r->full_turn || r->crank_only;
    r->max_size = studio_real(ask, "max_size", 0);
    r->through_limits = studio_bool(ask, "through_limits");
    r->unlimited = studio_bool(ask, "unlimited");
    r->seed = (uint64_t)fmax(studio_real(ask, "seed", (double)r->seed), 0);
    r->results = (int)fmin(fmax(studio_real(ask, "results", r->results), 1), 64);
    r->budget = fmin(fmax(studio_real(ask, "budget", r->budget), 1e3), 1e12);
    r->rounds = (int)fmin(fmax(studio_real(ask, "rounds", r->rounds), 0), 1e5);
}

/* The command that does the same, with the task and the start in files. */
static void put_command(lw_bytes *b, const json_t *ask)
{
    lw_bytes c = { 0 };
    lw_bytes_text(&c, "linkwright fit task.json");
    for (size_t i = 0; i < sizeof options/sizeof *options; i++) {
        const json_t *v = json_object_get(ask, options[i].key);
        bool given = options[i].kind == FLAG ? json_is_true(v) : options[i].kind == NUMBER ? json_is_number(v)
                   : json_is_string(v);
        if (!given)
            continue;
        lw_bytes_text(&c, " ");
        lw_bytes_text(&c, options[i].command);
        if (options[i].kind == NUMBER) {
            lw_bytes_text(&c, " ");
            lw_bytes_number(&c, json_number_value(v), 17);
        } else if (options[i].kind == WORD) {
            lw_bytes_text(&c, " ");
            lw_bytes_text(&c, json_string_value(v));
        }
    }
    if (json_object_get(ask, "start"))
        lw_bytes_text(&c, " --start-from mechanism.json");
    studio_put_text(b, "command", c.failed ? NULL : c.data);
    lw_bytes_free(&c);
}

/* ---- the thread ---------------------------------------------------------------------------------------------------- */

static void tell(studio_search *q)                      /* with the lock */
{
    q->version++;
    pthread_cond_broadcast(&q->s->news);
}

static bool progress(void *context, double done, double seconds, double best)
{
    studio_search *q = context;
    (void)best;
    pthread_mutex_lock(&q->s->lock);
    q->done = done;
    q->seconds = seconds;
    tell(q);
    bool go_on = !q->stop && !q->s->closing && lw_clock_wall() - q->asked < FORGOTTEN;
    pthread_mutex_unlock(&q->s->lock);
    return go_on;
}

static void found(void *context, const lw_linkage *linkage, double objective, double seconds)
{
    studio_search *q = context;
    lw_bytes best = { 0 };
    studio_put_linkage(&best, NULL, LW_VIEW(linkage));
    pthread_mutex_lock(&q->s->lock);
    lw_bytes_free(&q->best);
    q->best = best;
    q->seconds = fmax(q->seconds, seconds);
    if (q->history.size)
        lw_bytes_text(&q->history, ",");
    lw_bytes_number(&q->history, seconds, 5);
    lw_bytes_text(&q->history, ",");
    lw_bytes_number(&q->history, sqrt(objective/((double)q->n_station*q->request.weight_path))/q->unit, 6);
    tell(q);
    pthread_mutex_unlock(&q->s->lock);
}

static void put_result(lw_bytes *b, const lw_results *all, int i, double unit)
{
    lw_result_info f;
    lw_linkage *k = NULL;
    double value;
    if (lw_results_info(all, i, &f) != LW_OK || lw_results_linkage(all, i, &k) != LW_OK)
        return;
    studio_put_key(b, NULL);
    lw_bytes_text(b, "{");
    studio_put_text(b, "title", f.title);
    studio_put_text(b, "class", f.fourbar_class);
    studio_put_real(b, "links", f.links);
    studio_put_real(b, "error_mean", f.error_mean/unit);
    studio_put_real(b, "error_max", f.error_max/unit);
    studio_put_real(b, "error_percent", f.error_percent);
    studio_put_real(b, "stray", f.stray/unit);
    studio_put_real(b, "size", f.size/unit);
    studio_put_real(b, "transmission", f.transmission[0]*180/LW_PI);
    studio_put_bool(b, "turns", f.turns);
    studio_put_bool(b, "verified", f.verified);
    studio_put_text(b, "at_limit", f.at_limit);
    studio_put_key(b, "dimensions");
    lw_bytes_text(b, "{");
    for (int d = 0; lw_results_dimension(all, i, d, &value); d++)
        studio_put_real(b, lw_results_dimension(all, i, d, NULL), value);
    lw_bytes_text(b, "}");
    studio_put_linkage(b, "linkage", LW_VIEW(k));
    lw_bytes_text(b, "}");
    lw_linkage_destroy(k);
}

static void *run(void *context)
{
    studio_search *q = context;
    lw_results *all = NULL;
    lw_error e = { 0 };
    lw_bytes results = { 0 };
    lw_status st = lw_fit_target(q->target, &q->request, &all, &e);
    lw_bytes_text(&results, "[");
    for (int i = 0; all && i < lw_results_count(all); i++)
        put_result(&results, all, i, q->unit);
    lw_bytes_text(&results, "]");
    lw_results_destroy(all);
    pthread_mutex_lock(&q->s->lock);
    q->status = st;
    q->error = e;
    q->results = results;
    q->over = true;
    tell(q);
    pthread_mutex_unlock(&q->s->lock);
    return NULL;
}

static void search_free(studio_search *q)
{
    lw_bytes_free(&q->history);
    lw_bytes_free(&q->best);
    lw_bytes_free(&q->results);
    lw_task_file_destroy(q->task);
    lw_target_destroy(q->target);
    lw_linkage_destroy(q->start);
    free(q);
}

/* Forget the oldest searches that are over.  Called with the lock. */
static void forget(studio *s)
{
    int n = 0;
    for (studio_search **at = &s->search; *at;) {
        studio_search *q = *at;
        if (++n > KEPT && q->over) {
            *at = q->next;
            pthread_join(q->thread, NULL);
            search_free(q);
        } else
            at = &q->next;
    }
}

/* { task, types, ..., start }: begin a search.  The answer has its number and the command that does the same. */
lw_status studio_search_start(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    char *text = NULL;
    size_t size;
    lw_linkage start;
    studio_search *q = calloc(1, sizeof *q);
    if (!q)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status st = studio_source(ask, "task", &text, &size, e);
    if (st == LW_OK)
        st = lw_task_file_parse(text, size, "the task", &q->task, &q->target, e);
    free(text);
    if (st == LW_OK && json_object_get(ask, "start")) {
        st = studio_linkage(ask, "start", &start, e);
        if (st == LW_OK)
            st = lw_linkage_copy(&start, &q->start);
    }
    if (st == LW_OK) {
        q->s = s;
        q->request = lw_task_file_request(q->task);
        read_options(ask, q);
        q->request.jobs = s->jobs;
        q->request.progress = progress;
        q->request.found = found;
        q->request.context = q;
        q->request.n_start = q->start != NULL;
        q->request.start = (const lw_linkage *const *)&q->start;
        q->unit = q->task->units.metre;
        q->n_station = lw_target_n(q->target);
        q->asked = lw_clock_wall();
    }
    if (st == LW_OK && studio_bool(ask, "command_only")) {
        lw_bytes_text(&r->body, "{");
        put_command(&r->body, ask);
        lw_bytes_text(&r->body, "}\n");
        search_free(q);
        return LW_OK;
    }
    if (st == LW_OK) {
        pthread_mutex_lock(&s->lock);
        q->id = ++s->last_search;
        if (pthread_create(&q->thread, NULL, run, q) != 0)
            st = lw_error_set(e, LW_E_MEMORY, "no thread for the search");
        else {
            q->next = s->search;
            s->search = q;
            forget(s);
        }
        pthread_mutex_unlock(&s->lock);
    }
    if (st != LW_OK) {
        search_free(q);
        return st;
    }
    lw_bytes_text(&r->body, "{");
    studio_put_real(&r->body, "id", q->id);
    put_command(&r->body, ask);
    lw_bytes_text(&r->body, "}\n");
    return LW_OK;
}

static studio_search *find(studio *s, const json_t *ask, lw_error *e)     /* with the lock */
{
    int id = (int)fmin(fmax(studio_real(ask, "id", 0), 0), 1e9);
    for (studio_search *q = s->search; q; q = q->next)
        if (q->id == id)
            return q;
    lw_error_set(e, LW_E_ARG, "there is no search %d; the server was started again, or it is long over", id);
    return NULL;
}

static void put_news(lw_bytes *b, const studio_search *q)
{
    const char *state = !q->over ? "running" : q->status == LW_OK ? "done" : q->status == LW_STOPPED ? "stopped"
                      : q->status == LW_NOTHING ? "nothing" : "failed";
    lw_bytes_text(b, "{");
    studio_put_real(b, "version", (double)q->version);
    studio_put_text(b, "state", state);
    studio_put_real(b, "done", q->done);
    studio_put_real(b, "seconds", q->seconds);
    if (q->over && q->status < 0)
        studio_put_text(b, "error", q->error.text);
    studio_put_key(b, "history");
    lw_bytes_text(b, "[");
    lw_bytes_add(b, q->history.data, q->history.size);
    lw_bytes_text(b, "]");
    studio_put_key(b, "best");
    lw_bytes_text(b, q->best.size ? q->best.data : "null");
    if (q->over) {
        studio_put_key(b, "results");
        lw_bytes_text(b, q->results.data ? q->results.data : "[]");
    }
    lw_bytes_text(b, "}\n");
}

/* { id, after }: what happened in a search since version `after`; waits for it. */
lw_status studio_search_news(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    long after = (long)fmin(fmax(studio_real(ask, "after", -1), -1), 1e15);
    struct timespec until;
    lw_status st = LW_OK;
    clock_gettime(CLOCK_MONOTONIC, &until);                 /* a clock that is set does not hold the page up */
    until.tv_sec += (time_t)WAIT;
    pthread_mutex_lock(&s->lock);
    studio_search *q;
    int waited = 0;
    while ((q = find(s, ask, e)) && q->version <= after && !q->over && !s->closing && waited != ETIMEDOUT) {
        q->asked = lw_clock_wall();
        waited = pthread_cond_clockwait(&s->news, &s->lock, CLOCK_MONOTONIC, &until);
    }
    if (q) {
        q->asked = lw_clock_wall();
        put_news(&r->body, q);
    } else
        st = LW_E_ARG;
    pthread_mutex_unlock(&s->lock);
    return st;
}

/* { id }: end a search; it keeps what it found. */
lw_status studio_search_stop(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    pthread_mutex_lock(&s->lock);
    studio_search *q = find(s, ask, e);
    if (q)
        q->stop = 1;
    pthread_mutex_unlock(&s->lock);
    lw_bytes_text(&r->body, "{}\n");
    return q ? LW_OK : LW_E_ARG;
}

void studio_searches_end(studio *s)
{
    while (s->search) {
        studio_search *q = s->search;
        s->search = q->next;
        q->stop = 1;
        pthread_join(q->thread, NULL);
        search_free(q);
    }
}

/* ---- the nearest coupler curves --------------------------------------------------------------------------------- */

static bool atlas_progress(void *context, double done, double seconds, double best)
{
    studio *s = context;
    (void)seconds, (void)best;
    pthread_mutex_lock(&s->lock);
    s->atlas_done = done;
    pthread_mutex_unlock(&s->lock);
    return !s->atlas_stop;
}

/* Make the catalogue beside its place and move it there when it is whole. */
static void *make_atlas(void *context)
{
    studio *s = context;
    lw_output o;
    lw_catalogue *c = NULL;
    lw_catalogue_work work = { .jobs = 1, .seed = 1, .progress = atlas_progress, .context = s };
    lw_output_clean(s->atlas);
    lw_status st = lw_output_open(&o, s->atlas, NULL);
    bool opened = st == LW_OK;
    if (st == LW_OK)
        st = lw_catalogue_open(o.temp, true, 0, &c, NULL);
    if (st == LW_OK)
        st = lw_catalogue_add_curves(c, "fourbar,slidercrank", 4, ATLAS_CURVES, &work, NULL);
    lw_catalogue_close(c);
    bool ready = st == LW_OK && lw_output_commit(&o, NULL) == LW_OK;
    if (opened && st != LW_OK)
        lw_output_abandon(&o);
    pthread_mutex_lock(&s->lock);
    s->atlas_state = ready ? 2 : 0;
    pthread_mutex_unlock(&s->lock);
    return NULL;
}

void studio_atlas_begin(studio *s, bool make)
{
    if (!s->atlas)
        return;
    if (access(s->atlas, R_OK) == 0)
        s->atlas_state = 2;
    else if (make) {
        s->atlas_state = 1;
        s->has_maker = pthread_create(&s->atlas_maker, NULL, make_atlas, s) == 0;
        s->atlas_state = s->has_maker ? s->atlas_state : 0;
    }
}

void studio_atlas_end(studio *s)
{
    s->atlas_stop = 1;
    if (s->has_maker)
        pthread_join(s->atlas_maker, NULL);
}

typedef struct hits { lw_bytes *b; lw_units units; } hits;

static lw_status put_hit(void *context, const lw_catalogue_hit *hit)
{
    hits *all = context;
    lw_linkage *k = NULL;
    lw_status st = lw_linkage_copy(hit->linkage, &k);
    if (st != LW_OK)
        return st;
    k->units = all->units;
    studio_put_key(all->b, NULL);
    lw_bytes_text(all->b, "{");
    studio_put_real(all->b, "distance", hit->distance);
    studio_put_real(all->b, "error", hit->distance_m/all->units.metre);
    studio_put_text(all->b, "family", hit->family);
    studio_put_real(all->b, "turns", hit->turns);
    studio_put_real(all->b, "transmission", hit->transmission*180/LW_PI);
    studio_put_linkage(all->b, "linkage", LW_VIEW(k));
    lw_bytes_text(all->b, "}");
    lw_linkage_destroy(k);
    return LW_OK;
}

static lw_status put_nearest(studio *s, const json_t *ask, lw_target *t, hits *all, lw_error *e)
{
    lw_catalogue *c = NULL;
    lw_catalogue_filter filter = { .turns = studio_bool(ask, "turns"),
                                   .min_transmission = studio_real(ask, "transmission", 0)*LW_PI/180 };
    lw_status st = lw_catalogue_open(s->atlas, false, 0, &c, e);
    if (st == LW_OK)
        st = lw_catalogue_nearest(c, t, &filter, (int)fmin(fmax(studio_real(ask, "count", 6), 1), 50), put_hit, all, e);
    lw_catalogue_close(c);
    return st;
}

/* { x, y, closed, unit, count, turns, transmission }: the coupler curves nearest to the points. */
lw_status studio_nearest(studio *s, const json_t *ask, studio_reply *r, lw_error *e)
{
    const json_t *x = json_object_get(ask, "x"), *y = json_object_get(ask, "y");
    size_t n = json_array_size(x);
    double *v = malloc(sizeof *v*2*(n + 1)), start = lw_clock_wall();
    lw_target *t = NULL;
    hits all = { .b = &r->body, .units = lw_units_si() };
    lw_units_set_length(&all.units, studio_text(ask, "unit", "mm"));
    lw_units_set_angle(&all.units, "deg");
    pthread_mutex_lock(&s->lock);
    int state = s->atlas_state;
    double done = s->atlas_done;
    pthread_mutex_unlock(&s->lock);
    lw_status st = !v ? lw_error_set(e, LW_E_MEMORY, "out of memory") : json_array_size(y) != n || n < 3 || n > 5000
                 ? lw_error_set(e, LW_E_ARG, "the nearest curves need 3 to 5000 points") : LW_OK;
    for (size_t i = 0; st == LW_OK && i < n; i++) {
        v[i] = json_number_value(json_array_get(x, i))*all.units.metre;
        v[n + i] = json_number_value(json_array_get(y, i))*all.units.metre;
    }
    if (st == LW_OK)
        st = lw_target_create(n, v, v + n, NULL, NULL, NULL, studio_bool(ask, "closed"), &t, e);
    lw_bytes_text(&r->body, "{");
    studio_put_real(&r->body, "atlas", state);
    studio_put_real(&r->body, "done", done);
    studio_put_key(&r->body, "hits");
    lw_bytes_text(&r->body, "[");
    if (st == LW_OK && state == 2)
        st = put_nearest(s, ask, t, &all, e);
    lw_bytes_text(&r->body, "]");
    studio_put_real(&r->body, "ms", 1e3*(lw_clock_wall() - start));
    lw_bytes_text(&r->body, "}\n");
    lw_target_destroy(t);
    free(v);
    return st;
}
