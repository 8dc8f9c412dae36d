/* grammar/linkage/assembly.c - memory of assemblies, conversion to and from linkages. */
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
                            lw_plural(a->n_joint), a->n_input, lw_plural(a->n_input), a->n_tracer, lw_plural(a->n_tracer),
                            LW_LINK_MAX, LW_JOINT_MAX, LW_INPUT_MAX, LW_TRACER_MAX);
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
