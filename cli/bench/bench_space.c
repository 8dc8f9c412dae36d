/* Problems of `linkwright bench mbs` in space: one row for each formulation and tolerance.  Reference: order 8 at
 * 1e-14. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/real.h"
#include "cli/bench/bench_mbs.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"

enum { REPEAT_MAX = 50, MOMENTS = 20 };

static const double give_up = 20;             /* [s] for one run */

/* A chain of n bars of 0.1 m and 0.1 kg, the first hinged to the ground, level at the start; hinges across it in turn
 * along y and z. */
static lw_status make_chain(int n, lw_spatial *m, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    fputs("{\"linkwright\": 1, \"gravity\": [0, 0, -9.81],\n\"links\": [\"b0\"", f);
    for (int i = 1; i <= n; i++)
        fprintf(f, ",\n{\"name\": \"b%d\", \"mass\": 0.1, \"centre\": [%.17g, 0, 0], \"inertia\": [2e-6, 1e-4, 1e-4]}",
                i, 0.1*i - 0.05);
    fputs("],\n\"ground\": \"b0\", \"joints\": [", f);
    for (int i = 1; i <= n; i++)
        fprintf(f, "%s\n{\"name\": \"J%d\", \"links\": [\"b%d\", \"b%d\"], \"at\": [%.17g, 0, 0], \"axis\": [0, %d, "
                   "%d]}", i > 1 ? "," : "",
                i, i - 1, i, 0.1*(i - 1), i%2, 1 - i%2);
    fprintf(f, "],\n\"tracers\": [{\"name\": \"P\", \"link\": \"b%d\", \"at\": [%.17g, 0, 0]}]}\n", n, 0.1*n);
    bool bad = ferror(f) != 0;
    bad = fclose(f) != 0 || bad;
    lw_status st = bad ? lw_error_set(e, LW_E_MEMORY, "out of memory") : lw_spatial_read(text, size, "chain", m, e);
    free(text);
    return st;
}

static lw_status read_model(const char *name, lw_spatial *m, lw_error *e)
{
    char path[CLI_PATH_SIZE], *text = NULL;
    size_t size;
    lw_status st = cli_mbs_read(name, "json", path, &text, &size, e);
    if (st == LW_OK)
        st = lw_spatial_read(text, size, path, m, e);
    free(text);
    return st;
}

typedef struct places { lw_dynamics *d; int n; lw_vec3 at[MOMENTS + 1]; } places;

static lw_status keep(void *context, const lw_moment *m)
{
    places *p = context;
    lw_space_moment all;
    lw_error e;
    if (!p->d)
        return LW_OK;
    lw_status st = lw_dynamics_space_moment(p->d, m, &all, &e);
    p->at[p->n++] = lw_space_point_at(all.frame, lw_dynamics_space(p->d)->tracer[0]);
    return st;
}

static lw_status run_once(const lw_spatial *m, const lw_dynamics_options *o, places *p, cli_mbs_row *row, lw_error *e)
{
    lw_dynamics *d;
    lw_dynamics_report q;
    double start = lw_clock_cpu();
    lw_status st = lw_dynamics_make_spatial(m, o, &d, e);
    double made = lw_clock_cpu();
    if (st != LW_OK)
        return st;
    p->d = row ? NULL : d;
    p->n = 0;
    st = lw_dynamics_run(d, keep, p, &q, e);
    st = st == LW_OK ? cli_mbs_own(&q, o, e) : st;
    if (row) {
        row->make = fmin(row->make, made - start);
        row->seconds = fmin(row->seconds, lw_clock_cpu() - made);
        row->energy = q.energy_error/q.energy_scale;
        row->steps = q.steps;
        row->rates = q.rates;
    }
    lw_dynamics_free(d);
    return st;
}

static lw_status one_row(cli_mbs *b, const cli_mbs_problem *p, const lw_spatial *m, lw_formulation f,
                         double tolerance,
                         const places *exact, bool *slow)
{
    cli_mbs_row *row = cli_mbs_add(b, p->name, lw_formulation_name(f), tolerance);
    lw_error e = { 0 };
    places got;
    if (!row)
        return LW_E_MEMORY;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.formulation = f;
    o.to = p->to;
    o.intervals = MOMENTS;
    o.relative = o.absolute = tolerance;
    o.stop = cli_stop_flag();
    o.until = lw_clock_wall() + give_up;
    lw_status st = run_once(m, &o, &got, NULL, &e);
    if (st == LW_OK) {
        row->error = 0;
        for (int i = 0; i <= MOMENTS; i++)
            row->error = fmax(row->error, lw_v3_norm(lw_v3_sub(got.at[i], exact->at[i])));
    }
    o.intervals = 1;
    double until = lw_clock_wall() + b->time;
    for (int i = 0; i < REPEAT_MAX && st == LW_OK && (i == 0 || lw_clock_wall() < until) && !cli_interrupted(); i++)
        st = run_once(m, &o, &got, row, &e);
    if (st != LW_OK) {
        row->error = row->energy = NAN;
        snprintf(row->note, sizeof row->note, "%.150s", e.text);
        row->note[strcspn(row->note, "\n")] = 0;
    }
    *slow = st != LW_OK || row->seconds > CLI_MBS_TOO_SLOW;
    return LW_OK;
}

/* ---- inverse dynamics ------------------------------------------------------------------------------------------ */

typedef struct torques { lw_dynamics *d; int n, every; lw_vec3 at[CLI_MBS_POSTURES]; cli_mbs_cycle cycle; } torques;

static lw_status keep_torques(void *context, const lw_moment *m)
{
    torques *p = context;
    lw_space_moment all;
    lw_error e;
    lw_status st = lw_dynamics_space_moment(p->d, m, &all, &e);
    int k = p->n++/p->every;
    if (st != LW_OK || (p->n - 1)%p->every)
        return st;
    p->at[k] = lw_v3(all.drive[0], all.drive[1], all.drive[2]);
    const lw_space *s = lw_dynamics_space(p->d);
    for (int i = 0; i < 3 && p->every > 1; i++) {
        lw_spatial_measure of = s->model->drive[i];
        double *to = p->cycle.at[k][i], none;
        lw_space_measured(s, all.frame, of, 0, m->v, &to[0], &to[1]);
        lw_space_measured(s, all.frame, of, 0, m->a, &none, &to[2]);
        to[2] += lw_space_scale(s, of)*lw_space_measure_bias(s, all.frame, of, m->v);
    }
    return LW_OK;
}

/* One run through the cycle; every: of its postures is kept. */
static lw_status run_cycle(const cli_mbs_problem *p, const lw_spatial *m, int every, torques *to, double *make, double *seconds, lw_error *e)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics_report q;
    o.to = p->to, o.intervals = every*(CLI_MBS_POSTURES - 1);
    to->n = 0, to->every = every;
    double start = lw_clock_cpu();
    lw_status st = lw_dynamics_make_spatial(m, &o, &to->d, e);
    double made = lw_clock_cpu();
    if (st != LW_OK)
        return st;
    st = lw_dynamics_run(to->d, keep_torques, to, &q, e);
    *make = made - start, *seconds = lw_clock_cpu() - made;
    lw_dynamics_free(to->d);
    return st;
}

/* The torques of one run against those of twice as many postures, whose closures are others. */
static lw_status inverse_rows(cli_mbs *b, const cli_mbs_problem *p, const lw_spatial *m, lw_error *e)
{
    torques exact, got;
    double make, seconds, until;
    lw_status st = m->n_drive != 3 ? lw_error_set(e, LW_E_ARG, "\"%s\" has not three drives", p->name)
                                   : run_cycle(p, m, 2, &exact, &make, &seconds, e);
    cli_mbs_row *row = st == LW_OK ? cli_mbs_add(b, p->name, lw_formulation_name(LW_FORMULATION_DRIVEN), 1e-12) : NULL;
    until = lw_clock_wall() + b->time;
    for (int i = 0; i < REPEAT_MAX && row && st == LW_OK && (i == 0 || lw_clock_wall() < until) && !cli_interrupted(); i++) {
        st = run_cycle(p, m, 1, &got, &make, &seconds, e);
        row->make = fmin(row->make, make), row->seconds = fmin(row->seconds, seconds);
        row->steps = row->rates = CLI_MBS_POSTURES, row->error = 0;
        for (int k = 0; st == LW_OK && k < CLI_MBS_POSTURES; k++)
            row->error = fmax(row->error, lw_v3_norm(lw_v3_sub(got.at[k], exact.at[k])));
    }
    cli_mbs_reference r = { CLI_MBS_POSTURES, 3, &exact.at[0].x };
    return st == LW_OK && row ? cli_mbs_peers_space(b, p, m, &exact.cycle, &r, e) : st == LW_OK ? LW_E_MEMORY : st;
}

lw_status cli_mbs_space(cli_mbs *b, const cli_mbs_problem *p, lw_error *e)
{
    static const lw_formulation every[] = { LW_FORMULATION_RECURSIVE, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_RADAU };
    lw_spatial m;
    places exact;
    lw_status st = p->n_loop > 0 ? make_chain(p->n_loop, &m, e) : read_model(p->name, &m, e);
    if (st != LW_OK)
        return st;
    if (p->n_loop < 0) {
        st = inverse_rows(b, p, &m, e);
        lw_spatial_free(&m);
        return st;
    }
    lw_dynamics_options o = { .formulation = LW_FORMULATION_INDEX1, .to = p->to, .intervals = MOMENTS, .stop = cli_stop_flag() };
    o.relative = o.absolute = p->n_loop ? 1e-13 : 1e-14;
    st = run_once(&m, &o, &exact, NULL, e);
    for (int f = 0; f < 4 && st == LW_OK; f++) {
        bool slow = false;
        for (int k = b->loosest; k <= b->tightest && k <= p->implicit && !slow && st == LW_OK
             && !cli_interrupted(); k++)
            st = one_row(b, p, &m, every[f], pow(10, -k), &exact, &slow);
    }
    cli_mbs_reference r = { MOMENTS + 1, 3, &exact.at[0].x };
    _Static_assert(sizeof exact.at[0] == 3*sizeof(double), "places are three numbers each");
    if (st == LW_OK)
        st = cli_mbs_peers_space(b, p, &m, NULL, &r, e);
    lw_spatial_free(&m);
    return st;
}
