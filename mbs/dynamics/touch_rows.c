/* mbs/dynamics/touch_rows.c - rows and forces of the places where a model touches. */
#include "mbs/dynamics/touch_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"

enum { STOPS_MOST = 16 };       /* more rigid stops are places too: each would be an event and, where it rests, hold a row alone */
enum { EVENTS_MOST = 40 };      /* with more compliant places the steps, not events, find where contacts begin */

lw_status lw_mbs_touch_make(lw_dynamics *d, lw_error *e)
{
    const lw_model *m = d->model;
    bool many = d->n_stop > (d->large ? 0 : STOPS_MOST);
    if (m->n_contact == 0 && m->n_rope == 0 && !many)
        return LW_OK;
    struct lw_touching *w = d->touch = calloc(1, sizeof *w);
    if (!w)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status s = lw_touch_make(m, &d->s, &w->list, e);
    int rigid = 0, compliant = 0;
    for (int i = 0; s == LW_OK && i < w->list.n; i++) {
        const lw_surface *p = w->list.touch[i].surface;
        compliant += p->stiffness > 0;
        rigid += !(p->stiffness > 0) || (p->friction > 0 && !(p->friction_speed > 0));
    }
    d->n_stop = 0;                           /* they are places too */
    w->row_max = 2*rigid;
    w->row = calloc(2*(size_t)w->row_max + 1, sizeof *w->row);
    w->redundant = w->row + w->row_max;
    int most = d->s.n_joint + w->row_max + 1;            /* places that slip follow the joints with friction */
    lw_friction_joint *friction = realloc(d->friction, (size_t)most*sizeof *friction);
    d->friction = friction ? friction : d->friction;
    int *row = realloc(d->friction_row, (size_t)most*sizeof *row);
    d->friction_row = row ? row : d->friction_row;
    w->determinant = 1;
    w->events = compliant <= EVENTS_MOST;
    w->last = -INFINITY;
    return s != LW_OK || (w->row && friction && row) ? s : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

void lw_mbs_touch_free(lw_dynamics *d)
{
    if (!d->touch)
        return;
    lw_touch_free(&d->touch->list);
    free(d->touch->row);
    free(d->touch->response);
    free(d->touch->share);
    free(d->touch);
    d->touch = NULL;
}

bool lw_mbs_touch_rubs(const lw_dynamics *d)
{
    bool rubs = false;
    for (int i = 0; d->touch && i < d->touch->list.n; i++)
        rubs = rubs || d->touch->list.touch[i].surface->friction > 0;
    return rubs;
}

void lw_mbs_touch_bodies(lw_dynamics *d, int row)
{
    for (int k = 0; k < d->touch->n_row; k++, row++) {
        const lw_touch *p = &d->touch->list.touch[d->touch->row[k].touch];
        int n = 0, *block = lw_mbs_blocks(d, row);
        for (int end = 0; end < 2; end++)
            if (p->body[end] >= 0)
                block[n++] = p->body[end];
        for (; n < d->eq.n_slot; n++)
            block[n] = -1;
    }
}

void lw_mbs_touch_rows(lw_dynamics *d, int row)
{
    for (int k = 0; k < d->touch->n_row; k++, row++) {
        const lw_touch *p = &d->touch->list.touch[d->touch->row[k].touch];
        bool tangent = d->touch->row[k].tangent;
        lw_touch_motion m;
        lw_touch_at(p, &d->eq, d->frames, NULL, &m);
        d->phi[row] = tangent ? m.path - p->anchor : m.gap;
        double *to = lw_mbs_jac(d, row);
        for (int end = 0; end < 2; end++)
            if (p->body[end] >= 0) {
                memcpy(to, (tangent ? m.t : m.n) + 3*end, 3*sizeof *to);
                to += 3;
            }
    }
}

void lw_mbs_touch_bias(lw_dynamics *d, int row, const double *v)
{
    for (int k = 0; k < d->touch->n_row; k++, row++) {
        lw_touch_motion m;
        lw_touch_at(&d->touch->list.touch[d->touch->row[k].touch], &d->eq, d->frames, v, &m);
        d->rhs[row] = d->touch->row[k].tangent ? -m.slip_bias : -m.bias;
    }
}

static void add_force(const lw_touch *p, const double *row, double f, double *force)
{
    for (int i = 0; i < 6; i++)
        if (p->body[i/3] >= 0)
            force[3*p->body[i/3] + i%3] += f*row[i];
}

void lw_mbs_touch_forces(lw_dynamics *d, const double *v, double *force, double *power)
{
    double unit = d->s.unit;
    for (int i = 0; i < d->touch->list.n; i++) {
        const lw_touch *p = &d->touch->list.touch[i];
        const lw_surface *s = p->surface;
        lw_touch_motion m;
        if (!(s->stiffness > 0) || (d->touch->events && p->state != LW_TOUCH_PRESSED))
            continue;
        lw_touch_at(p, &d->eq, d->frames, v, &m);
        double normal = lw_touch_force(s, unit, -m.gap, -m.rate);
        if (!(normal > 0))
            continue;
        double sense = s->friction_speed > 0 ? tanh(m.slip*unit/s->friction_speed) : p->slips;
        double across = p->kind == LW_TOUCH_ROPE ? 0 : -s->friction*normal*sense;
        add_force(p, m.n, normal*unit, force);
        add_force(p, m.t, across*unit, force);
        if (power)
            *power += (normal*m.rate + across*m.slip)*unit;
    }
}

double lw_mbs_touch_slip(lw_dynamics *d, int k, const double *v, double *force)
{
    const lw_touch *p = &d->touch->list.touch[d->touch->row[d->friction_row[d->n_friction + k] - (d->n_c - d->touch->n_row)].touch];
    lw_touch_motion m;
    double across = -p->surface->friction*p->slips;
    lw_touch_at(p, &d->eq, d->frames, v, &m);
    memset(force, 0, (size_t)d->n_q*sizeof *force);
    add_force(p, m.t, across*d->s.unit, force);
    return across*m.slip*d->s.unit;
}

double lw_mbs_touch_load(const lw_dynamics *d, int i, const double *v, const double *l, lw_vec2 *f)
{
    const struct lw_touching *w = d->touch;
    const lw_touch *p = &w->list.touch[i];
    const lw_surface *s = p->surface;
    double normal = 0, across = 0, unit = d->s.unit;
    lw_touch_motion m;
    lw_touch_at(p, &d->eq, d->frames, v, &m);
    if (s->stiffness > 0 && !(w->events && p->state != LW_TOUCH_PRESSED))
        normal = lw_touch_force(s, unit, -m.gap, -m.rate);
    for (int k = 0; k < w->n_row; k++)
        if (w->row[k].touch == i)
            *(w->row[k].tangent ? &across : &normal) = -l[d->n_c - w->n_row + k]/unit;
    for (int k = 0; k < w->n_redundant; k++)
        if (w->redundant[k].touch == i)
            *(w->redundant[k].tangent ? &across : &normal) = w->share[k]/unit;
    if (!p->sticks)
        across = -s->friction*normal*(s->friction_speed > 0 ? tanh(m.slip*unit/s->friction_speed) : p->slips);
    *f = lw_v2_add(lw_v2_scale(m.normal, normal), lw_v2_scale(lw_v2(m.normal.y, -m.normal.x), across));
    return normal;
}
