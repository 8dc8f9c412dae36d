/* cli/bench/bench_mbs_peer.c - run other programs' solvers in the same benchmark: each reads the scene and answers with
 * rows and positions, which are measured as our own. tests/bench/peer.h defines the lines. */
#include "base/real.h"
#include "cli/bench/bench_mbs.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/export_space.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"

enum { ANSWER_MAX = 64 << 20 };

/* ---- which ---------------------------------------------------------------------------------------------------- */

static bool can_run(const char *path)
{
    struct stat s;
    return stat(path, &s) == 0 && S_ISREG(s.st_mode) && access(path, X_OK) == 0;
}

static int by_name(const void *a, const void *b) { return strcmp(a, b); }

/* Path of the folder with the other programs. folder NULL: "peers" beside this program, which may be missing. */
static lw_status folder_of(const char *folder, char *path, size_t size, lw_error *e)
{
    char program[512];
    struct stat s;
    if (folder) {
        snprintf(path, size, "%s", folder);
        return stat(path, &s) == 0 && S_ISDIR(s.st_mode) ? LW_OK
             : lw_error_at(e, LW_E_IO, folder, 0, 0, "no such folder; --peers takes one with programs, or 'none'");
    }
    ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    program[n > 0 ? n : 0] = 0;
    char *slash = strrchr(program, '/');
    snprintf(path, size, "%.*s/peers", slash ? (int)(slash - program) : 0, program);
    return LW_OK;
}

lw_status cli_mbs_find_peers(cli_mbs *b, const char *folder, lw_error *e)
{
    char in[600];
    b->n_peer = 0;
    if (folder && strcmp(folder, "none") == 0)
        return LW_OK;
    lw_status st = folder_of(folder, in, sizeof in, e);
    DIR *d = st == LW_OK ? opendir(in) : NULL;
    for (struct dirent *f; d && (f = readdir(d)) && b->n_peer < CLI_MBS_PEER_MAX;) {
        char *path = b->peer[b->n_peer];
        int n = snprintf(path, sizeof b->peer[0], "%s/%s", in, f->d_name);
        b->n_peer += n < (int)sizeof b->peer[0] && can_run(path);
    }
    if (d)
        closedir(d);
    qsort(b->peer, (size_t)b->n_peer, sizeof b->peer[0], by_name);
    if (st == LW_OK && folder && b->n_peer == 0)
        return lw_error_at(e, LW_E_IO, folder, 0, 0, "no program in this folder; 'make peers' builds some");
    return st;
}

/* ---- the scene ------------------------------------------------------------------------------------------------ */

static const char *beyond(const lw_model *m)
{
    for (int j = 0; j < m->linkage.n_joint; j++)
        if (!lw_joint_turns(m->linkage.joint[j].kind) || m->friction[j].coefficient > 0 || m->stop[j].has_least
            || m->stop[j].has_greatest || m->clearance[j].model != LW_CLEARANCE_NONE)
            return "joints other than plain pins";
    for (int k = 0; k < m->n_spring; k++)
        if (m->spring[k].law || m->spring[k].damping != 0)
            return "springs that are not linear";
    for (int k = 0, n; k < m->n_force; k++) {
        const int *which;
        n = m->force[k].torque[2] ? lw_expression_variables(m->force[k].torque[2], &which) : 1;
        if (n > 0 || m->force[k].force[0] || m->force[k].force[1])
            return "forces other than constant torques";
    }
    return m->n_joint_spring || m->n_motor ? "springs or motors at joints" : NULL;
}

static void write_bodies(const lw_system *s, const lw_model *m, const double *q, const double *v, FILE *f)
{
    for (int b = 0; b < s->n_body; b++) {
        const lw_body *body = &m->body[s->link[b]];
        lw_vec2 at = lw_system_point(s, b, lw_v2(0, 0), q);
        fprintf(f, "body %.17g %.17g %.17g %.17g %.17g %s\n", body->mass, body->inertia, at.x, at.y, v[3*b + 2],
                m->linkage.link_name[s->link[b]]);
    }
    for (int j = 0; j < m->linkage.n_joint; j++) {
        const lw_joint *p = &m->linkage.joint[j];
        fprintf(f, "pin %d %d %.17g %.17g\n", s->body[p->link[0]] + 1, s->body[p->link[1]] + 1, p->at.x, p->at.y);
    }
}

static void write_loads(const lw_system *s, const lw_model *m, FILE *f)
{
    fprintf(f, "gravity %.17g %.17g\n", m->gravity.x, m->gravity.y);
    for (int k = 0; k < m->n_spring; k++) {
        const lw_spring *c = &m->spring[k];
        fprintf(f, "spring %d %d %.17g %.17g %.17g %.17g %.17g %.17g\n", s->body[c->link[0]] + 1,
                s->body[c->link[1]] + 1, c->at[0].x, c->at[0].y, c->at[1].x, c->at[1].y, c->stiffness, c->free);
    }
    for (int k = 0; k < m->n_force; k++)
        fprintf(f, "torque %d %.17g\n", s->body[m->force[k].link] + 1, lw_expression_value(m->force[k].torque[2], NULL));
}

static lw_status write_scene(const cli_mbs *b, const cli_mbs_problem *p, const lw_model *m, int n_moment, FILE *f,
                             lw_error *e)
{
    lw_dynamics *d;
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_bytes mjcf = { 0 };
    const char *more = beyond(m);
    o.formulation = LW_FORMULATION_INDEX1;
    lw_status st = LW_OK;
    if (more)
        st = lw_error_set(e, LW_E_KIND, "'%s' has %s, which cannot be passed to other programs", p->name, more);
    if (st == LW_OK)
        st = lw_export_mjcf(&m->linkage, NULL, &mjcf, e);
    if (st == LW_OK)
        st = lw_dynamics_make(m, &o, &d, e);
    if (st == LW_OK) {
        const lw_system *s = lw_dynamics_system(d);
        double *q = calloc(2*(size_t)s->n_q + 1, sizeof *q), *v = q + s->n_q;
        if (q) {
            lw_dynamics_start(d, q, v);
            write_bodies(s, m, q, v, f);
        } else {
            st = lw_error_set(e, LW_E_MEMORY, "out of memory");
        }
        free(q);
        write_loads(s, m, f);
        fprintf(f, "run %.17g %d %.17g %.17g\nmjcf\n%s", p->to, n_moment, b->time, CLI_MBS_TOO_SLOW, mjcf.data);
        lw_dynamics_free(d);
    }
    lw_bytes_free(&mjcf);
    return st;
}

/* ---- one program ---------------------------------------------------------------------------------------------- */

static pid_t begin(const char *path, int in, int *out)
{
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return -1;
    pid_t child = fork();
    if (child == 0) {
        int nowhere = open("/dev/null", O_WRONLY);       /* solvers print warnings; only the rows matter    */
        dup2(in, 0);
        dup2(ends[1], 1);
        dup2(nowhere, 2);
        execl(path, path, (char *)NULL);
        _exit(127);
    }
    close(ends[1]);
    *out = ends[0];
    if (child < 0)
        close(ends[0]);
    return child;
}

/* Read all output of the child until it ends. End the child when its time is over or on Ctrl-C. The caller frees the
 * text. */
static char *listen(pid_t child, int from, double until)
{
    size_t n = 0, capacity = 1 << 16;
    char *text = malloc(capacity);
    ssize_t got = 1;
    while (text && got > 0 && n < ANSWER_MAX) {
        struct pollfd p = { .fd = from, .events = POLLIN };
        if (cli_interrupted() || lw_clock_wall() > until) {
            kill(child, SIGKILL);
            break;
        }
        if (poll(&p, 1, 100) <= 0)
            continue;
        got = read(from, text + n, capacity - n - 1);
        n += got > 0 ? (size_t)got : 0;
        if (capacity - n < 2) {
            char *more = realloc(text, capacity *= 2);
            if (!more)
                free(text);
            text = more;
        }
    }
    if (!text || n >= ANSWER_MAX)
        kill(child, SIGKILL);
    if (text)
        text[n] = 0;
    return text;
}

/* Describe how the child failed; "" if it ended well. */
static void how_it_ended(pid_t child, double until, char *how, size_t size)
{
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    how[0] = 0;
    if (WIFSIGNALED(status) && lw_clock_wall() > until)
        snprintf(how, size, "ended after %g s", CLI_MBS_PEER_TIME);
    else if (WIFSIGNALED(status))
        snprintf(how, size, "ended by signal %d", WTERMSIG(status));
    else if (WEXITSTATUS(status) != 0)
        snprintf(how, size, "ended with code %d", WEXITSTATUS(status));
}

/* ---- its answer ----------------------------------------------------------------------------------------------- */

static bool read_places(char **rest, cli_mbs_motion *m)
{
    char *at = *rest;
    for (int i = 0; i < 3*m->n_moment*m->n_body; i++) {
        char *end;
        m->place[i] = strtod(at, &end);
        if (end == at || !isfinite(m->place[i]))
            return false;
        at = end;
    }
    *rest = at;
    return *at == '\n';
}

/* Read one row. False: the line is no row. */
static bool read_row(cli_mbs *b, const cli_mbs_problem *p, const char *peer, const cli_mbs_reference *r, char **rest,
                     cli_mbs_motion *m)
{
    cli_mbs_row row = { 0 };
    char solver[24], name[40];
    char *line = strsep(rest, "\n");
    bool failed = sscanf(line, "fail %lf %23[^:]: %159[^\n]", &row.tolerance, solver, row.note) == 3;
    if (!failed && sscanf(line, "run %lf %lf %lf %ld %ld %23[^\n]", &row.tolerance, &row.make, &row.seconds,
                          &row.steps, &row.rates, solver) != 6)
        return false;
    if (!failed && (!*rest || !read_places(rest, m)))
        return false;
    *rest += !failed;
    snprintf(name, sizeof name, "%.14s %s", peer, solver);
    cli_mbs_row *to = cli_mbs_add(b, p->name, name, row.tolerance);
    if (!to)
        return false;
    if (failed) {
        memcpy(to->note, row.note, sizeof to->note);
        return true;
    }
    to->make = row.make, to->seconds = row.seconds;
    to->steps = row.steps, to->rates = row.rates;
    to->error = p->measure(m, r, &to->off);
    return true;
}

static lw_status run_peer(cli_mbs *b, const cli_mbs_problem *p, const char *path, FILE *scene,
                          const cli_mbs_reference *r, cli_mbs_motion *m, lw_error *e)
{
    char how[64];
    int from;
    const char *slash = strrchr(path, '/'), *peer = slash ? slash + 1 : path;
    double until = lw_clock_wall() + CLI_MBS_PEER_TIME;
    rewind(scene);
    pid_t child = begin(path, fileno(scene), &from);
    if (child < 0)
        return lw_error_at(e, LW_E_IO, path, 0, 0, "does not start: %s", strerror(errno));
    char *text = listen(child, from, until), *rest = text;
    close(from);
    how_it_ended(child, until, how, sizeof how);
    int before = b->n;
    while (rest && *rest && read_row(b, p, peer, r, &rest, m)) {
    }
    if ((how[0] || b->n == before || (rest && *rest)) && !cli_interrupted()) {
        cli_mbs_row *row = cli_mbs_add(b, p->name, peer, NAN);
        if (row)
            snprintf(row->note, sizeof row->note, "%s", how[0] ? how : "what it says is no row of numbers");
    }
    free(text);
    return LW_OK;
}

/* Run all programs on the scene that `st` says is written; answers have n_body places a moment. */
static lw_status run_peers(cli_mbs *b, const cli_mbs_problem *p, FILE *scene, int n_body, const cli_mbs_reference *r,
                           lw_status st, lw_error *e)
{
    cli_mbs_motion motion = { .n_moment = r->n_row, .n_body = n_body,
                              .place = malloc(sizeof(double)*3*(size_t)(r->n_row*n_body)) };
    if (st == LW_OK && (!motion.place || fflush(scene) != 0))
        st = lw_error_set(e, LW_E_IO, "the scene for other programs cannot be written: %s", strerror(errno));
    for (int i = 0; i < b->n_peer && st == LW_OK && !cli_interrupted(); i++)
        st = run_peer(b, p, b->peer[i], scene, r, &motion, e);
    fclose(scene);
    free(motion.place);
    return st;
}

static FILE *open_scene(lw_error *e)
{
    FILE *scene = tmpfile();
    if (!scene)
        lw_error_set(e, LW_E_IO, "no temporary file for the scene of other programs: %s", strerror(errno));
    return scene;
}

lw_status cli_mbs_peers(cli_mbs *b, const cli_mbs_problem *p, const lw_model *m, const cli_mbs_reference *r,
                        lw_error *e)
{
    FILE *scene = b->n_peer ? open_scene(e) : NULL;
    return scene ? run_peers(b, p, scene, m->linkage.n_link - 1, r, write_scene(b, p, m, r->n_row, scene, e), e)
         : b->n_peer ? LW_E_IO : LW_OK;
}

/* ---- in space --------------------------------------------------------------------------------------------------- */

static void write_vec(lw_vec3 v, FILE *f) { fprintf(f, " %.17g %.17g %.17g", v.x, v.y, v.z); }

static lw_status write_space(const cli_mbs *b, const cli_mbs_problem *p, const lw_spatial *m, const cli_mbs_cycle *cycle,
                             int n_moment, FILE *f, lw_error *e)
{
    lw_dynamics *d;
    lw_dynamics_options o = { .formulation = cycle ? LW_FORMULATION_AUTO : LW_FORMULATION_INDEX1, .to = p->to, .relative = 1e-10,
                              .absolute = 1e-10 };
    lw_bytes mjcf = { 0 };
    double *q = NULL;
    lw_status st = lw_export_space_mjcf(m, &mjcf, e);
    if (st == LW_OK)
        st = lw_dynamics_make_spatial(m, &o, &d, e);
    if (st != LW_OK)
        return lw_bytes_free(&mjcf), st;
    const lw_space *s = lw_dynamics_space(d);
    lw_space_frame *frame = malloc(((size_t)s->n_body + 1)*sizeof *frame);
    q = malloc((size_t)(s->n_q + s->n_v)*sizeof *q);
    if (q && frame) {
        lw_dynamics_start(d, q, q + s->n_q);
        lw_space_place(s, q, frame);
        fputs("gravity3", f);
        write_vec(m->gravity, f);
        for (int i = 0; i < s->n_body; i++) {
            const lw_spatial_body *body = &m->body[s->link_of[i]];
            fprintf(f, "\nbody3 %.17g", body->mass);
            for (int k = 0; k < 6; k++)
                fprintf(f, " %.17g", body->inertia[k]);
            write_vec(body->centre, f);
            write_vec(lw_space_point_velocity(s, frame, (lw_space_point){ .body = i }, q + s->n_q), f);
            write_vec(lw_space_omega(frame, i, q + s->n_q), f);
        }
        for (int j = 0; j < m->n_joint; j++) {
            const lw_spatial_joint *t = &m->joint[j];
            fprintf(f, "\njoint3 %c %d %d", lw_spatial_kind_of(t->kind)->letter, s->body_of[t->link[0]] + 1, s->body_of[t->link[1]] + 1);
            write_vec(t->at, f);
            write_vec(t->axis, f);
            write_vec(t->second, f);
        }
        for (int k = 0; k < m->n_spring; k++) {
            const lw_spring *t = &m->spring[k];
            fprintf(f, "\nspring3 %d %d", s->body_of[t->link[0]] + 1, s->body_of[t->link[1]] + 1);
            write_vec(t->at[0], f);
            write_vec(t->at[1], f);
            fprintf(f, " %.17g %.17g %.17g", t->stiffness, t->damping, t->free);
        }
        for (int k = 0; cycle && k < n_moment; k++) {
            fprintf(f, k ? "\nat3" : "\ndrive3 %d %d %d\nat3", m->drive[0].index, m->drive[1].index, m->drive[2].index);
            for (int i = 0; i < 9; i++)
                fprintf(f, " %.17g", cycle->at[k][i/3][i%3]);
        }
        fprintf(f, "\npoint %d", s->body_of[m->tracer[0].link] + 1);
        write_vec(m->tracer[0].at, f);
        fprintf(f, " %s\nrun %.17g %d %.17g %.17g\nmjcf\n%s", m->tracer[0].name, p->to, n_moment, b->time, CLI_MBS_TOO_SLOW,
                mjcf.data);
    } else
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    free(q), free(frame);
    lw_dynamics_free(d);
    lw_bytes_free(&mjcf);
    return st;
}

lw_status cli_mbs_peers_space(cli_mbs *b, const cli_mbs_problem *p, const lw_spatial *m, const cli_mbs_cycle *cycle,
                              const cli_mbs_reference *r, lw_error *e)
{
    FILE *scene = b->n_peer ? open_scene(e) : NULL;
    return scene ? run_peers(b, p, scene, 1, r, write_space(b, p, m, cycle, r->n_row, scene, e), e) : b->n_peer ? LW_E_IO : LW_OK;
}
