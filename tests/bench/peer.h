/* peer.h - what programs beside `linkwright bench mbs` are told and what they answer; C and C++.
 *
 * Standard input, a line each, SI, the posture of the start, links counted from 1 and 0 for the ground:
 *
 *     gravity X Y
 *     body MASS INERTIA X Y OMEGA NAME              centre of mass; NAME up to the end of the line
 *     pin A B X Y
 *     spring A B AX AY BX BY STIFFNESS FREE          between a point of A and a point of B
 *     torque BODY N                                  constant, on a link
 *     gravity3 X Y Z                                 a scene in space has these lines instead:
 *     body3 MASS XX YY ZZ XY XZ YZ X Y Z VX VY VZ WX WY WZ        inertia about the centre; velocities of the start
 *     joint3 KIND A B X Y Z AX AY AZ BX BY BZ        letter of the kind (docs/notation.md), axis, second axis
 *     spring3 A B AX AY AZ BX BY BZ STIFFNESS DAMPING FREE
 *     drive3 J J J                                   inverse dynamics, not a run: three joints (counted from 0) whose
 *     at3 Q V A Q V A Q V A                          turns, rates and accelerations are given at each moment; the answer is
 *                                                    their torques, three numbers a line
 *     point BODY X Y Z NAME                          the answer is the place of this point, X Y Z a line
 *     run END MOMENTS REPEAT LONGEST                 seconds of motion; moments from 0 to END; seconds for the repeats
 *                                                    of a row; seconds of a run after which nothing tighter is tried
 *     mjcf                                           all that follows: the linkage as a model of MuJoCo, without masses;
 *                                                    in space the whole model
 *
 * Standard output, for each solver and tolerance (accuracy, or length of the step):
 *
 *     run TOLERANCE SETUP SECONDS STEPS EVALUATIONS SOLVER     processor time, best of several; then MOMENTS lines:
 *     X Y TURN X Y TURN ...                                    of each body: centre of mass, turn since the start
 *     fail TOLERANCE SOLVER: WHY */
#ifndef LW_TESTS_BENCH_PEER_H
#define LW_TESTS_BENCH_PEER_H

#include <malloc.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { PEER_MAX = 2048, PEER_NAME = 128, PEER_XML = 1 << 20, PEER_REPEAT = 50, PEER_POSTURES = 256 };

typedef struct peer_body { double mass, inertia, x, y, omega; char name[PEER_NAME]; } peer_body;
typedef struct peer_pin { int a, b; double x, y; } peer_pin;
typedef struct peer_spring { int a, b; double ax, ay, bx, by, stiffness, free; } peer_spring;
typedef struct peer_torque { int body; double value; } peer_torque;

typedef struct peer_body3 { double mass, inertia[6], at[3], v[3], omega[3]; } peer_body3;
typedef struct peer_joint3 { char kind; int a, b; double at[3], axis[3], second[3]; } peer_joint3;
typedef struct peer_spring3 { int a, b; double at[2][3], stiffness, damping, free; } peer_spring3;

typedef struct peer_scene {
    double      gx, gy, end, repeat, longest;
    int         n_body, n_pin, n_spring, n_torque, moments;
    peer_body   body[PEER_MAX];           /* body[k] is link k + 1                     */
    peer_pin    pin[PEER_MAX];
    peer_spring spring[PEER_MAX];
    peer_torque torque[PEER_MAX];
    bool         space;
    double       gravity[3];
    int          n_body3, n_joint3, n_spring3;
    peer_body3   body3[PEER_MAX];
    peer_joint3  joint3[PEER_MAX];
    peer_spring3 spring3[PEER_MAX];
    int          drive3[3], n_at3;        /* n_at3 > 0: inverse dynamics */
    double       at3[PEER_POSTURES][3][3];
    int          point_body;
    double       point[3];
    char         point_name[PEER_NAME];
    char        xml[PEER_XML];
} peer_scene;

/* The lines of a scene in space. */
static inline bool peer_line3(peer_scene *s, const char *line)
{
    peer_body3 *b = &s->body3[s->n_body3];
    peer_joint3 *j = &s->joint3[s->n_joint3];
    peer_spring3 *k = &s->spring3[s->n_spring3];
    if (s->n_body3 == PEER_MAX - 1 || s->n_joint3 == PEER_MAX - 1 || s->n_spring3 == PEER_MAX - 1)
        return false;
    if (sscanf(line, "body3 %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &b->mass, &b->inertia[0],
               &b->inertia[1], &b->inertia[2], &b->inertia[3], &b->inertia[4], &b->inertia[5], &b->at[0], &b->at[1],
               &b->at[2], &b->v[0], &b->v[1], &b->v[2], &b->omega[0], &b->omega[1], &b->omega[2]) == 16)
        return ++s->n_body3 > 0;
    if (sscanf(line, "joint3 %c %d %d %lf %lf %lf %lf %lf %lf %lf %lf %lf", &j->kind, &j->a, &j->b, &j->at[0], &j->at[1],
               &j->at[2], &j->axis[0], &j->axis[1], &j->axis[2], &j->second[0], &j->second[1], &j->second[2]) == 12)
        return ++s->n_joint3 > 0;
    if (sscanf(line, "spring3 %d %d %lf %lf %lf %lf %lf %lf %lf %lf %lf", &k->a, &k->b, &k->at[0][0], &k->at[0][1],
               &k->at[0][2], &k->at[1][0], &k->at[1][1], &k->at[1][2], &k->stiffness, &k->damping, &k->free) == 11)
        return ++s->n_spring3 > 0;
    double (*a)[3] = s->at3[s->n_at3];
    if (s->n_at3 < PEER_POSTURES - 1 && sscanf(line, "at3 %lf %lf %lf %lf %lf %lf %lf %lf %lf", &a[0][0], &a[0][1], &a[0][2], &a[1][0],
                                               &a[1][1], &a[1][2], &a[2][0], &a[2][1], &a[2][2]) == 9)
        return ++s->n_at3 > 0;
    if (sscanf(line, "drive3 %d %d %d", &s->drive3[0], &s->drive3[1], &s->drive3[2]) == 3)
        return true;
    if (sscanf(line, "point %d %lf %lf %lf %127[^\n]", &s->point_body, &s->point[0], &s->point[1], &s->point[2], s->point_name) == 5)
        return true;
    bool begins = sscanf(line, "gravity3 %lf %lf %lf", &s->gravity[0], &s->gravity[1], &s->gravity[2]) == 3;
    s->space = s->space || begins;
    return begins;
}

/* Does a line say what its first word promises? */
static inline bool peer_line(peer_scene *s, const char *line)
{
    peer_body *b = &s->body[s->n_body];
    peer_pin *p = &s->pin[s->n_pin];
    peer_spring *k = &s->spring[s->n_spring];
    peer_torque *t = &s->torque[s->n_torque];
    const int last = PEER_MAX - 1;
    if (s->n_body == last || s->n_pin == last || s->n_spring == last || s->n_torque == last)
        return false;
    if (peer_line3(s, line))
        return true;
    if (sscanf(line, "body %lf %lf %lf %lf %lf %127[^\n]", &b->mass, &b->inertia, &b->x, &b->y, &b->omega, b->name) == 6)
        return ++s->n_body > 0;
    if (sscanf(line, "pin %d %d %lf %lf", &p->a, &p->b, &p->x, &p->y) == 4)
        return ++s->n_pin > 0;
    if (sscanf(line, "spring %d %d %lf %lf %lf %lf %lf %lf", &k->a, &k->b, &k->ax, &k->ay, &k->bx, &k->by, &k->stiffness, &k->free) == 8)
        return ++s->n_spring > 0;
    if (sscanf(line, "torque %d %lf", &t->body, &t->value) == 2)
        return ++s->n_torque > 0;
    return sscanf(line, "gravity %lf %lf", &s->gx, &s->gy) == 2
        || sscanf(line, "run %lf %d %lf %lf", &s->end, &s->moments, &s->repeat, &s->longest) == 4;
}

/* The scene on standard input; ends the program when it is none. */
static inline peer_scene *peer_read(void)
{
    static peer_scene scene;
    char line[1024];
    mallopt(M_TRIM_THRESHOLD, 1 << 30);      /* as `bench mbs` does: memory stays with the process */
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    while (fgets(line, sizeof line, stdin)) {
        if (strcmp(line, "mjcf\n") == 0) {
            scene.xml[fread(scene.xml, 1, PEER_XML - 1, stdin)] = 0;
            break;
        }
        if (!peer_line(&scene, line)) {
            fprintf(stderr, "peer: not understood: %s", line);
            exit(3);
        }
    }
    if (scene.moments < 2 || scene.n_body + scene.n_body3 == 0) {
        fputs("peer: no scene on standard input; run by `linkwright bench mbs`\n", stderr);
        exit(3);
    }
    return &scene;
}

/* Processor time [s]. */
static inline double peer_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9*(double)t.tv_nsec;
}

/* Run one row in a process of its own, so that a row that never ends, or crashes, loses itself only: it may take 20 times
 * scene->longest, 1 s at least.  row returns the seconds of its best run.  Returns true where that is longer than
 * scene->longest, or the row is lost; a lost row prints "fail". */
static inline bool peer_apart(const peer_scene *scene, double (*row)(void *), void *context, double tolerance, const char *solver)
{
    enum { QUICK, SLOW };
    int status = 0;
    unsigned limit = scene->longest > 0.05 ? (unsigned)(20*scene->longest) : 1;
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        alarm(limit);
        bool slow = row(context) > scene->longest;
        fflush(stdout);
        _exit(slow ? SLOW : QUICK);
    }
    if (child < 0 || waitpid(child, &status, 0) < 0 || WIFSIGNALED(status)) {
        if (child >= 0 && WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM)
            printf("fail %g %s: not at the end after %u s\n", tolerance, solver, limit);
        else
            printf("fail %g %s: it crashed\n", tolerance, solver);
        fflush(stdout);
        return true;
    }
    return WEXITSTATUS(status) == SLOW;
}

#endif
