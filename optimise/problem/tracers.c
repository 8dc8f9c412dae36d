#include "optimise/problem/tracers.h"

#include <stdio.h>
#include <string.h>

unsigned lw_tracers_mask(const lw_target *t)
{
    return (1u << (1 + t->n_also)) - 1;
}

static int driven_link(const lw_linkage *linkage)
{
    const lw_joint *j = &linkage->joint[linkage->input[0].joint];
    return j->link[j->link[0] == linkage->ground];
}

static bool at_ground(const lw_linkage *linkage, int link)
{
    for (int j = 0; j < linkage->n_joint; j++)
        for (int side = 0; side < 2; side++)
            if (linkage->joint[j].link[side] == link && linkage->joint[j].link[!side] == linkage->ground)
                return true;
    return false;
}

lw_carrier lw_tracers_carrier(const lw_linkage *linkage, int link)
{
    return link == driven_link(linkage) ? LW_CARRIER_INPUT
           : at_ground(linkage, link)   ? LW_CARRIER_OUTPUT
                                        : LW_CARRIER_COUPLER;
}

bool lw_tracers_only_slides(const lw_linkage *linkage, int link)
{
    for (int j = 0; j < linkage->n_joint; j++)
        for (int side = 0; side < 2; side++)
            if (lw_joint_translates(linkage->joint[j].kind) && linkage->joint[j].link[side] == link
                && linkage->joint[j].link[!side] == linkage->ground)
                return true;
    return false;
}

void lw_tracers_put(lw_linkage *linkage, int i, int link)
{
    lw_tracer *p = &linkage->tracer[i];
    lw_vec2 sum = lw_v2(0, 0);
    int n = 0;
    memset(p, 0, sizeof *p);
    snprintf(p->name, sizeof p->name, "P%d", i + 1);
    for (int j = 0; j < linkage->n_joint; j++)
        if (linkage->joint[j].link[0] == link || linkage->joint[j].link[1] == link) {
            sum = lw_v2_add(sum, linkage->joint[j].at);
            n++;
        }
    p->link = link;
    p->at = n ? lw_v2_scale(sum, 1.0/n) : sum;
    linkage->n_tracer = i + 1;
}

static lw_status no_angle(lw_error *e, int number)
{
    return lw_error_set(e, LW_E_KIND, "the link of point %d slides and has no angle", number);
}

lw_status lw_tracers_linkage(const lw_family *f, const lw_target *t, const lw_fit_spec *s, lw_linkage *linkage, lw_error *e)
{
    lw_family_linkage(f, s->task, linkage);
    for (int i = 0; i < t->n_also; i++) {
        bool angle = !t->also[i].x;
        lw_carrier c = s->carrier[i];
        if (c == LW_CARRIER_ANY)
            c = angle && lw_task_has_place(s->task) ? LW_CARRIER_OUTPUT : LW_CARRIER_COUPLER;
        int link = linkage->n_tracer > i + 1 ? linkage->tracer[i + 1].link : -1;
        for (int l = 0; l < linkage->n_link && link < 0; l++)
            if (l != linkage->ground && lw_tracers_carrier(linkage, l) == c)
                link = l;
        if (link < 0)
            return lw_error_set(e, LW_E_KIND, "it has no link such as point %d is to lie on", i + 2);
        if (t->also[i].theta && lw_tracers_only_slides(linkage, link))
            return no_angle(e, i + 2);
        if (linkage->n_tracer <= i + 1)
            lw_tracers_put(linkage, i + 1, link);
    }
    linkage->n_tracer = 1 + t->n_also;
    return LW_OK;
}
