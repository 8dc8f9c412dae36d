/* cli/bench/flexible_crank.h - a slider-crank whose coupler bends in two modes and stretches in two: the reference
 * problem of Simeon 1996 (IVP test set, "slider crank").
 *
 *     p      crank angle [rad], coupler angle [rad], place of the slider [m], then the four elastic coordinates [m]
 *     M(p) p'' = f(p, p') - G^T l,   Phi(t, p) = 0: the loop (two rows), and the crank at constant speed
 *
 * Its coupler bends in given modes; elastic links of models are chains of elements (mbs/elastic).  It is here to show the
 * integrators where the fast vibration of the coupler lies beside the slow motion of the crank, with published end values. */
#ifndef CLI_BENCH_FLEXIBLE_CRANK_H
#define CLI_BENCH_FLEXIBLE_CRANK_H

#include "mbs/ode/integrate.h"

#define LW_FLEXIBLE_N 7

typedef struct lw_flexible_crank {
    double crank, coupler;                       /* lengths [m]                                             */
    double m2, m3, j1, j2;                       /* masses of coupler, slider; inertias of crank, coupler [kg m^2] */
    double density, speed;                       /* of the coupler [kg/m^3]; of the crank [rad/s]            */
    double mass[4][4], stiffness[4][4];          /* of the elastic coordinates                              */
    double b[4][4], c1[4], c2[4], c12[4], c21[4];   /* coupling to the rotation of the coupler               */
} lw_flexible_crank;

/* The published numbers, unchanged: pi with eight digits, and the mass of stretching without its factor 1/15, because
 * the published end values need this (Mazzia & Magherini 2008, problem "slider crank"). */
void lw_flexible_crank_published(lw_flexible_crank *c);

/* Mass matrix (7 x 7, symmetric); forces of stiffness and of velocities (7). */
void lw_flexible_crank_mass(const lw_flexible_crank *c, const double *p, double *m);
void lw_flexible_crank_force(const lw_flexible_crank *c, const double *p, const double *v, double *f);

/* Phi (3), and G (3 x 7) unless it is NULL. */
void lw_flexible_crank_rows(const lw_flexible_crank *c, double t, const double *p, double *phi, double *g);

typedef enum lw_flexible_method {
    LW_FLEXIBLE_EXPLICIT,                        /* elastic coordinates alone, order 8                       */
    LW_FLEXIBLE_ADAMS, LW_FLEXIBLE_BDF,          /* the same by CVODE                                       */
    LW_FLEXIBLE_GGL                              /* all with multipliers, stabilised index 2, by IDA          */
} lw_flexible_method;
#define LW_FLEXIBLE_METHODS 4

const char *lw_flexible_method_name(lw_flexible_method m);

typedef struct lw_flexible_run { double p[LW_FLEXIBLE_N], v[LW_FLEXIBLE_N]; long steps, rates; } lw_flexible_run;

/* Integrate from the published start (elastic coordinates as printed, the others from the loop) to t = `to`. Returns
 * errors of the integrator. */
lw_status lw_flexible_crank_run(const lw_flexible_crank *c, lw_flexible_method method, double tolerance, double to,
                                lw_flexible_run *r, lw_error *e);

#endif
