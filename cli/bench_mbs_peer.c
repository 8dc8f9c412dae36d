/* cli/bench_mbs_peer.c - the same scene in other programs: written as lines of text, run by a small program linked to each
 * (tests/bench/peer_*), its places read back and judged like ours. */
#include "cli/bench_mbs.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/number.h"
#include "mbs/dynamics.h"

static const struct { const char *title, *program; } peers[] = {
    { "Simbody", "peer_simbody" }, { "MuJoCo", "peer_mujoco" } };

/* ---- the scene --------------------------------------------------------------------------------------------------- */

static void put(FILE *f, const char *word, int n, const double *number)
{
    char text[LW_NUMBER_SIZE];
    fputs(word, f);
    for (int i = 0; i < n; i++) {
        lw_number_print(number[i], text);
        fprintf(f, " %s", text);
    }
    fputc('\n', f);
}

static void put_bodies(const lw_model *m, const lw_system *s, const double *v, FILE *f)
{
    for (int b = 0; b < s->n_body; b++) {
        const lw_body *body = &m->body[s->link[b]];
        double n[] = { body->mass, body->inertia, body->centre.x, body->centre.y, v[3*b]*s->unit, v[3*b + 1]*s->unit,
                       v[3*b + 2] };
        put(f, "body", 7, n);
    }
}

/* Constant torque of one force; NAN when there is more to it. */
static double torque_of(const lw_force *force)
{
    return force->fx || force->fy || !force->torque ? NAN : lw_expression_value(force->torque, NULL);
}

/* "body mass inertia x y vx vy omega"; "pin body body x y"; "spring body body x y x y stiffness free"; "torque body value";
 * "gravity x y"; "run end moments seconds".  Bodies count from 1; 0 is the ground.  LW_E_KIND: the model has more. */
static lw_status put_scene(const lw_model *m, const lw_system *s, const double *v, double to, int moments, double seconds,
                           FILE *f)
{
    put(f, "gravity", 2, (double[]){ m->gravity.x, m->gravity.y });
    put_bodies(m, s, v, f);
    for (int j = 0; j < m->linkage.n_joint; j++) {
        const lw_joint *joint = &m->linkage.joint[j];
        if (joint->kind != LW_JOINT_REVOLUTE)
            return LW_E_KIND;
        put(f, "pin", 4, (double[]){ s->body[joint->link[0]] + 1, s->body[joint->link[1]] + 1, joint->at.x, joint->at.y });
    }
    for (int i = 0; i < m->n_spring; i++) {
        const lw_spring *p = &m->spring[i];
        put(f, "spring", 8, (double[]){ s->body[p->link[0]] + 1, s->body[p->link[1]] + 1, p->at[0].x, p->at[0].y, p->at[1].x,
                                        p->at[1].y, p->stiffness, p->free });
    }
    for (int i = 0; i < m->n_force; i++) {
        double torque = torque_of(&m->force[i]);
        if (isnan(torque))
            return LW_E_KIND;
        put(f, "torque", 2, (double[]){ s->body[m->force[i].link] + 1, torque });
    }
    put(f, "run", 3, (double[]){ to, moments, seconds });
    return LW_OK;
}

/* ---- its rows ------------------------------------------------------------------------------------------------------ */

/* "run solver tolerance seconds steps evaluations", then a line of places a moment; "fail solver tolerance why". */
static lw_status read_rows(cli_mbs *b, const cli_mbs_problem *p, const cli_mbs_reference *r, int n_body, FILE *f)
{
    char line[8192], solver[40], why[150];
    cli_mbs_motion motion = { r->n_row, n_body, malloc(sizeof(double)*3*(size_t)(r->n_row*n_body)) };
    lw_status st = motion.place ? LW_OK : LW_E_MEMORY;
    while (st == LW_OK && fgets(line, sizeof line, f)) {
        double tolerance, seconds;
        long steps, rates;
        if (sscanf(line, "fail %39s %lf %149[^\n]", solver, &tolerance, why) == 3) {
            cli_mbs_row *row = cli_mbs_add(b, p->name, solver, tolerance);
            if (row)
                snprintf(row->note, sizeof row->note, "%s", why);
            st = row ? LW_OK : LW_E_MEMORY;
            continue;
        }
        if (sscanf(line, "run %39s %lf %lf %ld %ld", solver, &tolerance, &seconds, &steps, &rates) != 5)
            continue;
        for (int i = 0; i < 3*r->n_row*n_body && st == LW_OK; i++)
            st = fscanf(f, "%lf", &motion.place[i]) == 1 ? LW_OK : LW_E_NOTATION;
        cli_mbs_row *row = st == LW_OK ? cli_mbs_add(b, p->name, solver, tolerance) : NULL;
        if (!row)
            continue;
        row->seconds = seconds;
        row->error = p->measure(&motion, r, &row->off);
        row->steps = steps;
        row->rates = rates;
    }
    free(motion.place);
    return st;
}

static void program_path(const char *name, char *path, size_t size)
{
    char program[512];
    ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    program[n > 0 ? n : 0] = 0;
    char *slash = strrchr(program, '/');
    if (slash)
        *slash = 0;
    snprintf(path, size, "%s/tests/bench/%s", program, name);
}

static void miss(cli_mbs *b, const char *title, const char *path)
{
    size_t used = strlen(b->missing);
    if (!strstr(b->missing, title))
        snprintf(b->missing + used, sizeof b->missing - used, "%s %s (no %s)", used ? "," : "", title, path);
}

static lw_status run_peers(cli_mbs *b, const cli_mbs_problem *p, const cli_mbs_reference *r, int n_body, const char *scene)
{
    lw_status st = LW_OK;
    for (size_t i = 0; i < sizeof peers/sizeof *peers && st == LW_OK && !cli_interrupted(); i++) {
        char path[640], command[1600];
        program_path(peers[i].program, path, sizeof path);
        snprintf(command, sizeof command, "'%s' < '%s'", path, scene);
        FILE *f = access(path, X_OK) == 0 && !strchr(path, '\'') ? popen(command, "r") : NULL;
        if (!f) {
            miss(b, peers[i].title, path);
            continue;
        }
        st = read_rows(b, p, r, n_body, f);
        if (pclose(f) != 0)
            miss(b, peers[i].title, "end of its run");
    }
    return st;
}

lw_status cli_mbs_peers(cli_mbs *b, const cli_mbs_problem *p, const lw_model *m, const cli_mbs_reference *r, lw_error *e)
{
    char scene[] = "/tmp/linkwright-scene-XXXXXX";
    double q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX];
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    lw_status st = lw_dynamics_make(m, &o, &d, e);
    if (st != LW_OK)
        return st;
    int file = mkstemp(scene);
    FILE *f = file >= 0 ? fdopen(file, "w") : NULL;
    lw_dynamics_start(d, q, v);
    st = f ? put_scene(m, lw_dynamics_system(d), v, p->to, r->n_row, b->time, f)
           : lw_error_at(e, LW_E_IO, scene, 0, 0, "cannot be written: %s", strerror(errno));
    if (f && fclose(f) != 0)
        st = lw_error_at(e, LW_E_IO, scene, 0, 0, "cannot be written: %s", strerror(errno));
    if (st == LW_OK)
        st = run_peers(b, p, r, lw_dynamics_system(d)->n_body, scene);
    if (file >= 0)
        remove(scene);
    lw_dynamics_free(d);
    if (st == LW_E_NOTATION)
        lw_error_set(e, st, "a peer's rows cannot be read");
    return st == LW_E_KIND ? LW_OK : st;                   /* a scene that peers are not given                    */
}
