/* mbs/formulations/driven_space.c - runs of spatial models whose inputs leave no freedom. */
#include "mbs/formulations/formulations_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/vector.h"
#include "mbs/equations/limits_internal.h"
#include "mbs/space/space_hold.h"

/* Accelerations d->a and multipliers d->l at (t, q); v becomes the velocities there. */
static lw_status forces_at(lw_dynamics *d, double t, const double *q, double *v)
{
    bool still = d->o.analysis == LW_ANALYSIS_QUASISTATIC;
    memset(v, 0, (size_t)d->n_v*sizeof *v);
    lw_status st = lw_mbs_rows(d, t, q);
    if (st == LW_OK)
        st = lw_mbs_factor(d, d->rank < d->n_c || d->has_zero_mass || still);
    if (st == LW_OK)
        st = lw_mbs_project_v(d, t, v);
    if (st == LW_OK)
        st = lw_mbs_solve(d, t, q, v, d->a, d->l, NULL);
    if (st != LW_OK || !still)
        return st;
    memset(d->v_try, 0, (size_t)d->n_v*sizeof *d->v_try);
    memset(d->a, 0, (size_t)d->n_v*sizeof *d->a);
    d->eq.forces(d->eq.context, t, q, d->v_try, d->force, NULL);
    lw_rank_solve(&d->rank_of, d->force, d->l);
    return st;
}

/* Near a singular posture: multipliers d->l for the velocities and accelerations of f, where they are known to 1e-6 of the greatest, otherwise
 * NAN; that of a single drive follows from its power. */
static lw_status forces_beside(lw_dynamics *d, const lw_space_follow *f, double t, const double *q, double *v)
{
    bool still = d->o.analysis == LW_ANALYSIS_QUASISTATIC;
    double top = 0;
    memcpy(d->a, f->a, (size_t)d->n_v*sizeof *d->a);
    memcpy(v, f->v, (size_t)d->n_v*sizeof *v);
    lw_status st = lw_mbs_rows(d, t, q);
    if (st != LW_OK)
        return st;
    double drive = lw_mbs_drive_by_power(d, t, q, v), most = lw_greatest(d->n_v, d->force);
    st = lw_mbs_factor(d, d->rank < d->n_c || d->has_zero_mass || still);
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    if (st == LW_OK)
        st = lw_mbs_linear(d, d->force, d->rhs, d->hold, d->l);
    for (int r = 0; st == LW_OK && r < d->n_c; r++)
        top = fmax(top, fabs(d->l[r]));
    double apart = d->by_rank ? d->rank_of.weakest : sqrt(d->weak);
    bool known = st == LW_OK && !d->n_friction && LW_SPACE_BETWEEN*most < 1e-6*top*apart;
    for (int r = 0; r < d->n_c && !known; r++)
        d->l[r] = NAN;
    if (!isnan(drive))
        d->l[d->n_row] = drive;
    if (still) {
        memset(v, 0, (size_t)d->n_v*sizeof *v);
        memset(d->a, 0, (size_t)d->n_v*sizeof *d->a);
    }
    return st == LW_OPEN ? LW_OK : st;
}

lw_status lw_run_driven_spatial(lw_run *run)
{
    lw_dynamics *d = run->d;
    lw_space_follow *f = &d->space->follow;
    lw_space_watch w = { 0 };
    double *y = calloc((size_t)run->n, sizeof *y);
    lw_status st = y ? LW_OK : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    for (int k = 0; st == LW_OK && k <= d->o.intervals; k++) {
        double t = lw_run_time(d, k);
        double before = f->u;
        if (k == 1)
            st = lw_space_watch_begin(&w, f, run->e);
        for (int i = 1, looks = lw_run_looks(d); st == LW_OK && i <= looks; i++) {
            double at = i == looks ? t : before + (t - before)*i/looks;
            if ((st = lw_limits_check(d->o.stop, d->o.until, true, at, run->e)) == LW_OK)
                st = lw_space_follow_to(f, lw_mbs_driven_path, d, at, run->e);
            st = st == LW_OPEN ? LW_E_NUMERIC : st;      /* its text says where and why */
            st = st == LW_OK ? lw_run_look_at_stops(run, at, f->q) : st;
        }
        if (st != LW_OK)
            break;
        run->r->t = t;
        lw_space_follow_rates(f, lw_mbs_driven_path, d);
        memcpy(y, f->q, (size_t)d->n_q*sizeof *y);
        d->eq.accept(d->eq.context, y);
        if (d->space->has_drives && d->o.analysis != LW_ANALYSIS_QUASISTATIC) {      /* which find all forces from the motion */
            memcpy(y + d->n_q, f->v, (size_t)d->n_v*sizeof *y);
            memcpy(d->a, f->a, (size_t)d->n_v*sizeof *d->a);
            memset(d->l, 0, (size_t)d->n_c*sizeof *d->l);
        } else
            st = f->between ? forces_beside(d, f, t, y, y + d->n_q) : forces_at(d, t, y, y + d->n_q);
        if (st == LW_OPEN)
            st = lw_error_set(run->e, LW_OPEN, "at t = %.9g s the model stands in a singular posture", t);
        if (st == LW_OK)
            st = lw_run_show_solved(run, t, y);
        run->next++;
        run->r->steps++;
    }
    run->r->lost = w.lost;
    memcpy(run->r->lost_t, w.between, sizeof w.between);
    memcpy(run->r->lost_how, w.how, sizeof w.how);
    lw_space_watch_end(&w);
    free(y);
    return st;
}
