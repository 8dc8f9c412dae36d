/* linkwright.h - the whole public interface of linkwright, a library for mechanisms in the plane and in space: which exist,
 * how they move, what they carry, and which one does a job.  C17 and C++.  Compile with `pkg-config --cflags --libs
 * linkwright`.
 *
 * Units.  SI everywhere: lengths [m], angles [rad] counter-clockwise, time [s], mass [kg], force [N].  A file may
 * use other units; they are converted when it is read.
 *
 * Numbers.  Links, joints, tracers (points to watch) and inputs count from 0 here, and from 1 in every text.
 * Letters of joints: r pin, t slider, p pin in a slot, g gear pair, f weld (linkages only).
 *
 * Handles.  Structs that are only declared here are made by lw_X_create, _load, _read or a function that fills
 * `out`, and belong to the caller, who frees each with its lw_X_destroy; NULL is allowed there.  `out` is set to
 * NULL when the call fails, and may not be NULL.  Handles and texts inside a callback's arguments are valid during
 * that call only.  Texts and bytes that a function returns through `char **` are freed with lw_free.  A `const
 * char *` that is returned belongs to the handle, or lives for ever.
 *
 * Errors.  lw_status tells how a call ended: 0 done, > 0 another answer, < 0 failed.  The last argument `error` may
 * be NULL; a call that fails fills it with a text that says what is wrong and what to do.  A function without
 * status takes an index as given; one outside its range gives 0, -1 or NULL.  Nothing here prints, exits or aborts.
 * The process-wide error handlers of GSL and igraph are exchanged while this library calls them, and put back.
 *
 * Callbacks.  LW_OK goes on; any other status ends the call, which returns it.
 *
 * Threads.  Different handles are independent of each other.  One handle may be read by several threads at once
 * through functions that take it as `const`; all others need it alone.  There is no global state that a result
 * depends on.  Functions with `jobs` start that many threads (below 1: one for each core), give the same result for
 * any number, and make all calls of a callback one at a time, from any of these threads where `progress` is
 * concerned, else from the calling thread. */
#ifndef LINKWRIGHT_H
#define LINKWRIGHT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LW_VERSION_MAJOR  0
#define LW_VERSION_MINOR  2
#define LW_VERSION_PATCH  0
#define LW_VERSION_STRING "0.2.0"

#define LW_API __attribute__((visibility("default")))

/* ---- general ----------------------------------------------------------------------------------------------- */

/* name, code, text */
#define LW_STATUS_LIST(X)                                                          \
    X(LW_OK,            0, "success")                                              \
    X(LW_OPEN,          1, "the linkage cannot close at this input")               \
    X(LW_STOPPED,       2, "a limit ended the search before its tolerance")        \
    X(LW_NOTHING,       3, "nothing was found")                                    \
    X(LW_E_ARG,        -1, "argument outside its documented range")                \
    X(LW_E_MEMORY,     -2, "out of memory")                                        \
    X(LW_E_NOTATION,   -3, "text does not follow docs/notation.md")                \
    X(LW_E_IO,         -4, "a file could not be read or written")                  \
    X(LW_E_NUMERIC,    -5, "the numbers do not allow an answer")                   \
    X(LW_E_KIND,       -6, "this kind of mechanism is not handled here")

typedef enum lw_status {
#define X(name, code, text) name = code,
    LW_STATUS_LIST(X)
#undef X
} lw_status;

typedef struct lw_error {
    lw_status status;
    char      file[256];       /* "" when no file is concerned; "-" is standard input     */
    long      line;            /* 1 is the first line; 0 when unknown                     */
    long      column;          /* 1 is the first byte of the line; 0 when unknown         */
    char      text[768];       /* one sentence or two, no newline at the end              */
} lw_error;

typedef struct lw_vec2 { double x, y; } lw_vec2;
typedef struct lw_vec3 { double x, y, z; } lw_vec3;
typedef struct lw_quaternion { double w, x, y, z; } lw_quaternion;      /* of length 1, w the real part: a turn      */

/* Version of the library that runs, "0.2.0"; LW_VERSION_STRING is that of this header. */
LW_API const char *lw_version(void);

/* Text of a status; never NULL, also for numbers that are no status. */
LW_API const char *lw_status_text(lw_status status);

/* Name of a status, "LW_OK"; "LW_?" for numbers that are no status. */
LW_API const char *lw_status_name(lw_status status);

/* "file:line:column: text" into buffer (size), always terminated; parts that are unknown are left out. */
LW_API void lw_error_print(const lw_error *error, char *buffer, int size);

/* Free a text or bytes that a function of this header returned. */
LW_API void lw_free(void *text);

/* Called during long work: share done, 0 to 1, seconds since the start, and the best objective so far (NaN where
 * there is none).  false: stop; the call then returns LW_STOPPED and keeps what it has. */
typedef bool lw_progress(void *context, double done, double seconds, double best);

/* ---- motion of one axis ----------------------------------------------------------------------------------------- */

/* Position [m] or [rad], or in any other unit; speed and acceleration by s. */
typedef struct lw_axis_state { double x, v, a; } lw_axis_state;

/* Least (negative) and greatest of each; infinite where there is no limit, but acceleration or jerk must be finite in
 * both directions. */
typedef struct lw_axis_limits { double v[2], a[2], j[2]; } lw_axis_limits;

#define LW_PROFILE_PHASES_MAX 14

/* Phases of constant jerk, one after the other. */
typedef struct lw_profile {
    int           n;
    double        duration;                              /* [s]                                             */
    double        t[LW_PROFILE_PHASES_MAX + 1];          /* start of each phase; t[n] is the end            */
    lw_axis_state at[LW_PROFILE_PHASES_MAX + 1];         /* there                                           */
    double        jerk[LW_PROFILE_PHASES_MAX];
} lw_profile;

/* The motion between two states in least time, no shorter than `least` (0: the least there is).  With infinite jerk
 * the accelerations of both states do not count.  LW_E_ARG with a text: limits that are no limits, or a state that no
 * motion within the limits can start from or end in. */
LW_API lw_status lw_profile_make(lw_axis_state from, lw_axis_state to, const lw_axis_limits *limits, double least,
                                 lw_profile *out, lw_error *error);

/* The motion that takes just `duration`.  LW_NOTHING: none does; *next, may be NULL: the next duration that is
 * possible. */
LW_API lw_status lw_profile_make_timed(lw_axis_state from, lw_axis_state to, const lw_axis_limits *limits,
                                       double duration, lw_profile *out, double *next, lw_error *error);

/* Several axes (n) that start and end together, each within its limits.  in_phase: along a straight line in space;
 * LW_NOTHING when states and way do not lie along one. */
LW_API lw_status lw_profile_make_axes(int n, const lw_axis_state *from, const lw_axis_state *to,
                                      const lw_axis_limits *limits, double least, bool in_phase, lw_profile *out,
                                      lw_error *error);

/* State and jerk (may be NULL) at t; at the border of two phases the jerk is that of the later one.  Outside the
 * motion it goes on with the speed at its start or end. */
LW_API lw_axis_state lw_profile_at(const lw_profile *profile, double t, double *jerk);

/* Least and greatest speed, acceleration and jerk over the whole motion, exact. */
LW_API lw_axis_limits lw_profile_extremes(const lw_profile *profile);

/* Limits for a motion from rest to rest over a way.  Power: the thirds of the time that move a mass quickest with so much
 * power (Makkonen 1999).  Frequency: ramps of the acceleration over whole periods of an oscillation [Hz], which is at rest
 * afterwards; acceleration must be limited. */
LW_API void lw_profile_limit_power(double way, double power, double mass, lw_axis_limits *limits);
LW_API void lw_profile_limit_frequency(double way, double frequency, lw_axis_limits *limits);

/* Laws of motion from rest to rest over a unit of way in a unit of time (docs/profile.md, "Laws"). */
typedef struct lw_motion_law {
    const char *name, *words;                            /* "cycloid"; one line                             */
    const char *also;                                    /* a second name; NULL: none                       */
    double      speed_peak, acceleration_peak, jerk_peak;  /* over way/T^k; infinite: a step                */
    double      copper_loss;                             /* integral of the squared acceleration: heat of a motor */
} lw_motion_law;

/* The laws by number; NULL past the last one.  Number by name, -1: there is none.  Way, speed, acceleration and jerk at u;
 * 0 and 1 outside [0, 1], at a step those after it. */
LW_API const lw_motion_law *lw_motion_law_get(int law);
LW_API int  lw_motion_law_find(const char *name);
LW_API void lw_motion_law_at(int law, double u, double out[4]);

typedef struct lw_work_cycle lw_work_cycle;    /* moves of several axes with payloads and rests (docs/profile.md)  */

/* From JSON text or file; the moves are planned.  LW_E_NOTATION also for moves that the limits do not allow. */
LW_API lw_status lw_work_cycle_parse(const char *text, size_t size, const char *file, lw_work_cycle **out, lw_error *error);
LW_API lw_status lw_work_cycle_load(const char *path, lw_work_cycle **out, lw_error *error);
LW_API void      lw_work_cycle_destroy(lw_work_cycle *cycle);

/* Number and names of axes ('a') and moves ('m'); NULL past the last one. */
LW_API int         lw_work_cycle_count(const lw_work_cycle *cycle, char what);
LW_API const char *lw_work_cycle_name(const lw_work_cycle *cycle, char what, int i);
/* Start, duration and the rest after a move [s]; end of all. */
LW_API lw_status lw_work_cycle_times(const lw_work_cycle *cycle, int move, double *start, double *duration, double *dwell);
LW_API double    lw_work_cycle_end(const lw_work_cycle *cycle);
/* State of an axis and the payload at t; *jerk may be NULL. */
LW_API lw_axis_state lw_work_cycle_at(const lw_work_cycle *cycle, int axis, double t, double *jerk);
LW_API double        lw_work_cycle_payload(const lw_work_cycle *cycle, double t);

/* ---- servo axes ------------------------------------------------------------------------------------------------- */

typedef struct lw_servo lw_servo;      /* motor, transmission, load, controllers, wanted motion (docs/drive.md)  */

/* From JSON text or file, as lw_model_parse and lw_model_load. */
LW_API lw_status lw_servo_parse(const char *text, size_t size, const char *file, lw_servo **out, lw_error *error);
LW_API lw_status lw_servo_load(const char *path, lw_servo **out, lw_error *error);
LW_API void      lw_servo_destroy(lw_servo *servo);

/* One moment; positions and forces are those of the load. */
typedef struct lw_servo_row {
    double t;
    lw_axis_state wanted;
    double position, speed, error;     /* of the load; wanted less reached                                       */
    double motor_position, motor_speed;                  /* of the motor, seen at the load                        */
    double current, voltage, torque;   /* of the motor [A] [V] [N m]                                             */
    double heat, electrical;           /* in the copper, and energy taken from the amplifier, since 0 [J]         */
} lw_servo_row;
typedef lw_status lw_servo_callback(void *context, const lw_servo_row *row);

typedef struct lw_servo_options {
    double to;                         /* [s]; 0: the motion and half as long again                 (0)           */
    int    intervals;                  /* rows less one                                             (1000)        */
    double tolerance;                  /* of a step of the integration                              (1e-9)        */
    double band;                       /* settled: |error| stays below this [m] or [rad]            (1e-3)        */
    const volatile int *stop;          /* *stop not 0 ends the run; may be set by a signal          (NULL)        */
} lw_servo_options;
LW_API lw_servo_options lw_servo_options_default(void);

typedef struct lw_servo_report {
    double end, to;                    /* end of the motion, of the run [s]                                       */
    double error_peak, error_peak_t, error_end;
    double settled;                    /* |error| <= band from here on [s]; NaN: not at the end                   */
    double overshoot;                  /* beyond the end of the last move, in its direction                       */
    double current_peak, current_rms, voltage_peak, torque_peak, speed_peak;     /* speed of the motor [rad/s]    */
    double current_limited, voltage_limited;             /* time at these limits [s]                              */
    double electrical, heat, friction, transmission;     /* energy taken; lost in copper, friction, gear [J]      */
    double stored, work;               /* change of kinetic, elastic, magnetic energy; done by the force [J]      */
    double energy_error;               /* electrical + work - heat - friction - transmission - stored [J]         */
    long   steps;
} lw_servo_report;

/* Run from rest at the wanted position at t = 0.  visit may be NULL.  LW_E_NUMERIC: the axis moves beyond all numbers, as
 * with unstable gains; LW_STOPPED. */
LW_API lw_status lw_servo_run(const lw_servo *servo, const lw_servo_options *options, lw_servo_callback *visit,
                              void *context, lw_servo_report *report, lw_error *error);

/* Poles of the closed loop without dry friction, play, limits and encoder steps [1/s], the least damped first: *n of them
 * into re, im (16).  LW_E_KIND: the sampling times have no common multiple that is one of them. */
LW_API lw_status lw_servo_poles(const lw_servo *servo, int *n, double *re, double *im, lw_error *error);

/* ---- topologies: chains and mechanisms ----------------------------------------------------------------------- */

typedef struct lw_chain lw_chain;              /* links and joints, nothing fixed                              */
typedef struct lw_mechanism lw_mechanism;      /* a chain with kinds of joints, ground, inputs, output link     */
typedef struct lw_linkage lw_linkage;          /* a mechanism with dimensions: places of joints in one posture   */

/* Chain of n_link links (1 to 32) without joints.  LW_E_ARG, LW_E_MEMORY. */
LW_API lw_status lw_chain_create(int n_link, lw_chain **out);
LW_API lw_status lw_chain_copy(const lw_chain *chain, lw_chain **out);
LW_API void      lw_chain_destroy(lw_chain *chain);

/* Join links i and k by a joint of 1 or 2 freedoms.  LW_E_ARG: i is k, no such link, or they are joined by the
 * other sort. */
LW_API lw_status lw_chain_join(lw_chain *chain, int i, int k, int freedom);
LW_API void      lw_chain_unjoin(lw_chain *chain, int i, int k);

LW_API int       lw_chain_n_link(const lw_chain *chain);
LW_API int       lw_chain_joint_freedom(const lw_chain *chain, int i, int k);      /* 0: not joined            */
LW_API int       lw_chain_count(const lw_chain *chain, int freedom);               /* joints of 1 or 2 freedoms */
LW_API int       lw_chain_links_with(const lw_chain *chain, int n_joint);          /* links with so many joints */
LW_API int       lw_chain_mobility(const lw_chain *chain);        /* F = 3 (P - 1) - 2 n1 - n2; a count, no proof */
LW_API int       lw_chain_loops(const lw_chain *chain);           /* L = n1 + n2 - P + 1                        */
LW_API bool      lw_chain_is_connected(const lw_chain *chain);
LW_API bool      lw_chain_is_fractionated(const lw_chain *chain); /* it falls apart at one link                   */

/* Can it move: connected, every link with two joints, no rigid part?  LW_E_ARG with a text that names the links. */
LW_API lw_status lw_chain_check(const lw_chain *chain, lw_error *error);

/* Can its graph be drawn without crossings? */
LW_API lw_status lw_chain_is_planar(const lw_chain *chain, bool *planar);

/* The same chain but for the numbers of its links? */
LW_API lw_status lw_chain_is_isomorphic(const lw_chain *a, const lw_chain *b, bool *same);

/* Put the canonical form of `chain` into `form`, an existing chain; isomorphic chains have equal forms. */
LW_API lw_status lw_chain_canonical(const lw_chain *chain, lw_chain *form);

/* lowest (n_link): the lowest link that symmetry makes alike to each link.  *n_class, may be NULL: how many
 * classes, which is the number of different choices of ground. */
LW_API lw_status lw_chain_orbits(const lw_chain *chain, uint8_t *lowest, int *n_class);

/* Order of the symmetry group. */
LW_API lw_status lw_chain_symmetries(const lw_chain *chain, uint64_t *order);

/* Mechanism without joints, nothing chosen.  LW_E_ARG, LW_E_MEMORY. */
LW_API lw_status lw_mechanism_create(int n_link, lw_mechanism **out);
LW_API lw_status lw_mechanism_copy(const lw_mechanism *mechanism, lw_mechanism **out);
LW_API void      lw_mechanism_destroy(lw_mechanism *mechanism);

/* A chain as a mechanism with nothing chosen: joints r and p.  LW_E_ARG: too many joints. */
LW_API lw_status lw_mechanism_of_chain(const lw_chain *chain, lw_mechanism **out);

/* The chain of a mechanism into an existing one: kinds and choices are forgotten. */
LW_API void      lw_mechanism_chain(const lw_mechanism *mechanism, lw_chain *chain);

/* Joints get numbers in the order of the link adjacency matrix, so join all links before anything is chosen. 
 * LW_E_ARG: i is k, no such link or kind, joined already, inputs are chosen. */
LW_API lw_status lw_mechanism_join(lw_mechanism *mechanism, int i, int k, char kind);
LW_API int       lw_mechanism_joint(const lw_mechanism *mechanism, int i, int k);   /* its number; -1: not joined */

LW_API int       lw_mechanism_n_link(const lw_mechanism *mechanism);
LW_API int       lw_mechanism_n_joint(const lw_mechanism *mechanism);
LW_API char      lw_mechanism_joint_kind(const lw_mechanism *mechanism, int joint, int link[2]);  /* 0: no such joint */
LW_API int       lw_mechanism_ground(const lw_mechanism *mechanism);               /* -1: not chosen           */
LW_API int       lw_mechanism_output(const lw_mechanism *mechanism);               /* -1: not chosen           */
LW_API int       lw_mechanism_n_input(const lw_mechanism *mechanism);
LW_API int       lw_mechanism_input(const lw_mechanism *mechanism, int i);         /* the driven joint         */
LW_API int       lw_mechanism_mobility(const lw_mechanism *mechanism);

/* ground, output: links, -1 to leave open; input (n_input): joints of one freedom, rising. */
LW_API lw_status lw_mechanism_choose(lw_mechanism *mechanism, int ground, int n_input, const int *input, int output);

LW_API lw_status lw_mechanism_is_isomorphic(const lw_mechanism *a, const lw_mechanism *b, bool *same);

/* Does the count F say rightly how it moves, at general dimensions?  LW_NOTHING: no; text (size) says why. */
LW_API lw_status lw_mechanism_moves(const lw_mechanism *mechanism, char *text, int size);

/* An Assur group: links that are solved together once those before are known. */
typedef struct lw_group_info {
    int        group_class;            /* I, II (dyad), III, ... as 1, 2, 3                              */
    int        order;                  /* joints to links outside                                        */
    int        assembly_modes;         /* over the complex numbers; 0: not known                          */
    int        n_link;
    const int *link;                   /* (n_link)                                                        */
} lw_group_info;
typedef lw_status lw_group_visit(void *context, const lw_group_info *group);

/* The groups in the order of solution.  LW_E_ARG: no ground, not F inputs, inputs that do not drive everything. */
LW_API lw_status lw_mechanism_groups(const lw_mechanism *mechanism, lw_group_visit *visit, void *context,
                                     lw_error *error);

/* How the four rules of the published grammar derive it, step by step, or why they cannot, as text. */
LW_API lw_status lw_mechanism_derivation(const lw_mechanism *mechanism, char **out, lw_error *error);

/* One step of the grammar on a sentence, which may be NULL for rules 1 and 2.  kinds: letters of the joints k, "r"
 * or "t", NULL: all r.  Rules 3 and 4: between parts x and y (from 1) of one word, word -1: the first that holds both.
 * *out: the sentence.  LW_E_ARG: the rule does not apply. */
LW_API lw_status lw_sentence_derive(const char *sentence, int rule, const char *kinds, int x, int y, int word,
                                    char **out, lw_error *error);

/* Notations: "graph6", "lam", "sentence", "franke", "edges", "json"; for writing also "dot", "graphml". */

/* One topology from text.  notation NULL: found from how the text begins.  LW_E_NOTATION with line and column. */
LW_API lw_status lw_chain_from_text(const char *text, size_t size, const char *notation, lw_chain **out,
                                    lw_error *error);
LW_API lw_status lw_mechanism_from_text(const char *text, size_t size, const char *notation, lw_mechanism **out,
                                        lw_error *error);

/* LW_E_ARG: no such notation; LW_E_KIND: it cannot say this. */
LW_API lw_status lw_chain_to_text(const lw_chain *chain, const char *notation, char **out, lw_error *error);
LW_API lw_status lw_mechanism_to_text(const lw_mechanism *mechanism, const char *notation, char **out, lw_error *error);

typedef lw_status lw_chain_callback(void *context, const lw_chain *chain);
typedef lw_status lw_mechanism_callback(void *context, const lw_mechanism *mechanism);

/* All topologies of a text, in any mixture of notations; `file` is for messages, may be NULL. */
LW_API lw_status lw_mechanism_read_all(const char *text, size_t size, const char *file, lw_mechanism_callback *visit,
                                       void *context, lw_error *error);

/* ---- which topologies exist ----------------------------------------------------------------------------------- */

/* Number synthesis: F = 3 (P - 1) - 2 n1 - n2 and L = n1 + n2 - P + 1. */
typedef struct lw_link_numbers { int links, dof, loops, joints1, joints2; } lw_link_numbers;

/* From F, L and n2; from P, F and n2.  LW_E_ARG with the equation when they do not go together. */
LW_API lw_status lw_link_numbers_of_loops(int dof, int loops, int joints2, lw_link_numbers *numbers, lw_error *error);
LW_API lw_status lw_link_numbers_of_links(int links, int dof, int joints2, lw_link_numbers *numbers, lw_error *error);

/* Assortments: n_with[j] links with j joints, j below n.  Those with the largest links first. */
typedef lw_status lw_assortment_visit(void *context, const int *n_with, int n);
LW_API lw_status lw_enumerate_assortments(const lw_link_numbers *numbers, lw_assortment_visit *visit, void *context);

/* Franke structures with 2 to 9 loops: 1, 4, 17, 118, 1198, 17133, 311757, ...  Text: "(3 3 4) 1-2 1-3 ...";
 * derivation: "theta 1(1,2) 3(2,5)". */
typedef lw_status lw_structure_visit(void *context, const char *structure, const char *derivation);
LW_API lw_status lw_enumerate_structures(int loops, int jobs, lw_structure_visit *visit, void *context);

typedef struct lw_enumeration {
    int          links, dof;
    int          joints2;              /* joints of two freedoms                                          (0)     */
    bool         fractionated;         /* those that fall apart at a link, instead of those that do not   (false) */
    const char  *filter;               /* "planar", "nonplanar", ...; NULL: all                           (NULL)  */
    int          part, parts;          /* part 0 .. parts-1 of the list                                   (0, 1)  */
    uint64_t     skip;                 /* leave out so many chains at the front                           (0)     */
    int          jobs;                 /* threads; below 1: one for each core                             (0)     */
    lw_progress *progress;             /* NULL: none                                                      (NULL)  */
    void        *context;              /* of progress                                                     (NULL)  */
} lw_enumeration;
LW_API lw_enumeration lw_enumeration_default(int links, int dof);

/* Every chain once, in an order that does not depend on jobs.  LW_E_ARG with the equation when links and dof do not go
 * together, for filter, part and skip beside fractionated or joints2; LW_E_MEMORY. */
LW_API lw_status lw_enumerate_chains(const lw_enumeration *what, lw_chain_callback *visit, void *context,
                                     lw_error *error);

/* How many chains, and how many choices of a ground link up to symmetry; quicker than visiting.  grounds may be
 * NULL. */
LW_API lw_status lw_enumerate_count(const lw_enumeration *what, uint64_t *chains, uint64_t *grounds, lw_error *error);

/* Decimal digits (40) of the number of chains whose links have names 1 .. P, each chain P!/|symmetries| times, without making
 * any: a check of counts, and over P! a lower bound.  LW_E_ARG for dof 0, numbers that do not fit, more than 5e36. */
LW_API lw_status lw_enumerate_labelled(int links, int dof, char *digits, lw_error *error);

/* Expected number of chains, processor time to count and to list them [s], and memory [byte]. */
typedef struct lw_enumeration_cost { double chains, count_seconds, list_seconds, bytes; } lw_enumeration_cost;
LW_API lw_status lw_enumerate_estimate(int links, int dof, lw_enumeration_cost *cost, lw_error *error);

/* Chains with multiple joints, several pins on one axis: links on each pin as text, "1-2-5 1-3 2-4". */
typedef lw_status lw_text_visit(void *context, const char *text);
LW_API lw_status lw_enumerate_multiple(int links, int dof, int jobs, lw_text_visit *visit, void *context,
                                       lw_error *error);

/* From a chain or mechanism to mechanisms, each step up to symmetry. */
typedef struct lw_choices {
    bool        ground;                /* choose the ground link                                          (true)  */
    const char *kinds;                 /* kinds of joints, of "rtpg"; NULL: as they are                   (NULL)  */
    int         inputs;                /* F driven joints: 0 none, 1 at the ground, 2 anywhere            (0)     */
    bool        output;                /* choose the output link                                          (false) */
} lw_choices;
LW_API lw_choices lw_choices_default(void);

/* visit NULL: count only.  *n, may be NULL: how many there are.  LW_E_ARG: choices that do not go together. */
LW_API lw_status lw_enumerate_mechanisms(const lw_mechanism *of, const lw_choices *choices,
                                         lw_mechanism_callback *visit, void *context, uint64_t *n, lw_error *error);

/* Every Assur group of pins with so many links (even): its Baranov truss, the link taken away, and the group. */
typedef lw_status lw_assur_group_visit(void *context, const lw_chain *truss, int lost, const lw_group_info *group);
LW_API lw_status lw_enumerate_groups(int links, int jobs, lw_assur_group_visit *visit, void *context, lw_error *error);

/* Everything that the rules of the published grammar reach with so many links; rules: "1234" or fewer; kinds: "r",
 * "t", "rt"; regions: only planar graphs, as the source demands. */
LW_API lw_status lw_enumerate_grammar(int links, const char *rules, const char *kinds, bool regions,
                                      lw_mechanism_callback *visit, void *context, lw_error *error);

/* ---- linkages ------------------------------------------------------------------------------------------------- */

typedef struct lw_joint_info {
    const char *name;                  /* NULL: by number                                                        */
    char        kind;                  /* r t p g f                                                              */
    int         link[2];               /* p: the pin of link[1] runs in a slot of link[0]                        */
    lw_vec2     at;                    /* pin; a point of the slide line; contact of a gear [m]                   */
    lw_vec2     along;                 /* t, p: direction of the slide line                                      */
    double      ratio;                 /* g: speed of link[1] over that of link[0], both against their carrier    */
} lw_joint_info;

typedef struct lw_input_info {
    int    joint;
    double value;                      /* in the given posture [rad] or [m]; NaN: as the posture says             */
    double first, last;                /* range wanted; equal: all of it                                        */
    double ratio;                      /* moves with input 0 so many times as far; 0: by itself                   */
} lw_input_info;

typedef struct lw_tracer_info {
    const char *name;                  /* NULL: by number                                                        */
    int         link;
    lw_vec2     at;                    /* in the given posture [m]                                                */
    double      angle;                 /* direction of a tool on the link [rad]                                   */
} lw_tracer_info;

/* From arrays: joints in one assembled posture.  `ground`: the fixed link.  LW_E_ARG with a text that names the
 * joint. */
LW_API lw_status lw_linkage_create(int n_link, int ground, int n_joint, const lw_joint_info *joint, int n_input,
                                   const lw_input_info *input, int n_tracer, const lw_tracer_info *tracer,
                                   lw_linkage **out, lw_error *error);

/* From text.  format: "json", "pyslvs", "adams", "pmks"; NULL: found from how it begins.  `file` is for messages,
 * may be NULL.  Of results, as `linkwright fit --json` prints them, the first is read.  LW_E_NOTATION with line and
 * column. */
LW_API lw_status lw_linkage_parse(const char *text, size_t size, const char *file, const char *format, lw_linkage **out,
                                  lw_error *error);
LW_API lw_status lw_linkage_load(const char *path, lw_linkage **out, lw_error *error);
/* Result number `which` (from 1) of a file of `linkwright fit --json`.  LW_E_ARG: the file has no such result. */
LW_API lw_status lw_linkage_load_result(const char *path, int which, lw_linkage **out, lw_error *error);
LW_API lw_status lw_linkage_copy(const lw_linkage *linkage, lw_linkage **out);
LW_API void      lw_linkage_destroy(lw_linkage *linkage);

/* As text or bytes of another program: "json", "pyslvs", "pmks", "adams", "acf", "mjcf", "dxf", "scad", "slvs",
 * "svg" (the curves of tracers), "poses" (CSV), "motiongen".  *size, may be NULL: without the terminator. 
 * LW_E_ARG: no such format; LW_E_KIND: the format cannot say this. */
LW_API lw_status lw_linkage_export(const lw_linkage *linkage, const char *format, char **out, size_t *size,
                                   lw_error *error);

/* The same into a file; format NULL: by the end of the name. */
LW_API lw_status lw_linkage_save(const lw_linkage *linkage, const char *format, const char *path, lw_error *error);

LW_API const char *lw_linkage_name(const lw_linkage *linkage);
LW_API void        lw_linkage_set_name(lw_linkage *linkage, const char *name);
LW_API int         lw_linkage_n_link(const lw_linkage *linkage);
LW_API int         lw_linkage_n_joint(const lw_linkage *linkage);
LW_API int         lw_linkage_n_input(const lw_linkage *linkage);
LW_API int         lw_linkage_n_tracer(const lw_linkage *linkage);
LW_API int         lw_linkage_ground(const lw_linkage *linkage);
LW_API const char *lw_linkage_link_name(const lw_linkage *linkage, int link);

/* LW_E_ARG: no such index. */
LW_API lw_status lw_linkage_joint(const lw_linkage *linkage, int joint, lw_joint_info *out);
LW_API lw_status lw_linkage_input(const lw_linkage *linkage, int input, lw_input_info *out);
LW_API lw_status lw_linkage_tracer(const lw_linkage *linkage, int tracer, lw_tracer_info *out);
LW_API lw_status lw_linkage_set_tracer(lw_linkage *linkage, int tracer, const lw_tracer_info *tracer_info,
                                       lw_error *error);

LW_API int       lw_linkage_mobility(const lw_linkage *linkage);                   /* Gruebler's count          */
LW_API lw_status lw_linkage_mechanism(const lw_linkage *linkage, lw_mechanism **out, lw_error *error);

/* A linkage of this topology with dimensions drawn by `seed`.  LW_E_ARG: no ground or no output. */
LW_API lw_status lw_linkage_of_mechanism(const lw_mechanism *mechanism, uint64_t seed, lw_linkage **out,
                                         lw_error *error);

/* Mirror in the x axis if so, then turn, scale and move: p becomes shift + size e^{i turn} p. */
LW_API void lw_linkage_lay(lw_linkage *linkage, bool mirrored, double turn, double size, lw_vec2 shift);

/* ---- motion --------------------------------------------------------------------------------------------------- */

/* The class of a four-bar and its motion, from its lengths (Barker 1985). */
typedef struct lw_fourbar_class {
    int         number;                /* 1 .. 14                                                                */
    const char *symbol;                /* "GCCC", "GCRR", ..., "CP3X"                                            */
    const char *name;                  /* "crank-rocker", ...                                                    */
    bool        grashof;               /* shortest + longest <= sum of the others, within the tolerance           */
    bool        crank;                 /* the input link turns fully                                             */
    bool        rocker_turns;          /* the output link turns fully                                            */
    double      change;                /* (s + l - p - q) / perimeter: 0 at a change point [1]                    */
    double      margin;                /* distance to the nearest change point [1]                               */
    int         circuits;              /* 1 or 2; 1 at a change point, where the two meet                         */
    int         n_limit;               /* limits of the input angle: 0, 2 or 4                                    */
    double      limit[4];              /* [rad], rising, in (-pi, pi], from the frame line                        */
    int         n_dead;                /* input angles at which the output cannot drive                           */
    double      dead[4];               /* [rad], rising, in (-pi, pi]                                             */
    double      transmission[2];       /* least and greatest transmission angle [rad], in [0, pi]                 */
    int         n_range;               /* ranges of the input, 1 or 2, rising                                     */
    double      range[2][2];           /* first, last [rad]; 2 pi apart: a full turn                              */
} lw_fourbar_class;

/* lengths: frame, input, coupler, output, in any unit.  Sums count as equal within tolerance * perimeter; 1e-12 is
 * usual. LW_E_ARG: a length that is not positive, or the linkage cannot be assembled. */
LW_API lw_status lw_fourbar_classify(const double lengths[4], double tolerance, lw_fourbar_class *out, lw_error *error);

/* The other two four-bars that trace the same coupler curve (Roberts).  in, out: r1 r2 r3 r4 cx cy x0 y0 theta0;
 * mode +1 or -1: side of the line from the crank pin to the rocker's ground pin on which the coupler's other pin
 * lies. LW_E_ARG: no four-bar; LW_E_NUMERIC: the point lies on a pin of the coupler. */
LW_API lw_status lw_fourbar_cognates(const double in[9], double mode, double out[2][9], double out_mode[2]);

/* Input angle and mode of both cognates where `in` has its input at `angle`.  LW_OPEN: it cannot close there. */
LW_API lw_status lw_fourbar_cognate_posture(const double in[9], double mode, double angle, double out_angle[2],
                                            double out_mode[2]);

/* A linkage prepared for evaluation at many inputs, in the assembly mode of its posture. */
typedef struct lw_kinematics lw_kinematics;

/* LW_E_KIND with a text: no plan is known for it; its motion curves (below) exist all the same. */
LW_API lw_status lw_kinematics_create(const lw_linkage *linkage, lw_kinematics **out, lw_error *error);
LW_API void      lw_kinematics_destroy(lw_kinematics *kinematics);

/* Input of the posture [rad] or [m].  Pins count here from the x axis of the ground frame (from the first ground
 * pin to the second, else along the first ground slide). */
LW_API double    lw_kinematics_input(const lw_kinematics *kinematics);

/* Turns of the linkage's input in one turn here: more than 1 with gears of fractional ratio. */
LW_API int       lw_kinematics_turns(const lw_kinematics *kinematics);

/* Dimensions: "r1", "cx", "theta0", ... (docs/conventions.md).  Changing one keeps the topology and the assembly
 * mode. */
LW_API int         lw_kinematics_n_dimension(const lw_kinematics *kinematics);
LW_API const char *lw_kinematics_dimension_name(const lw_kinematics *kinematics, int i);
LW_API double      lw_kinematics_dimension(const lw_kinematics *kinematics, int i);
LW_API lw_status   lw_kinematics_set_dimension(lw_kinematics *kinematics, int i, double value);

/* One posture with derivatives by the input: [k*(order + 1) + d], derivative d = 0 .. order (at most 3).  Arrays
 * may be NULL: joint (n_joint), link_angle (n_link), tracer (n_tracer).  *margin, may be NULL: squared sine of the
 * least transmission angle, negative where it cannot close.  LW_OPEN: positions are those of the nearest posture,
 * derivatives 0. */
LW_API lw_status lw_kinematics_posture(const lw_kinematics *kinematics, double input, int order, lw_vec2 *joint,
                                       double *link_angle, lw_vec2 *tracer, double *margin);

/* How one link moves against another at one moment.  Its instant centre is at rest on both; it rolls the moving
 * centrode on the fixed one as the input moves.  Points of the link on the circle whose diameter goes from `centre` to
 * `inflection` pass an inflection of their path. */
typedef struct lw_instant_motion {
    lw_vec2 centre, inflection;        /* [m]; NaN: the links only shift against each other                      */
    double  turn;                      /* relative angular velocity by the input [rad/rad] or [rad/m]             */
} lw_instant_motion;

/* The motion of `link` seen from `base`.  LW_OPEN as lw_kinematics_posture; LW_E_ARG: no such links; LW_E_KIND: a link
 * has neither a pin nor a tracer. */
LW_API lw_status lw_kinematics_instant(const lw_kinematics *kinematics, double input, int link, int base,
                                       lw_instant_motion *out);

/* A place that a path passes twice; first, second: when, in steps from its first point. */
typedef struct lw_double_point { lw_vec2 at; double first, second; } lw_double_point;

/* Double points of the path through n points at even steps, x and y (n), in the order of their first passage; at most `most`.
 * Returns their number, or -1: out of memory.  Between points the path is a cubic: take steps of a degree or two. */
LW_API int lw_path_double_points(size_t n, const double *x, const double *y, lw_double_point *out, int most);

/* Points of one tracer at n inputs.  x, y (n) [m]; angle (n) of its link, margin (n): may be NULL.  No memory is
 * allocated.  Inputs where it cannot close have a negative margin. */
LW_API lw_status lw_kinematics_trace(lw_kinematics *kinematics, int tracer, size_t n, const double *input, double *x,
                                     double *y, double *angle, double *margin);

/* A linkage in the posture at this input.  LW_OPEN: it cannot close there. */
LW_API lw_status lw_kinematics_linkage(const lw_kinematics *kinematics, double input, lw_linkage **out,
                                       lw_error *error);

/* Where the input can stand, in every assembly mode. */
typedef struct lw_input_range {
    double first, last;                /* [rad] or [m]                                                           */
    bool   turns;                      /* a full turn                                                            */
    bool   limit[2];                   /* first, last: the motion ends there and goes back in another mode        */
    int    circuit;                    /* ranges of one circuit can be reached from each other                    */
    bool   own;                        /* the one that holds the posture                                          */
    double transmission[2];            /* least and greatest transmission angle [rad]                             */
} lw_input_range;
typedef lw_status lw_range_visit(void *context, const lw_input_range *range);

/* LW_E_KIND: higher Assur groups; see the motion curves.  LW_OPEN: it closes nowhere. */
LW_API lw_status lw_kinematics_ranges(const lw_kinematics *kinematics, lw_range_visit *visit, void *context);

/* The groups in the order of solution and how each is solved, as text. */
LW_API lw_status lw_kinematics_explain(const lw_kinematics *kinematics, char **out);

/* Every motion of any linkage with one free input, as curves: one for each circuit, through all assembly modes. */
typedef struct lw_motion_curves lw_motion_curves;

/* Curves are found from random postures; ends after `patience` postures without a new curve.  Same seed, same curves.
 * The first holds the posture of the linkage.  LW_E_ARG: not one free input; LW_E_NUMERIC: it cannot move. */
LW_API lw_status lw_motion_curves_create(const lw_linkage *linkage, int patience, uint64_t seed, lw_motion_curves **out,
                                         lw_error *error);
LW_API void      lw_motion_curves_destroy(lw_motion_curves *curves);
LW_API int       lw_motion_curves_count(const lw_motion_curves *curves);

typedef struct lw_motion_curve_info {
    bool   closed;                     /* the motion comes back to where it began                                */
    int    input_turns;                /* whole turns of the input over a closed curve                           */
    int    limits;                     /* where the input turns back                                             */
    int    crossings;                  /* branch points                                                          */
    double residual;                   /* greatest error of the constraints [m]                                  */
} lw_motion_curve_info;
LW_API lw_status lw_motion_curves_info(const lw_motion_curves *curves, int curve, lw_motion_curve_info *out);

/* n points evenly by arc over a whole curve.  input, x, y (n): of the input and of a tracer; each may be NULL. */
LW_API lw_status lw_motion_curves_trace(lw_motion_curves *curves, int curve, int tracer, size_t n, double *input,
                                        double *x, double *y);

/* How freely a linkage moves, found by moving it: lengths count, unlike in Gruebler's count. */
typedef struct lw_mobility_info {
    const char *kind;                  /* "rigid", "shaky", "moves"                                               */
    int         count;                 /* Gruebler's count                                                       */
    int         freedom;               /* of the motion through the posture                                      */
    int         generic;               /* of the same topology with general dimensions; -1: unknown               */
    int         instant;               /* freedoms of first order in the posture                                 */
    int         redundant;             /* constraints that follow from others                                    */
    int         driven, idle;          /* freedoms that inputs set; that neither inputs nor tracers notice         */
    double      residual;              /* greatest error of the constraints on the way [m]                        */
} lw_mobility_info;

/* tolerance: of closing, over the size of the linkage; 1e-12 is usual, 1e-4 the greatest. */
LW_API lw_status lw_linkage_analyse_mobility(const lw_linkage *linkage, double tolerance, uint64_t seed,
                                             lw_mobility_info *out, lw_error *error);

/* Weld joints until no freedom is idle; *joints: those joints as bits. */
LW_API lw_status lw_mobility_hold_idle(lw_linkage *linkage, uint64_t *joints, lw_error *error);

/* ---- forces and dynamics ---------------------------------------------------------------------------------------- */

typedef struct lw_model lw_model;              /* a linkage with masses, loads, springs, motions, clearances      */
typedef struct lw_simulation lw_simulation;

/* From a linkage without masses and loads; from JSON text or file (docs/notation.md, "Model"). */
LW_API lw_status lw_model_create(const lw_linkage *linkage, lw_model **out);
LW_API lw_status lw_model_parse(const char *text, size_t size, const char *file, lw_model **out, lw_error *error);
LW_API lw_status lw_model_load(const char *path, lw_model **out, lw_error *error);
LW_API void      lw_model_destroy(lw_model *model);
/* Belongs to the model.  NULL: it has more than 32 links, 64 joints, 8 inputs or 16 tracers; its parts are below.  Rotors of motors that are links of
 * their own (docs/notation.md, "States") are links of the model alone, behind the others, with their joints. */
LW_API const lw_linkage *lw_model_linkage(const lw_model *model);

/* The parts of a model of any size, as those of a linkage.  Indices are those of samples. */
LW_API int         lw_model_n_link(const lw_model *model);
LW_API int         lw_model_n_joint(const lw_model *model);
LW_API int         lw_model_n_input(const lw_model *model);
LW_API int         lw_model_n_tracer(const lw_model *model);
LW_API int         lw_model_ground(const lw_model *model);
LW_API const char *lw_model_link_name(const lw_model *model, int link);
LW_API lw_status   lw_model_joint(const lw_model *model, int joint, lw_joint_info *out);
LW_API lw_status   lw_model_input(const lw_model *model, int input, lw_input_info *out);
LW_API lw_status   lw_model_tracer(const lw_model *model, int tracer, lw_tracer_info *out);

/* Sizes of plates in drawings for cutting and in solids [m]; 0, and for the clearance a value below 0: the usual
 * ones.  */
typedef struct lw_plate_options {
    double width;                      /* of a bar                                                                */
    double thickness;
    double hole;                       /* diameter of holes, width of slots                                       */
    double clearance;                  /* a pin's diameter is smaller than its hole by this                       */
} lw_plate_options;

/* As lw_linkage_export, with masses and loads where the format holds them (mjcf, adams, acf, urdf, sdf) and plates of
 * these sizes (dxf, scad, step, stl); plates NULL: the usual sizes.  LW_E_KIND: the format cannot say this. */
LW_API lw_status lw_model_export(const lw_model *model, const char *format, const lw_plate_options *plates, char **out,
                                 size_t *size, lw_error *error);

/* Move an input by an expression of t: "0.5 + 10*t" [rad] or [m].  LW_E_NOTATION with the column. */
LW_API lw_status lw_model_drive(lw_model *model, int input, const char *motion, lw_error *error);
LW_API lw_status lw_model_set_speed(lw_model *model, int input, double speed);     /* at the start, then free     */
/* LW_E_ARG: a mass below 0, or an elastic link, whose mass is that of its section and material. */
LW_API lw_status lw_model_set_mass(lw_model *model, int link, double mass, lw_vec2 centre, double inertia);
LW_API void      lw_model_set_gravity(lw_model *model, lw_vec2 gravity);           /* [m/s^2]                     */

/* Motion of a link: its centre of mass [m], [m/s]; its angle since the drawn posture [rad], [rad/s].  0 for ground. */
typedef struct lw_link_motion { lw_vec2 place, velocity; double angle, angular_velocity; } lw_link_motion;

/* Acceleration of the centre of mass [m/s^2] and of the angle [rad/s^2]. */
typedef struct lw_link_acceleration { lw_vec2 linear; double angular; } lw_link_acceleration;

/* Load on a link: a force on its centre of mass [N] and a torque [N m], counter-clockwise. */
typedef struct lw_link_load { lw_vec2 force; double torque; } lw_link_load;

/* Forces of the caller's own, added to those of the model.
 *
 * `apply` is called in every evaluation, several times a step and not in the order of time.  It reads the motion of
 * the links and writes their loads, which are 0 before; both arrays (n_link) are in the order of the model's links, and
 * the load on ground is ignored.  The loads must depend on t and on `link` alone, smoothly.  Their work counts in the
 * energy balance.  Where derivatives are wanted (equilibrium, implicit methods) they are taken by central differences; in
 * models of more than 32 links only those of each load by the motion of its own link. */
typedef struct lw_caller_force {
    void *context;
    void (*apply)(void *context, double t, const lw_link_motion *link, lw_link_load *load);
} lw_caller_force;

/* Receives what is to be said about a run: sentences without a line end, valid during the call, as the program prints them.  What was assumed, how
 * accurate it is, which events it had. */
typedef struct lw_note_sink {
    void *context;
    void (*say)(void *context, const char *text);
} lw_note_sink;

/* Force and moment of a joint on its link[1], about the joint's point on that link (of a gear: on the carrier), without its friction,
 * springs, motors and drives. */
typedef struct lw_reaction { lw_vec2 force; double moment; } lw_reaction;     /* [N] [N m]             */

typedef struct lw_simulation_options {
    const char    *analysis;           /* transient static quasistatic kinematic dynamic            ("transient") */
    const char    *formulation;        /* auto driven quadrature reduced capture index1 cvode ggl radau alpha recursive */
    double         from, to;           /* time [s]                                                  (0, 1)        */
    int            intervals;          /* samples less one, evenly spaced                           (100)         */
    double         tolerance;          /* of a step, lengths over the size of the linkage           (1e-10)       */
    long           max_steps;          /* 0: no limit                                               (0)           */
    double         max_seconds;        /* 0: no limit                                               (0)           */
    const volatile int *stop;          /* *stop not 0 ends the run; may be set by a signal          (NULL)        */
    lw_caller_force force;             /* apply NULL: none                                          (NULL)        */
    bool           rigid;              /* elastic links as rigid bars of the same mass              (false)       */
    bool           once;               /* do not repeat runs with contacts for the estimate of their error (false) */
    lw_note_sink   note;               /* say: called after a run, or after each advance of a stepper (NULL)      */
} lw_simulation_options;
LW_API lw_simulation_options lw_simulation_options_default(void);

/* A node of an elastic link (docs/notation.md, "Elastic links"), with the forces inside the bar there. */
typedef struct lw_elastic_node {
    int     link, number;              /* from 0 along its axis                                                    */
    lw_vec2 at;                        /* [m]                                                                      */
    double  turn;                      /* since the posture of the file [rad]                                      */
    double  normal, shear, bending;    /* tension and shear force [N], bending moment [N m]                         */
    double  stress;                    /* N/A + M/W, of the greater absolute value [N/m^2]                          */
} lw_elastic_node;

typedef struct lw_simulation_sample {
    double                      t;
    const lw_link_motion       *link;            /* (n_link); of an elastic link: its node 0                     */
    const lw_link_acceleration *acceleration;    /* (n_link)                                                    */
    const lw_reaction          *joint;           /* (n_joint)                                                   */
    const double               *input;           /* [rad] or [m] (n_input)                                      */
    const double               *drive;           /* torque or force that moves the input (n_input)               */
    const lw_vec2              *tracer;          /* (n_tracer) [m]                                               */
    const double               *state;           /* first-order states (lw_model_n_state)                      */
    lw_reaction                 shaking;         /* of moving masses on the frame, about the origin               */
    double                      kinetic, potential, work;      /* [J]                                            */
    double                      residual;        /* of the constraints, over the size of the linkage              */
    int                         n_node;          /* of all elastic links, link by link                            */
    const lw_elastic_node      *node;            /* (n_node)                                                      */
} lw_simulation_sample;
typedef lw_status lw_simulation_callback(void *context, const lw_simulation_sample *sample);

typedef struct lw_simulation_report {
    const char *formulation;           /* that was used                                                          */
    char        why[256];              /* why this one                                                           */
    int         freedom, unknowns, redundant;
    long        steps, refused, evaluations;
    double      t;                     /* how far it came [s]                                                     */
    double      energy_error;          /* greatest |E - E(start) - work| [J]                                       */
    double      residual;
    /* Planar models with contacts, unless max_seconds is set: how far places [m] and angles [rad] are from those of a second run at a tolerance
     * of coarse_tolerance, as far as it came; of a stepper at the ends of its pieces.  0: there was none. */
    double      coarse_tolerance, place_off, turn_off;
} lw_simulation_report;

/* The model must outlive the simulation.  LW_E_ARG: a mass is missing; LW_E_KIND: the formulation cannot do this model;
 * LW_OPEN, LW_E_NUMERIC: no start satisfies the constraints. */
LW_API lw_status lw_simulation_create(const lw_model *model, const lw_simulation_options *options, lw_simulation **out,
                                      lw_error *error);
LW_API void      lw_simulation_destroy(lw_simulation *simulation);

/* Run from start to end, once; analysis "static": one sample, where it rests.  visit, report may be NULL.  What was
 * sampled before a failure is valid.  LW_STOPPED: a limit of steps or seconds. */
LW_API lw_status lw_simulation_run(lw_simulation *simulation, lw_simulation_callback *visit, void *context,
                                   lw_simulation_report *report, lw_error *error);

/* First-order states of a model (docs/notation.md, "States"), in the order of samples; -1: there is none. */
LW_API int         lw_model_n_state(const lw_model *model);
LW_API const char *lw_model_state_name(const lw_model *model, int state);          /* belongs to the model          */
LW_API int         lw_model_find_state(const lw_model *model, const char *name);

/* A simulation in pieces: go on to a time, read, change loads and states, go on.
 *
 * What follows depends on the present (posture, velocities, states, loads held) alone, so a run that is saved and
 * restored goes on with the same bits.  A state whose rate is 0 serves as a parameter that forces, voltages and
 * controllers use and the program sets. */
typedef struct lw_stepper lw_stepper;

/* Starts at options->from; `to` and `intervals` are not used.  The model must outlive the stepper.  Errors as of
 * lw_simulation_create; LW_E_KIND also for an analysis that is no run in time. */
LW_API lw_status lw_stepper_create(const lw_model *model, const lw_simulation_options *options, lw_stepper **out,
                                   lw_error *error);
LW_API void      lw_stepper_destroy(lw_stepper *stepper);

/* Go on to t; a t that is not later than the present computes the present sample again, with the loads of now.  After a
 * failure the stepper stands where it was. */
LW_API lw_status lw_stepper_advance(lw_stepper *stepper, double t, lw_error *error);

/* The present: as of the last lw_stepper_advance.  Holds until the next one.  NULL: the model is spatial. */
LW_API const lw_simulation_sample *lw_stepper_sample(const lw_stepper *stepper);

/* The report of all pieces of this stepper so far: steps and evaluations are sums; energy_error is the sum of the errors of the pieces. */
LW_API void lw_stepper_report(const lw_stepper *stepper, lw_simulation_report *out);

/* From now on this load acts on a link, besides all others; set a state.  LW_E_ARG: no such link or state; not
 * finite; a spatial model (lw_spatial_stepper_set_load). */
LW_API lw_status lw_stepper_set_load(lw_stepper *stepper, int link, lw_link_load load);
LW_API lw_status lw_stepper_set_state(lw_stepper *stepper, int state, double value);

/* The present as bytes, which the caller frees with lw_free; back to it.  LW_E_NOTATION: no saved run, a
 * damaged one, or one of another model; the stepper is unchanged. */
LW_API lw_status lw_stepper_save(const lw_stepper *stepper, char **out, size_t *size);
LW_API lw_status lw_stepper_restore(lw_stepper *stepper, const void *bytes, size_t size, lw_error *error);

typedef struct lw_vibration_info {
    double re, im;                     /* eigenvalue [1/s], im >= 0                                              */
    double frequency, natural;         /* damped and natural frequency [Hz]                                      */
    double damping;                    /* ratio; < 0: grows                                                      */
} lw_vibration_info;
typedef lw_status lw_vibration_callback(void *context, const lw_vibration_info *vibration);

/* Small vibrations about the drawn posture, or with `rest` about the equilibrium near it; inputs with a motion are
 * held, with `hold` all inputs.  LW_NOTHING: no freedom is left. */
LW_API lw_status lw_model_vibrations(const lw_model *model, bool rest, bool hold, lw_vibration_callback *visit,
                                     void *context, lw_error *error);

/* ---- models in space ---- */

typedef struct lw_spatial lw_spatial;          /* bodies and joints in space (docs/notation.md, "Spatial model")   */

/* Has a place three numbers in this text, or a joint a kind that only space has? */
LW_API bool      lw_spatial_text(const char *text, size_t size);
LW_API lw_status lw_spatial_parse(const char *text, size_t size, const char *file, lw_spatial **out, lw_error *error);
LW_API lw_status lw_spatial_load(const char *path, lw_spatial **out, lw_error *error);
LW_API void      lw_spatial_destroy(lw_spatial *model);

/* Number and name of the parts: what is 'l' links (the ground too), 'j' joints, 'i' inputs, 'd' drives, 't' tracers,
 * 'c' couplings. The name of an input or drive is that of its joint or tracer.  NULL: there is no such part. */
LW_API int         lw_spatial_count(const lw_spatial *model, char what);
LW_API const char *lw_spatial_name(const lw_spatial *model, char what, int index);

/* As text of another program: "mjcf", "adams", "acf".  *size, may be NULL: without the terminator.  LW_E_ARG: no such
 * format; LW_E_KIND: the format cannot say this. */
LW_API lw_status lw_spatial_export(const lw_spatial *model, const char *format, char **out, size_t *size,
                                   lw_error *error);

/* Move an input by an expression of t: "0.5 + 10*t" [rad] or [m].  LW_E_NOTATION with the column. */
LW_API lw_status lw_spatial_set_motion(lw_spatial *model, int input, const char *motion, lw_error *error);

/* Degrees of freedom; generic is -1, driven is 0; idle: spins of links between ball joints. */
LW_API lw_status lw_spatial_analyse_mobility(const lw_spatial *model, double tolerance, uint64_t seed,
                                             lw_mobility_info *out, lw_error *error);

/* How a point with axes moves: rates by time, or by the input [1/rad] or [1/m]; all in ground axes. */
typedef struct lw_frame_motion {
    lw_vec3 place, velocity, acceleration;       /* [m] [m/s] [m/s^2]                                             */
    lw_quaternion turn;                          /* of a tracer's axes; of a link since the posture of the file   */
    lw_vec3 omega, alpha;                        /* angular velocity and acceleration [rad/s] [rad/s^2]            */
} lw_frame_motion;

/* One row of a trace: at: the first input [rad] or [m], or the time [s]; input (n_input); tracer (n_tracer), whose rates are NAN at a limit of
 * the input. */
typedef lw_status lw_spatial_trace_callback(void *context, double at, const double *input,
                                            const lw_frame_motion *tracer);

/* Follow the tracers: in time by the motions of all inputs, or over the first input while the others stand still;
 * from == to: over its range in the file, or as far as it goes.  Steps never jump to another branch.  LW_OPEN: a
 * limit or a singular posture lies before the end (the text says where, and how far which joint stays open);
 * LW_E_ARG: the inputs do not fit the freedoms. */
LW_API lw_status lw_spatial_trace(const lw_spatial *model, bool in_time, double from, double to, int intervals,
                                  lw_spatial_trace_callback *visit, void *context, lw_error *error);

/* Force [N] and moment [N m] of a joint on its link[1], about the joint's point on that link. */
typedef struct lw_spatial_reaction { lw_vec3 force, moment; } lw_spatial_reaction;

typedef struct lw_spatial_sample {
    double                     t;
    const lw_frame_motion     *link;             /* (n_link) of the centres of mass; 0 for the ground             */
    const lw_frame_motion     *tracer;           /* (n_tracer)                                                    */
    const lw_spatial_reaction *joint;            /* (n_joint)                                                     */
    const double              *input, *rate;     /* (n_input) [rad] or [m], per second                            */
    const double              *drive;            /* torque or force of each drive, or input without drives        */
    double                     kinetic, potential, work;   /* [J]; work NaN where every freedom is driven         */
    double                     residual;         /* of the constraints, over the size of the model                */
    const double              *coupling;         /* (n_coupling) times a factor: force [N] or torque [N m] that the coupling
                                                    puts on the second link of the joint                          */
} lw_spatial_sample;
typedef lw_status lw_spatial_callback(void *context, const lw_spatial_sample *sample);

/* Run a model, as lw_simulation_run; analysis "static": one sample.  Formulations: auto, driven,
 * recursive, index1, cvode, ggl, radau, alpha.
 * LW_E_KIND: a force of the caller's own in the options, which spatial models do not know. */
LW_API lw_status lw_spatial_simulate(const lw_spatial *model, const lw_simulation_options *options,
                                     lw_spatial_callback *visit, void *context, lw_simulation_report *report,
                                     lw_error *error);

/* The slowest vibrations about an equilibrium, as lw_model_vibrations.  LW_E_ARG: the drawn posture is none (see `rest`), or
 * a link has no mass. */
LW_API lw_status lw_spatial_vibrations(const lw_spatial *model, bool rest, bool hold, lw_vibration_callback *visit,
                                       void *context, lw_error *error);

/* A model in space in pieces: lw_stepper_advance, _save, _restore, _destroy as of planar ones; it has no states to set.  The
 * sample holds until the next advance.  A load acts besides all others until it is changed: force at the centre of mass (of
 * an elastic link: at its first node) [N] and torque [N m], in ground axes.  Errors as of lw_spatial_simulate and of planar
 * steppers.  A stepper of the other kind: NULL, LW_E_ARG. */
typedef struct lw_frame_load { lw_vec3 force, torque; } lw_frame_load;
LW_API lw_status lw_spatial_stepper_create(const lw_spatial *model, const lw_simulation_options *options, lw_stepper **out,
                                           lw_error *error);
LW_API const lw_spatial_sample *lw_spatial_stepper_sample(const lw_stepper *stepper);
LW_API lw_status lw_spatial_stepper_set_load(lw_stepper *stepper, int link, lw_frame_load load);

/* Pins with clearance, as the model file gives them ("clearance" of a joint). */
typedef struct lw_clearance_settings {
    double time, settle;               /* run from 0 to time; contact counts after settle [s]       (1.25, 0.4)   */
    double tolerance;                  /* of a step, lengths over the size of the linkage           (1e-9)        */
    double speed;                      /* of input 0 at the start [rad/s] or [m/s]; NaN: the model's  (NaN)       */
    const char *start;                 /* closed: all links move as without clearance; seated: pins pressed as the
                                        * reaction asks; crank: only the driven link moves          ("closed")    */
    double every;                      /* time between samples [s]; 0: none                         (0)           */
    long   max_steps;                  /* 0: no limit                                               (0)           */
    double max_seconds;                /* 0: no limit                                               (0)           */
    const volatile int *stop;          /* *stop not 0 ends the run; may be set by a signal          (NULL)        */
} lw_clearance_settings;
LW_API lw_clearance_settings lw_clearance_settings_default(void);

/* One joint at one moment. */
typedef struct lw_clearance_point {
    int     joint;
    lw_vec2 pin;                     /* centre of the pin from that of the bush, in the plane [m]     */
    lw_vec2 in_bush;                 /* the same in the frame of the bush's link                      */
    double  force;                   /* [N], > 0 presses pin and bush together                        */
    double  rate;                    /* of the pin's distance [m/s]                                   */
    bool    touching;
} lw_clearance_point;
typedef lw_status lw_clearance_callback(void *context, double t, double input, double energy, int n_point,
                                        const lw_clearance_point *point);

/* Contact of one joint after the time `settle`. */
typedef struct lw_clearance_outcome {
    int    joint;
    bool   lost;                     /* the distance fell to the gap (link: the force to 0; zero: criterion > 1) */
    double first;                    /* when first [s]; NaN: never                                     */
    long   losses;                   /* how often contact was left                                     */
    double apart;                    /* share of the time without contact                              */
    double force_most;               /* of ends of steps, and of seven places within those that come near it [N] */
    double distance_most;            /* of the centres [m]                                             */
    double criterion;                /* zero: greatest |d direction of reaction/dt| / reaction [rad/(N s)], Earles &
                                        Wu 1977: contact is kept below 1 */
} lw_clearance_outcome;

/* outcome (room): of each joint with clearance; *n: how many there are.  LW_E_ARG with a text: no joint with
 * clearance, a missing mass; LW_STOPPED: a limit. */
LW_API lw_status lw_simulate_clearance(const lw_model *model, const lw_clearance_settings *settings,
                                       lw_clearance_callback *visit, void *context, lw_clearance_outcome *outcome,
                                           int room, int *n, lw_error *error);

/* The same over speeds of input 0 and laws of contact, each law at each speed, on several threads. */
typedef struct lw_sweep_request {
    int           n_model, n_stiffness, n_damping, n_speed;
    const char *const *model;          /* zero link mlsd impact ...; n_model 0: the model's own */
    const double *stiffness, *damping; /* [N/m], [N s/m]; none: the model's                                      */
    const double *speed;               /* [rad/s] or [m/s], 1 or more, rising                                    */
    double        refine;              /* > 0: halve the limits of contact to this width [rad/s] or [m/s]         */
    int           jobs;                /* threads; below 1: one for each core                                    */
} lw_sweep_request;

typedef struct lw_sweep_result {
    const char *model;                 /* the law: model, stiffness, damping of the first joint with clearance     */
    double      stiffness, damping, speed;
    lw_status   status;                /* LW_STOPPED: a limit came first                                         */
    const char *why;                   /* of a failure                                                          */
    int         n_outcome;
    const lw_clearance_outcome *outcome;
} lw_sweep_result;
typedef lw_status lw_sweep_callback(void *context, const lw_sweep_result *result);

/* Speeds between which one joint loses contact and has it again as the speed rises; NaN: not within the sweep. */
typedef struct lw_contact_limits {
    const char *model;
    double      stiffness, damping;
    int         joint;
    double      kept, lost;            /* first pair of neighbouring speeds with and without contact               */
    double      lost_again, kept_again;            /* last pair the other way round                              */
} lw_contact_limits;
typedef lw_status lw_contact_limits_callback(void *context, const lw_contact_limits *limits);

/* settings->speed and ->every are not used.  visit, see_limits may be NULL. */
LW_API lw_status lw_sweep_clearance(const lw_model *model, const lw_clearance_settings *settings,
                                    const lw_sweep_request *request, lw_sweep_callback *visit,
                                    lw_contact_limits_callback *see_limits, void *context, lw_error *error);

typedef struct lw_counterweight {
    int     link, joint;                  /* the link that carries it; the pin it is measured from        */
    double  product;                      /* mass times distance from the pin [kg m]                     */
    double  mass;                         /* as far from the pin as the other joints of the link are [kg]  */
    lw_vec2 at;                           /* there, in the drawn posture [m]                             */
} lw_counterweight;
typedef lw_status lw_counterweight_callback(void *context, const lw_counterweight *weight);

/* Run the simulation and find counterweights that hold the common centre of mass still, which nulls the shaking
 * force. *before, *after: RMS deviation of total mass times that centre from its mean [kg m].  LW_E_KIND: no link
 * turns about a ground pin; LW_E_ARG: too few samples. */
LW_API lw_status lw_simulation_balance(lw_simulation *simulation, lw_counterweight_callback *visit, void *context,
                                       double *before, double *after, lw_error *error);

/* ---- drives: what a cycle asks of them, and which can do it (docs/drive.md) ------------------------------------- */

/* Evenly spaced samples of a cycle of one drive.  Torque and speed of the same sign drive the load.  Of a drive that slides
 * they are a force [N] and [m/s], and a transmission then has radians of the motor per metre. */
typedef struct lw_load {
    char          name[64];
    bool          slides;
    size_t        n;
    double        step;                      /* [s]                                                                  */
    const double *speed, *torque, *acceleration;         /* (n)                                                      */
    double        inertia[2];                /* least and greatest reflected inertia [kg m^2] or [kg]; NaN: not known */
    const double *kink;                      /* (n) where the motion has a kink in the interval before each sample, as a share of the
                                              * interval, and where the torque may step; 0: nowhere.  NULL: none */
} lw_load;

typedef struct lw_loads { int n; lw_load *load; void *memory; } lw_loads;

/* The loads of all drives of a model that moves as its inputs prescribe, by inverse dynamics.  Every freedom must be driven.
 * *out is freed with lw_loads_free, also after a failure. */
LW_API lw_status lw_model_loads(const lw_model *model, double from, double to, int intervals, lw_loads *out, lw_error *error);
LW_API lw_status lw_spatial_loads(const lw_spatial *model, double from, double to, int intervals, lw_loads *out,
                                  lw_error *error);
LW_API void      lw_loads_free(lw_loads *loads);

typedef struct lw_load_figures {
    double torque_peak, torque_rms, speed_peak, power_peak, power_mean, power_least;
    double energy_out, energy_back;          /* of the drive into the load; from the load into the drive [J]         */
} lw_load_figures;

/* Torque and power are taken as straight between two samples, and up to a kink and from there. */
LW_API lw_load_figures lw_load_figures_of(const lw_load *load);

typedef struct lw_drive_parts lw_drive_parts;            /* motors, gears and amplifiers                              */

/* Add the parts of a table (CSV) or a catalogue (SQLite) to *parts; NULL there makes a new list. */
LW_API lw_status   lw_drive_parts_load(const char *path, lw_drive_parts **parts, lw_error *error);
LW_API void        lw_drive_parts_destroy(lw_drive_parts *parts);
/* Number and names of motors ('m'), gears ('g'), amplifiers ('a'). */
LW_API int         lw_drive_parts_count(const lw_drive_parts *parts, char kind);
LW_API const char *lw_drive_parts_name(const lw_drive_parts *parts, char kind, int i);

/* Limits that a choice exceeds: bits of lw_drive_choice.fails. */
#define LW_DRIVE_LIMIT_LIST(X) \
    X(SPEED,          "speed of the motor") \
    X(PEAK,           "peak torque of the motor") \
    X(RMS,            "continuous torque of the motor") \
    X(GEAR_SPEED,     "speed of the gear") \
    X(GEAR_PEAK,      "peak torque of the gear") \
    X(GEAR_RMS,       "continuous torque of the gear") \
    X(VOLTAGE,        "voltage of the amplifier") \
    X(CURRENT,        "peak current of the amplifier") \
    X(CURRENT_RMS,    "continuous current of the amplifier") \
    X(HEAT,           "i^2 t of the amplifier") \
    X(INERTIA,        "inertia ratio")
enum {
#define X(name, text) LW_DRIVE_##name,
    LW_DRIVE_LIMIT_LIST(X)
#undef X
    LW_DRIVE_N_LIMIT
};
LW_API const char *lw_drive_limit_text(int limit);

typedef struct lw_drive_choice {
    int      motor, gear, amplifier;         /* of the lists; -1: no gear, or no amplifier, is in the lists          */
    double   ratio;                          /* motor angle over load angle, or [rad/m]                              */
    double   speed, torque_peak, torque_rms; /* of the motor [rad/s] [N m]                                           */
    double   current_peak, current_rms;      /* [A]                                                                  */
    double   voltage;                        /* greatest R I + Kt w + L dI/dt [V]                                    */
    int      torque_steps;                   /* places where the torque steps, and L dI/dt is left out               */
    double   heat;                           /* of the winding, mean [W]                                             */
    double   i2t;                            /* greatest charge of the amplifier, over what it allows                */
    double   inertia_ratio;                  /* load, greatest, over motor and gear; NaN                             */
    double   use[LW_DRIVE_N_LIMIT];          /* what is used of each limit; NaN: no such limit                       */
    double   worst;                          /* greatest of use: <= 1 can do it                                      */
    unsigned fails;
    double   cost;                           /* price of all, or mass [kg] if no price is given, or rated power [W]  */
} lw_drive_choice;

/* All choices, the best first: those that can do it by cost and then by `worst`; then the others by `worst`.  *out and *front
 * are freed with lw_free.  front[i]: no other choice that can do it is both cheaper and less used.  greatest_inertia: limit of
 * the inertia ratio; infinite: none.  LW_STOPPED: *stop became nonzero (stop may be NULL), and *out holds the choices tried until
 * then. */
LW_API lw_status lw_drive_choose(const lw_load *load, const lw_drive_parts *parts, double greatest_inertia, const volatile int *stop,
                                 size_t *n, lw_drive_choice **out, bool **front, lw_error *error);

/* ---- product families ------------------------------------------------------------------------------------------- */

typedef struct lw_master lw_master;            /* a master file with parameters, constant once read (docs/family.md)  */
typedef struct lw_variant lw_variant;          /* one choice of its parameters; it needs the master                  */

/* LW_E_NOTATION with line and column, also for unknown names, circular parameters, parts that use themselves. */
LW_API lw_status lw_master_parse(const char *text, size_t size, const char *file, lw_master **out, lw_error *error);
LW_API lw_status lw_master_load(const char *path, lw_master **out, lw_error *error);
LW_API void      lw_master_destroy(lw_master *master);

/* Names: the i-th parameter, configuration or view; NULL past the last one. */
LW_API const char *lw_master_parameter_name(const lw_master *master, int i);
LW_API const char *lw_master_configuration(const lw_master *master, int i);
LW_API const char *lw_master_view(const lw_master *master, int i);
/* Unit ("": none) and range of a parameter, in that unit; infinite without a range.  LW_E_ARG: no such parameter. */
LW_API lw_status lw_master_parameter_unit(const lw_master *master, int i, const char **unit, double range[2]);

/* The defaults of the master.  Then choose: values set one by one stand above those of the configuration.  value: a
 * number in the unit of the parameter or "3.2 m", a text, true or false.  NULL: no configuration, the master's own
 * view. */
LW_API lw_status lw_variant_create(const lw_master *master, lw_variant **out);
LW_API void      lw_variant_destroy(lw_variant *variant);
LW_API lw_status lw_variant_configure(lw_variant *variant, const char *configuration, lw_error *error);
LW_API lw_status lw_variant_look(lw_variant *variant, const char *view, lw_error *error);
LW_API lw_status lw_variant_set(lw_variant *variant, const char *parameter, const char *value, lw_error *error);

/* A formula over parameters and derived values, in SI or in the unit after `as`: "2*reach as mm". */
LW_API lw_status lw_variant_number(lw_variant *variant, const char *formula, double *out, lw_error *error);
/* LW_E_NOTATION with the place and both sides of the first check of the master that does not hold. */
LW_API lw_status lw_variant_hold_checks(lw_variant *variant, lw_error *error);
/* The model file, to be freed with lw_free; the model itself, planar or spatial (LW_E_KIND: it is of the other sort, see
 * lw_spatial_text).  Errors name places of the master. */
LW_API lw_status lw_variant_text(lw_variant *variant, char **out, size_t *size, lw_error *error);
LW_API lw_status lw_variant_model(lw_variant *variant, lw_model **out, lw_error *error);
LW_API lw_status lw_variant_spatial(lw_variant *variant, lw_spatial **out, lw_error *error);

/* ---- targets ---------------------------------------------------------------------------------------------------- */

typedef struct lw_target lw_target;            /* stations that a point, or an output angle, has to meet          */
typedef struct lw_task_file lw_task_file;      /* a target with the conditions of its fit                         */

typedef struct lw_target_options {
    int         closed;         /* 1 yes, 0 no, -1 by the file: its "closed" comment, or by guess:
                                 * the gap from last to first is no longer than 1.5 times the longest
                                 * step or a twentieth of the path, body angles come back likewise,
                                 * input angles make a full turn, and there are four stations, or
                                 * three with input angles (a last station that repeats the first
                                 * is kept); functions are open                                    */
    const char *length_unit;    /* NULL: by the file, else metre; overrules a "units" comment      */
    const char *angle_unit;     /* NULL: by the file, else radian; overrules likewise              */
    const char *curve;          /* of a drawing: "2", "1,3", "all", or the name of a curve, group or
                                 * layer; up to four curves become the points of one linkage.
                                 * NULL: its only curve                                            */
    int         stations;       /* stations on a path: > 0 that many, spread by length and curvature;
                                 * 0: the rows of a table, 60 for each curve of a drawing; < 0: the
                                 * points of a drawing as they are drawn                           */
    double      smooth;         /* > 0: move the points of a path onto a smooth curve that none of
                                 * them leaves by more than this [length unit of the target];
                                 * < 0: by as much as their noise, which is estimated              */
} lw_target_options;

/* From CSV text with a header x,y[,theta][,angle|t][,weight] or angle,theta[,weight] (docs/notation.md, "Target"), or
 * from the text of an SVG or DXF drawing; `file`, may be NULL, is its name.  options NULL: by the file.  LW_E_NOTATION with line and column. */
LW_API lw_status lw_target_parse(const char *text, size_t size, const char *file, const lw_target_options *options,
                                 lw_target **out, lw_error *error);

/* From a file: CSV, or curves of an SVG or DXF drawing, recognised by its text.  The path may end in the curve that is
 * wanted: "leg.svg#path10", "leg.dxf#2"; it overrules options->curve. */
LW_API lw_status lw_target_load(const char *path, const lw_target_options *options, lw_target **out, lw_error *error);

/* From arrays (n): x and y of a path [m], with theta, the angle of a tool, for a motion [rad]; or, for a function,
 * angle of the input and theta of the output.  Others NULL.  angle: prescribed input angles.  closed as in the
 * options. */
LW_API lw_status lw_target_create(size_t n, const double *x, const double *y, const double *theta, const double *angle,
                                  const double *weight, int closed, lw_target **out, lw_error *error);
LW_API void      lw_target_destroy(lw_target *target);
LW_API size_t    lw_target_n(const lw_target *target);
LW_API bool      lw_target_closed(const lw_target *target);
LW_API double    lw_target_length(const lw_target *target);          /* of the polygon through the stations [m]   */
/* The assumptions made when the target was read, as text for a person: which curve of a drawing, a unit that no file
 * gives, how far smoothing moved the points; "" if there are none.  Valid as long as the target. */
LW_API const char *lw_target_note(const lw_target *target);

/* Arrays (n) of the target; NULL where it has none. */
LW_API void      lw_target_stations(const lw_target *target, const double **x, const double **y, const double **theta,
                                    const double **angle);

/* ---- fitting dimensions -------------------------------------------------------------------------------------- */

typedef struct lw_bound { char name[16]; double lo, hi; } lw_bound;    /* of a dimension [m] or [rad]            */

/* Where something must or must not be: boxes, circles, lines, convex polygons. */
#define LW_ZONE_CORNERS 16
typedef enum lw_zone_kind {
    LW_ZONE_PIVOTS_BOX,   /* every fixed pivot lies in the box                                      */
    LW_ZONE_PIVOTS_LINE,  /* every fixed pivot lies within `reach` of the line                      */
    LW_ZONE_NO_BOX,       /* no pin and no tracer ever enters                                       */
    LW_ZONE_NO_CIRCLE,
    LW_ZONE_PIVOTS_POLYGON, LW_ZONE_NO_POLYGON
} lw_zone_kind;

typedef struct lw_zone {
    lw_zone_kind kind;
    lw_vec2 at;           /* box: its lower left corner; circle: centre; line: a point [m]         */
    lw_vec2 to;           /* box: its upper right corner [m]; line: unit direction                  */
    double  reach;        /* circle: radius; line: how far off [m]                                  */
    int     n_corner;     /* polygon: 3 to LW_ZONE_CORNERS, in either order; no corner points inwards */
    lw_vec2 corner[LW_ZONE_CORNERS];    /* [m] (n_corner)                                           */
} lw_zone;

/* Called when a search found a better linkage: in the posture of the first station, tracer 0 draws the curve.  Calls
 * come one at a time. */
typedef void lw_fit_found(void *context, const lw_linkage *linkage, double objective, double seconds);

typedef struct lw_fit_request {
    /* where to look */
    const char *types;                 /* four links: "fourbar,slidercrank", "all"       ("fourbar") */
    int         links;                 /* all mechanisms with up to so many links; 0: the fewest, and six if the first row of
                                        * the four-bars with a crank that turns counts as missing the target by more than
                                        * 2.5 % (of up to 15 stations 1 %) of its diagonal, or a function of its range
                                        * (docs/theory.md), or by more than the tolerance               (0)     */
    int         dof;                   /* 1 to 3; inputs but the first go with it in ratios               (1)     */
    const char *joints;                /* kinds of joints with more than four links, of "rtpg"            ("r")   */
    const char *topology;              /* of these only "watt1,stephenson3,8.5"                           ("all") */
    const char *gear_ratios;           /* NULL: the usual                                                 (NULL)  */
    const char *input_ratios;          /* NULL: the usual                                                 (NULL)  */
    int         n_start;               /* linkages to start from                                          (0)     */
    const lw_linkage *const *start;    /* (n_start)                                                               */
    /* what is wanted */
    const char *task;                  /* auto path function motion                                       ("auto") */
    const char *timing;                /* auto prescribed free none                                       ("auto") */
    const char *angle_from;            /* prescribed angles count from: first frame plane                 ("first") */
    int         point_link[3];         /* of further points: 0 any, 1 input, 2 coupler, 3 output link (0) */
    double      weight_path, weight_angle;        /* of squared distances [1/m^2], angles [1/rad^2]; angle 0: by
                                        * angle_length, and 1 for a function                              (1, 0)  */
    double      angle_length;          /* [m] that 1 rad counts as; 0: half the diagonal of the target    (0)     */
    bool        crank_only;            /* the input turns fully and is the shortest link of a four-bar    (false) */
    bool        full_turn;             /* the input turns fully                                           (false) */
    double      min_transmission;      /* [rad]; 0: 20 degrees where a linkage has them; below 0: none    (0)     */
    double      max_acceleration;      /* of the point by the input [m/rad^2]; 0: not asked               (0)     */
    double      max_slide_acceleration;           /* the same where the input is a slide [1/m]            (0)     */
    double      length_range[2];       /* between pins of a link, and from above to the tracer [m];
                                        * 0, 0: by the target                                             (0, 0)  */
    double      position_range[2];     /* [m]; equal: by the target                                       (0, 0)  */
    double      length_ratio;          /* longest over shortest length at most; 0: 20; below 0: any       (0)     */
    double      max_size;              /* without ranges: most length and coordinate over the diagonal of the target;
                                        * 0: 6; below 0: 10                                               (0)     */
    double      class_margin;          /* least distance of a four-bar from a change point over its perimeter; 0: 1e-3, but
                                        * any if it rocks with transmission angles of 20 degrees or more;
                                        * below 0: any                                                    (0)     */
    double      tolerance;             /* [m]; list the simplest linkages, then the smallest, that stray no farther from a
                                        * path; 0: weigh the error against size and transmission          (0)     */
    bool        through_limits;        /* the input may pass limits, and rock on a closed target          (false) */
    bool        unlimited;             /* none of these limits holds unless it is given; results are listed by their
                                        * error alone                                                     (false) */
    int         n_bound, n_zone;       /* 24 and 8 at most                                                (0, 0)  */
    const lw_bound *bound;             /* (n_bound)                                                               */
    const lw_zone  *zone;              /* (n_zone)                                                                */
    /* how long */
    const char *solver;                /* local solver; NULL: Levenberg-Marquardt                         (NULL)  */
    uint64_t    seed;                  /* same seed, same answer                                          (1)     */
    int         jobs;                  /* threads; below 1: one for each core                             (0)     */
    double      max_seconds;           /* 0: no limit                                                     (0)     */
    int         rounds, starts;        /* 0: by the size of the problem                                   (0, 0)  */
    double      budget;                /* evaluations for each number of links above four                 (1e6)   */
    int         results;               /* at most                                                         (10)    */
    const volatile int *stop;          /* *stop not 0 ends the search; may be set by a signal             (NULL)  */
    lw_progress *progress;             /* NULL: none                                                      (NULL)  */
    lw_fit_found *found;               /* NULL: none                                                      (NULL)  */
    void        *context;              /* of progress and found                                           (NULL)  */
} lw_fit_request;
LW_API lw_fit_request lw_fit_request_default(void);

/* A task file (docs/notation.md, "Task") with the targets it names.  _request: what it asks for, the rest as by
 * default; it points into the task, which must outlive its use. */
LW_API lw_status lw_task_file_load(const char *path, lw_task_file **out, lw_target **target, lw_error *error);
/* The same from text, with its own stations; `file` is for messages, may be NULL. */
LW_API lw_status lw_task_file_parse(const char *text, size_t size, const char *file, lw_task_file **out,
                                    lw_target **target, lw_error *error);
LW_API void      lw_task_file_destroy(lw_task_file *task);
LW_API lw_fit_request lw_task_file_request(const lw_task_file *task);

typedef struct lw_results lw_results;          /* ranked linkages, best first, each simulated a second time        */

/* LW_OK; LW_NOTHING: no linkage meets the conditions; LW_STOPPED: time, `stop` or progress ended it, with what was
 * found until then; LW_E_ARG with a text: conditions that exclude everything, or do not suit the target. */
LW_API lw_status lw_fit_target(const lw_target *target, const lw_fit_request *request, lw_results **out,
                               lw_error *error);

/* Linkages that pass through every station exactly: 2 to 5 poses, 3 to 5 pairs of a function, 2 to 9 points. */
LW_API lw_status lw_fit_precision_points(const lw_target *target, const lw_fit_request *request, lw_results **out,
                                         lw_error *error);
LW_API void      lw_results_destroy(lw_results *results);
LW_API int       lw_results_count(const lw_results *results);

/* Defects of a linkage that passes through the precision points but does not run through them in order. */
enum { LW_DEFECT_ORDER = 1, LW_DEFECT_BRANCH = 2, LW_DEFECT_CIRCUIT = 4 };

typedef struct lw_result_info {
    const char *title;                 /* "four-bar", "Watt I, point on link 5"                                   */
    const char *fourbar_class;         /* "GCRR"; "": no four-bar                                                */
    int         links;
    double      objective;             /* weighted sum of squares                                                */
    double      error_mean, error_rms, error_max;        /* distances at the stations [m]                         */
    double      error_percent;         /* mean in percent of the target's length; NaN without length              */
    double      angle_mean, angle_max; /* [rad]; NaN without angles                                              */
    double      transmission[2];       /* least and greatest over the motion, folded to [0, pi/2] [rad]           */
    double      acceleration_max;      /* by the input [m/rad^2]; [1/m] where the input is a slide               */
    bool        turns;                 /* the input turns fully                                                  */
    int         circuits;              /* 0: not counted                                                         */
    bool        verified;              /* an independent simulation of the written linkage agrees                 */
    double      stray;                 /* greatest distance of curve and target, both ways [m]; NaN for functions */
    double      size;                  /* of the greatest link [m]                                                */
    bool        passes_limit;          /* the input passes a limit on its way, or rocks on a closed target        */
    char        at_limit[128];         /* limits of the search that it is at: "r1, transmission"                  */
    unsigned    defects;               /* of LW_DEFECT_                                                          */
} lw_result_info;
LW_API lw_status lw_results_info(const lw_results *results, int i, lw_result_info *out);

/* The linkage in the posture of the first station; tracer 0 is the point that was fitted. */
LW_API lw_status lw_results_linkage(const lw_results *results, int i, lw_linkage **out);

/* Its dimensions by name; the name is NULL past the last one. */
LW_API const char *lw_results_dimension(const lw_results *results, int i, int dimension, double *value);

/* Input of each station, input (n of the target) [rad] or [m] as lw_kinematics counts. */
LW_API lw_status lw_results_inputs(const lw_results *results, int i, double *input);

/* How far the point of result i spreads when every length varies by +-tolerance (three standard deviations) and each
 * pin has this radial clearance [m]. */
typedef struct lw_result_spread {
    double      rms, worst;            /* standard deviation of the place: over the path, in the worst posture [m]  */
    double      trial_rms, within;     /* rms of 1000 random linkages; 95 of 100 stay this near everywhere [m]  */
    int         open;                  /* of these do not close everywhere                                       */
    char        dimension[40];         /* matters most, or as "pin B" the clearance of a pin, ...                  */
    double      part;                  /* ... with this part of rms^2                                            */
} lw_result_spread;

/* LW_E_ARG: no such result, or no path; LW_E_KIND: its motion passes a limit of the input. */
LW_API lw_status lw_results_spread(const lw_results *results, const lw_target *target, int i, double tolerance,
                                   double clearance, lw_result_spread *out, lw_error *error);

/* All results with moving pictures as one HTML page. */
LW_API lw_status lw_results_page(const lw_results *results, const char *title, char **out, size_t *size,
                                 lw_error *error);

/* ---- pictures --------------------------------------------------------------------------------------------------- */

typedef struct lw_picture lw_picture;

/* Diagram of a linkage with its curves, and the stations of a target (NULL: none).  title NULL: the linkage's name. */
LW_API lw_status lw_picture_of_linkage(const lw_linkage *linkage, const lw_target *target, const char *title,
                                       lw_picture **out, lw_error *error);
/* The same of a model of any size, which must outlive the picture, with its outlines, ropes and springs. */
LW_API lw_status lw_picture_of_model(const lw_model *model, const lw_target *target, const char *title, lw_picture **out,
                                     lw_error *error);

/* Mechanisms (n) on one page in so many columns.  caption (n): may be NULL, as may each. */
LW_API lw_status lw_picture_of_mechanisms(int n, const lw_mechanism *const *mechanism, const char *const *caption,
                                          int columns, const char *title, lw_picture **out, lw_error *error);
LW_API void      lw_picture_destroy(lw_picture *picture);

/* Bytes of kind "svg", "pdf", "png"; of linkages also "gif" and "html", which move.  width, height [px]; 0: as
 * usual. */
LW_API lw_status lw_picture_write(const lw_picture *picture, const char *kind, int width, int height, char **out,
                                  size_t *size, lw_error *error);

/* The same into a file, kind by the end of its name. */
LW_API lw_status lw_picture_save(const lw_picture *picture, const char *path, int width, int height, lw_error *error);

typedef struct lw_plot_series { const char *name; size_t n; const double *x, *y; } lw_plot_series;

/* Curves over axes as SVG, PDF or PNG, by the end of the name.  Labels may be NULL; at most 32 series. */
LW_API lw_status lw_plot_save(const char *path, const char *title, const char *x_label, const char *y_label, bool log_x,
                              bool log_y, int n_series, const lw_plot_series *series, lw_error *error);

/* ---- catalogues -------------------------------------------------------------------------------------------------- */

/* A catalogue of mechanisms, curves and linkages in one SQLite file (docs/catalogue.md).  A handle belongs to one thread; one program
 * writes at a time, any number may read.  Work that was stopped or killed is continued by the same call. */
typedef struct lw_catalogue lw_catalogue;

/* write: the file is made when there is none.  wait: for another program that writes [s].  LW_E_IO, LW_E_NOTATION:
 * it is no catalogue, or one of a newer version. */
LW_API lw_status lw_catalogue_open(const char *path, bool write, double wait, lw_catalogue **out, lw_error *error);
LW_API void      lw_catalogue_close(lw_catalogue *catalogue);

/* How long work is done; { 0 } is allowed. */
typedef struct lw_catalogue_work {
    int          jobs;                 /* threads; below 1: one for each core                                    */
    uint64_t     seed;                 /* of samples of curves                                                   */
    lw_progress *progress;             /* `done` is NaN where the whole is unknown; NULL: none                    */
    void        *context;              /* of progress                                                            */
    const volatile int *stop;          /* *stop not 0 ends the work, also before `progress` is called; may be set by a
                                        * signal (NULL)                                                          */
} lw_catalogue_work;

/* Every chain with so many links and freedoms, with ground links, inputs, Assur groups and a picture.  kinds: "r",
 * "rt", "t". *n, may be NULL: chains in the catalogue now.  LW_STOPPED: progress or `stop` said so, what is done is kept. */
LW_API lw_status lw_catalogue_add_chains(lw_catalogue *catalogue, int links, int dof, const char *kinds,
                                         const lw_catalogue_work *work, uint64_t *n, lw_error *error);

/* Linkages as JSON text, also results of `linkwright fit --json`; *n, may be NULL: how many were new. */
LW_API lw_status lw_catalogue_add_linkages(lw_catalogue *catalogue, const char *text, size_t size, const char *file,
                                           uint64_t *n, lw_error *error);

/* Coupler curves until there are `samples` of this seed: of four-link types ("fourbar,slidercrank", "all"), or, types
 * NULL, of all mechanisms of pins with so many links (4, 6, 8), which are found first.  LW_STOPPED as above. */
LW_API lw_status lw_catalogue_add_curves(lw_catalogue *catalogue, const char *types, int links, uint64_t samples,
                                         const lw_catalogue_work *work, lw_error *error);

typedef enum lw_value_kind {
    LW_VALUE_NULL, LW_VALUE_INTEGER, LW_VALUE_REAL, LW_VALUE_TEXT, LW_VALUE_BLOB
} lw_value_kind;

typedef struct lw_value {
    lw_value_kind kind;
    long long     integer;
    double        real;
    const char   *text;                      /* text or blob; of a row: valid during the call       */
    size_t        size;
} lw_value;

/* A row: names and values of its columns (n_column). */
typedef lw_status lw_catalogue_row(void *context, int n_column, const char *const *name, const lw_value *value);

/* A question such as "links=6 and sliders>=1" (docs/catalogue.md); NULL: everything.  list: "chains", "mechanisms",
 * "linkages", "structures"; NULL: the first with all fields.  columns, sort: fields with commas, may be NULL. 
 * limit 0: all rows.  LW_E_NOTATION with the column of the fault. */
LW_API lw_status lw_catalogue_query(lw_catalogue *catalogue, const char *question, const char *list,
                                    const char *columns, const char *sort, long limit, lw_catalogue_row *row,
                                        void *context, lw_error *error);

/* One SELECT of SQL; it may only read. */
LW_API lw_status lw_catalogue_sql(lw_catalogue *catalogue, const char *sql, lw_catalogue_row *row, void *context,
                                  lw_error *error);

/* A coupler curve near a target. */
typedef struct lw_catalogue_hit {
    double      distance;              /* root mean square, over the size of the target [1]                        */
    double      distance_m;            /* the same [m]                                                            */
    const char *family;                /* "crank-rocker"; "": a linkage that was added                             */
    const lw_linkage *linkage;         /* laid on the target; tracer 0 draws the curve, an open one over the range of
                                        * its input                                                               */
    int         turns;                 /* the input turns fully: 1, 0, -1 not known                                */
    double      transmission;          /* least transmission angle on the curve [rad]; NaN: not known              */
} lw_catalogue_hit;
typedef lw_status lw_catalogue_hit_visit(void *context, const lw_catalogue_hit *hit);

/* Which linkages are wanted; all zeros: any. */
typedef struct lw_catalogue_filter {
    bool        turns;                 /* the input turns fully                                                    */
    double      min_transmission;      /* the transmission angle on the curve is at least this [rad]               */
    double      min_length, max_length;    /* limits of the lengths between pins of a link [m]; the tracer is at most
                                        * max_length from them; 0, 0: any                                         */
} lw_catalogue_filter;

/* The `count` curves nearest to the path of a target, nearest first, among the linkages that filter (NULL: all) admits;
 * no other curve of the catalogue is nearer.  LW_NOTHING: there are no such curves. */
LW_API lw_status lw_catalogue_nearest(lw_catalogue *catalogue, const lw_target *target,
                                      const lw_catalogue_filter *filter, int count, lw_catalogue_hit_visit *visit,
                                      void *context, lw_error *error);

/* Check every page, reference and sum.  LW_E_NOTATION with the first fault. */
LW_API lw_status lw_catalogue_check(lw_catalogue *catalogue, lw_error *error);

/* The catalogue as a folder of HTML pages.  links, limit 0: all chains. */
LW_API lw_status lw_catalogue_pages(lw_catalogue *catalogue, const char *folder, int links, int limit,
                                    const lw_catalogue_work *work, lw_error *error);

/* A data set to cite, in a folder that exists: all chains with up to `links` links (7 ..) as graph6, mechanisms with
 * up to 4 links less, Assur groups with up to 2 less, a catalogue, counts, checksums.  The same bytes for any number
 * of threads (docs/catalogue.md).  LW_STOPPED: progress said so; the same call goes on. */
LW_API lw_status lw_release(const char *folder, int links, const lw_catalogue_work *work, lw_error *error);

#ifdef __cplusplus
}
#endif

#endif
