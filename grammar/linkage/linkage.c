/* grammar/linkage/linkage.c - mobility, inputs, and the values of inputs in the posture. */
#include "base/real.h"
#include "base/owners.h"
#include "grammar/linkage/assembly.h"

#include <stdbool.h>

int lw_assembly_mobility(const lw_assembly *assembly)
{
    int freedom = 3*(assembly->n_link - 1);
    for (int i = 0; i < assembly->n_joint; i++)
        freedom -= lw_joint_equations(assembly->joint[i].kind);
    return freedom;
}

int lw_assembly_free_inputs(const lw_assembly *assembly)
{
    int n = 0;
    while (n < assembly->n_input && assembly->input[n].ratio == 0)
        n++;
    return n;
}

double lw_assembly_tied_input(const lw_assembly *assembly, int i, double first)
{
    return assembly->input[i].value + assembly->input[i].ratio*(first - assembly->input[0].value);
}

double lw_assembly_tie_unit(const lw_assembly *assembly, int i, double metre)
{
    bool slides = lw_joint_slides(assembly->joint[assembly->input[i].joint].kind);
    bool first_slides = lw_joint_slides(assembly->joint[assembly->input[0].joint].kind);
    return (slides ? metre : 1.0)/(first_slides ? metre : 1.0);
}

static bool carries(const lw_joint *j, int link) { return j->link[0] == link || j->link[1] == link; }

/* True if the slide line of this joint, and not its pin, is on the link. */
static bool slides_on(const lw_joint *j, int link)
{
    return lw_joint_slides(j->kind) && (lw_joint_holds_rotation(j->kind) || j->link[0] == link);
}

/* The joints and the tracers of each link. */
typedef struct link_parts { lw_owners joint, tracer; } link_parts;

/* The x axis of a link, from one of its pins; not normalised.  parts NULL: search all joints and tracers. */
static lw_vec2 x_axis(const lw_assembly *assembly, const link_parts *parts, int joint, int link)
{
    lw_vec2 from = assembly->joint[joint].at;
    int first = parts ? parts->joint.start[link] : 0, last = parts ? parts->joint.start[link + 1] : assembly->n_joint;
    for (int at = first; at < last; at++) {
        int i = parts ? parts->joint.entry[at]/2 : at;
        const lw_joint *j = &assembly->joint[i];
        if (i == joint || !carries(j, link) || !lw_joint_has_position(j->kind))
            continue;
        if (slides_on(j, link))
            return j->along;
        lw_vec2 d = lw_v2_sub(j->at, from);
        if (d.x != 0 || d.y != 0)
            return d;
    }
    if (parts)
        return parts->tracer.start[link] == parts->tracer.start[link + 1] ? lw_v2(1, 0)
             : lw_v2_sub(assembly->tracer[parts->tracer.entry[parts->tracer.start[link]]].at, from);
    for (int i = 0; i < assembly->n_tracer; i++)
        if (assembly->tracer[i].link == link)
            return lw_v2_sub(assembly->tracer[i].at, from);
    return lw_v2(1, 0);
}

static double posture_input(const lw_assembly *assembly, const link_parts *parts, int joint)
{
    const lw_joint *j = &assembly->joint[joint];
    if (!lw_joint_turns(j->kind))
        return 0;
    double direction[2];
    for (int i = 0; i < 2; i++) {
        lw_vec2 x = x_axis(assembly, parts, joint, j->link[i]);
        direction[i] = j->link[i] == assembly->ground ? 0 : atan2(x.y, x.x);
    }
    if (j->link[0] == assembly->ground)
        return direction[1];
    if (j->link[1] == assembly->ground)
        return direction[0];
    double turn = remainder(direction[1] - direction[0], 2*LW_PI);
    return turn <= -LW_PI ? LW_PI : turn;
}

double lw_assembly_posture_input(const lw_assembly *assembly, int joint)
{
    return posture_input(assembly, NULL, joint);
}

lw_status lw_assembly_set_inputs(lw_assembly *a, const bool *given)
{
    link_parts parts = { { NULL, NULL }, { NULL, NULL } };
    bool ok = LW_OWNERS(&parts.joint, a->n_link, a->joint, a->n_joint, link, 2)
           && LW_OWNERS(&parts.tracer, a->n_link, a->tracer, a->n_tracer, link, 1);
    for (int i = 0; ok && i < a->n_input; i++)
        if (!given || !given[i])
            a->input[i].value = posture_input(a, &parts, a->input[i].joint);
    lw_owners_free(&parts.joint);
    lw_owners_free(&parts.tracer);
    return ok ? LW_OK : LW_E_MEMORY;
}

/* ---- the same of a linkage ------------------------------------------------------------------------ */

int lw_linkage_mobility(const lw_linkage *linkage)
{
    lw_assembly a = lw_linkage_view(linkage);
    return lw_assembly_mobility(&a);
}

int lw_linkage_free_inputs(const lw_linkage *linkage)
{
    lw_assembly a = lw_linkage_view(linkage);
    return lw_assembly_free_inputs(&a);
}

double lw_linkage_posture_input(const lw_linkage *linkage, int joint)
{
    lw_assembly a = lw_linkage_view(linkage);
    return lw_assembly_posture_input(&a, joint);
}
