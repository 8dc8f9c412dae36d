#include "optimise/problem/tracers.h"

#include <stdio.h>
#include <string.h>

unsigned lw_tracers_mask(const lw_target *t)
{
    return (1u << (1 + t->n_also)) - 1;
}

static int driven_link(const lw_linkage *k)
{
    const lw_joint *j = &k->joint[k->input[0].joint];
    return j->link[j->link[0] == k->ground];
}

static bool at_ground(const lw_linkage *k, int link)
{
    for (int j = 0; j < k->n_joint; j++)
        for (int side = 0; side < 2; side++)
            if (k->joint[j].link[side] == link && k->joint[j].link[!side] == k->ground)
                return true;
    return false;
}

lw_carrier lw_tracers_carrier(const lw_linkage *k, int link)
{
    return link == driven_link(k) ? LW_CARRIER_INPUT : at_ground(k, link) ? LW_CARRIER_OUTPUT : LW_CARRIER_COUPLER;
}

bool lw_tracers_only_slides(const lw_linkage *k, int link)
{
    for (int j = 0; j < k->n_joint; j++)
        for (int side = 0; side < 2; side++)
            if (lw_joint_translates(k->joint[j].kind) && k->joint[j].link[side] == link
                && k->joint[j].link[!side] == k->ground)
                return true;
    return false;
}

void lw_tracers_put(lw_linkage *k, int i, int link)
{
    lw_tracer *p = &k->tracer[i];
    lw_vec2 sum = lw_v2(0, 0);
    int n = 0;
    memset(p, 0, sizeof *p);
    snprintf(p->name, sizeof p->name, "P%d", i + 1);
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].link[0] == link || k->joint[j].link[1] == link) {
            sum = lw_v2_add(sum, k->joint[j].at);
            n++;
        }
    p->link = link;
    p->at = n ? lw_v2_scale(sum, 1.0/n) : sum;
    k->n_tracer = i + 1;
}

static lw_status no_angle(lw_error *e, int number)
{
    return lw_error_set(e, LW_E_KIND, "the link of point %d slides and has no angle", number);
}

lw_status lw_tracers_linkage(const lw_family *f, const lw_target *t, const lw_fit_spec *s, lw_linkage *k, lw_error *e)
{
    lw_family_linkage(f, s->task, k);
    for (int i = 0; i < t->n_also; i++) {
        bool angle = !t->also[i].x;
        lw_carrier c = s->carrier[i];
        if (c == LW_CARRIER_ANY)
            c = angle && lw_task_has_place(s->task) ? LW_CARRIER_OUTPUT : LW_CARRIER_COUPLER;
        int link = k->n_tracer > i + 1 ? k->tracer[i + 1].link : -1;
        for (int l = 0; l < k->n_link && link < 0; l++)
            if (l != k->ground && lw_tracers_carrier(k, l) == c)
                link = l;
        if (link < 0)
            return lw_error_set(e, LW_E_KIND, "it has no link such as point %d is to lie on", i + 2);
        if (t->also[i].theta && lw_tracers_only_slides(k, link))
            return no_angle(e, i + 2);
        if (k->n_tracer <= i + 1)
            lw_tracers_put(k, i + 1, link);
    }
    k->n_tracer = 1 + t->n_also;
    return LW_OK;
}
