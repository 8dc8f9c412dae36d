/* grammar/linkage/assembly.c - memory of assemblies, conversion to and from linkages, the carrier of a gear. */
#include "grammar/linkage/assembly.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"

void lw_assembly_free(lw_assembly *a)
{
    free(a->link_name);
    free(a->joint);
    free(a->input);
    free(a->tracer);
    memset(a, 0, sizeof *a);
}

lw_assembly lw_linkage_view(const lw_linkage *linkage)
{
    lw_linkage *own = (lw_linkage *)(uintptr_t)linkage;
    lw_assembly a = { .n_link = linkage->n_link,
                      .n_joint = linkage->n_joint,
                      .n_input = linkage->n_input,
                      .n_tracer = linkage->n_tracer,
                      .ground = linkage->ground,
                      .link_name = own->link_name,
                      .joint = own->joint,
                      .input = own->input,
                      .tracer = own->tracer,
                      .units = linkage->units };
    memcpy(a.name, linkage->name, sizeof a.name);
    return a;
}

lw_status lw_assembly_linkage(const lw_assembly *a, lw_linkage *linkage, lw_error *e)
{
    if (a->n_link > LW_LINK_MAX || a->n_joint > LW_JOINT_MAX || a->n_input > LW_INPUT_MAX || a->n_tracer > LW_TRACER_MAX)
        return lw_error_set(e, LW_E_KIND, "%d link%s, %d joint%s, %d input%s and %d tracer%s are too many here: at most %d, "
                            "%d, %d and %d; simulate, trace, mobility, draw and convert have no limit", a->n_link, lw_plural(a->n_link), a->n_joint,
                            lw_plural(a->n_joint), a->n_input, lw_plural(a->n_input), a->n_tracer, lw_plural(a->n_tracer), LW_LINK_MAX, LW_JOINT_MAX, LW_INPUT_MAX, LW_TRACER_MAX);
    memset(linkage, 0, sizeof *linkage);
    memcpy(linkage->name, a->name, sizeof linkage->name);
    linkage->n_link = a->n_link;
    linkage->n_joint = a->n_joint;
    linkage->n_input = a->n_input;
    linkage->n_tracer = a->n_tracer;
    linkage->ground = a->ground;
    linkage->units = a->units;
    if (a->n_link > 0)
        memcpy(linkage->link_name, a->link_name, (size_t)a->n_link*sizeof *a->link_name);
    if (a->n_joint > 0)
        memcpy(linkage->joint, a->joint, (size_t)a->n_joint*sizeof *a->joint);
    if (a->n_input > 0)
        memcpy(linkage->input, a->input, (size_t)a->n_input*sizeof *a->input);
    if (a->n_tracer > 0)
        memcpy(linkage->tracer, a->tracer, (size_t)a->n_tracer*sizeof *a->tracer);
    return LW_OK;
}

static void *copy_array(const void *from, int n, size_t size, lw_status *s)
{
    void *to = n > 0 ? malloc((size_t)n*size) : NULL;
    if (to)
        memcpy(to, from, (size_t)n*size);
    else if (n > 0)
        *s = LW_E_MEMORY;
    return to;
}

lw_status lw_assembly_copy(const lw_assembly *from, lw_assembly *to)
{
    lw_status s = LW_OK;
    *to = *from;
    to->link_name = copy_array(from->link_name, from->n_link, sizeof *from->link_name, &s);
    to->joint = copy_array(from->joint, from->n_joint, sizeof *from->joint, &s);
    to->input = copy_array(from->input, from->n_input, sizeof *from->input, &s);
    to->tracer = copy_array(from->tracer, from->n_tracer, sizeof *from->tracer, &s);
    if (s != LW_OK)
        lw_assembly_free(to);
    return s;
}

/* ---- gears ------------------------------------------------------------------------------------- */

/* The surroundings of a gear: its two links, all links joined to them, and what is welded to those or shares a pin
 * with them.  The carrier is among them. */
typedef struct surroundings { lw_linkage k; int link[LW_LINK_MAX], joint[LW_JOINT_MAX]; } surroundings;

static int place_of(const surroundings *s, int link)
{
    for (int i = 0; i < s->k.n_link; i++)
        if (s->link[i] == link)
            return i;
    return -1;
}

static bool add_link(surroundings *s, int link)
{
    if (place_of(s, link) >= 0)
        return true;
    if (s->k.n_link == LW_LINK_MAX)
        return false;
    s->link[s->k.n_link++] = link;
    return true;
}

/* Add the links joined to those known so far: by any joint, or by welds and by pins alone. */
static bool add_neighbours(const lw_assembly *a, bool any, surroundings *s)
{
    int n = s->k.n_link;
    bool more = true;
    while (more) {
        more = false;
        for (int j = 0; j < a->n_joint; j++) {
            const lw_joint *q = &a->joint[j];
            int known[2] = { place_of(s, q->link[0]), place_of(s, q->link[1]) };
            bool near = any ? (known[0] >= 0 && known[0] < n) || (known[1] >= 0 && known[1] < n)
                            : lw_joint_freedoms(q->kind) == 0 && (known[0] >= 0) != (known[1] >= 0);
            if (!near || lw_joint_has_ratio(q->kind) || (known[0] >= 0 && known[1] >= 0))
                continue;
            if (!add_link(s, q->link[0]) || !add_link(s, q->link[1]))
                return false;
            more = !any;
        }
    }
    return true;
}

static bool find_surroundings(const lw_assembly *a, int joint, surroundings *s)
{
    memset(s, 0, sizeof *s);
    if (!add_link(s, a->joint[joint].link[0]) || !add_link(s, a->joint[joint].link[1]) || !add_neighbours(a, false, s)
        || !add_neighbours(a, true, s) || !add_neighbours(a, false, s) || !add_neighbours(a, true, s))
        return false;
    for (int i = 0; i < s->k.n_link; i++)
        memcpy(s->k.link_name[i], a->link_name[s->link[i]], LW_NAME_SIZE);
    for (int j = 0; j < a->n_joint; j++) {
        int end[2] = { place_of(s, a->joint[j].link[0]), place_of(s, a->joint[j].link[1]) };
        if (end[0] < 0 || end[1] < 0)
            continue;
        if (s->k.n_joint == LW_JOINT_MAX)
            return false;
        s->joint[s->k.n_joint] = j;
        s->k.joint[s->k.n_joint] = a->joint[j];
        memcpy(s->k.joint[s->k.n_joint++].link, end, sizeof end);
    }
    return true;
}

lw_status lw_assembly_gear(const lw_assembly *a, int joint, lw_gear *g, lw_vec2 *contact, lw_error *e)
{
    surroundings s;
    if (a->n_link <= LW_LINK_MAX && a->n_joint <= LW_JOINT_MAX) {
        s.k.n_link = a->n_link;
        s.k.n_joint = a->n_joint;
        memcpy(s.k.link_name, a->link_name, (size_t)a->n_link*sizeof *a->link_name);
        memcpy(s.k.joint, a->joint, (size_t)a->n_joint*sizeof *a->joint);
        for (int i = 0; i < a->n_link; i++)
            s.link[i] = i;
        for (int j = 0; j < a->n_joint; j++)
            s.joint[j] = j;
    } else if (!find_surroundings(a, joint, &s))
        return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a gear, and more than %d links are joined to its wheels and "
                            "their neighbours", a->joint[joint].name, LW_LINK_MAX);
    int at = 0;
    while (s.joint[at] != joint)
        at++;
    lw_status status = lw_linkage_gear(&s.k, at, g, e);
    if (status != LW_OK)
        return status;
    if (contact)
        *contact = lw_linkage_contact(&s.k, at, g);
    g->carrier = s.link[g->carrier];
    for (int side = 0; side < 2; side++)
        g->slider[side] = g->slider[side] >= 0 ? s.joint[g->slider[side]] : -1;
    return LW_OK;
}
