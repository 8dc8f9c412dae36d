/* grammar/linkage/linkage_check.c - the checks that every user of a linkage relies on. */
#include "base/bytes.h"
#include "base/real.h"
#include "base/union_find.h"
#include "grammar/linkage/linkage_internal.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { FEW = 64 };                       /* up to so many parts are compared in pairs, without memory of their own */
#define LW_PART_MAX 100000000            /* coordinates and rows are counted by int */

static bool sane(double v) { return fabs(v) <= LW_COORDINATE_MAX; }      /* false for NaN too */
static bool in_range(int i, int n) { return i >= 0 && i < n; }

/* ---- names ------------------------------------------------------------------------------------ */

typedef struct name_list { const char *what, *first; size_t stride; int n; } name_list;

static const char *name_of(const name_list *list, int i) { return list->first + (size_t)i*list->stride; }

/* Index of an earlier part with the name of part i, -1: none. */
static int same_name(const name_list *list, int i)
{
    for (int j = 0; j < i; j++)
        if (strcmp(name_of(list, i), name_of(list, j)) == 0)
            return j;
    return -1;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Are two names of a long list the same?  LW_E_MEMORY: not known. */
static lw_status has_same_names(const name_list *list, bool *has)
{
    const char **name = malloc((size_t)list->n*sizeof *name);
    *has = false;
    if (!name)
        return LW_E_MEMORY;
    for (int i = 0; i < list->n; i++)
        name[i] = name_of(list, i);
    qsort(name, (size_t)list->n, sizeof *name, compare_names);
    for (int i = 1; i < list->n && !*has; i++)
        *has = strcmp(name[i - 1], name[i]) == 0;
    free(name);
    return LW_OK;
}

static lw_status check_names(const name_list *list, int *bad, lw_error *e)
{
    bool search = list->n <= FEW;
    for (int i = 0; i < list->n; i++) {
        *bad = i;
        if (!memchr(name_of(list, i), '\0', LW_NAME_SIZE))
            return lw_error_set(e, LW_E_ARG, "the name of %s %d is not terminated", list->what, i + 1);
        if (!*name_of(list, i))
            return lw_error_set(e, LW_E_ARG, "%s %d has no name; give it one", list->what, i + 1);
        if (lw_text_has_control(name_of(list, i)))
            return lw_error_set(e, LW_E_ARG, "the name of %s %d holds a control character", list->what, i + 1);
    }
    if (!search && has_same_names(list, &search) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; search && i < list->n; i++) {
        int j = same_name(list, i);
        *bad = i;
        if (j >= 0)
            return lw_error_set(e, LW_E_ARG, "%ss %d and %d are both called \"%s\"; names of %ss "
                                "must differ", list->what, j + 1, i + 1, name_of(list, i), list->what);
    }
    return LW_OK;
}

/* ---- parts ------------------------------------------------------------------------------------ */

static lw_status check_counts(const lw_assembly *assembly, lw_error *e)
{
    const struct { const char *what; int n, least; } count[] = {
        { "links", assembly->n_link, 2 },
        { "joints", assembly->n_joint, 1 },
        { "inputs", assembly->n_input, 0 },
        { "tracers", assembly->n_tracer, 0 },
    };
    for (size_t i = 0; i < sizeof count/sizeof *count; i++)
        if (count[i].n < count[i].least || count[i].n > LW_PART_MAX)
            return lw_error_set(e, LW_E_ARG, "a linkage has at least %d %s, this one has %d", count[i].least, count[i].what, count[i].n);
    if (!in_range(assembly->ground, assembly->n_link))
        return lw_error_set(e, LW_E_ARG, "the ground is link number %d, which does not exist", assembly->ground);
    if (!(assembly->units.metre > 0 && isfinite(assembly->units.metre) && assembly->units.radian > 0 && isfinite(assembly->units.radian)))
        return lw_error_set(e, LW_E_ARG, "units must be positive and finite; use lw_units_si()");
    if (!memchr(assembly->name, '\0', sizeof assembly->name))
        return lw_error_set(e, LW_E_ARG, "the name of the linkage is not terminated");
    if (lw_text_has_control(assembly->name))
        return lw_error_set(e, LW_E_ARG, "the name of the linkage holds a control character");
    return LW_OK;
}

/* A slide line needs a direction of unit length.  Other joints must not have a direction: a nonzero one means that
 * the writer meant another kind of joint. */
static lw_status check_direction(const lw_joint *j, lw_error *e)
{
    bool slides = lw_joint_slides(j->kind);
    double size = hypot(j->along.x, j->along.y);
    if (slides && !(fabs(size - 1) <= 1e-9))
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" slides, so `along` must be a direction of length 1; "
                            "it has length %.3g", j->name, size);
    if (!slides && size != 0)
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" of kind '%c' has no direction; `along` belongs to "
                            "kinds 't' and 'p'", j->name, (char)j->kind);
    if (lw_joint_has_ratio(j->kind) && !(sane(j->ratio) && j->ratio != 0))
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" is a gear, so its ratio must be a number other than 0", j->name);
    if (!lw_joint_has_ratio(j->kind) && j->ratio != 0)
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" of kind '%c' has no ratio; only gears ('g') have", j->name, (char)j->kind);
    return LW_OK;
}

static lw_status check_joint(const lw_assembly *assembly, const lw_joint *j, lw_error *e)
{
    if (!lw_joint_is_kind((char)j->kind))
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" is of no known kind: r pin, t slider, p pin in "
                            "slot, g gear, f fixed, n free", j->name);
    if (!in_range(j->link[0], assembly->n_link) || !in_range(j->link[1], assembly->n_link))
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" joins links number %d and %d; there are links 0 to "
                            "%d", j->name, j->link[0], j->link[1], assembly->n_link - 1);
    if (j->link[0] == j->link[1])
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" joins link \"%s\" to itself; name two links",
                            j->name, assembly->link_name[j->link[0]]);
    if (!sane(j->at.x) || !sane(j->at.y))
        return lw_error_set(e, LW_E_ARG, "the place of joint \"%s\" is not finite or beyond %g m", j->name, LW_COORDINATE_MAX);
    return check_direction(j, e);
}

/* driven: which joints the inputs before drive (n_joint) */
static lw_status check_input(const lw_assembly *assembly, int i, bool *driven, lw_error *e)
{
    const lw_input *in = &assembly->input[i];
    if (!in_range(in->joint, assembly->n_joint))
        return lw_error_set(e, LW_E_ARG, "input %d drives joint number %d, which does not exist", i + 1, in->joint);
    const lw_joint *j = &assembly->joint[in->joint];
    if (!lw_joint_can_drive(j->kind))
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" of kind '%c' cannot be driven; an input is a pin "
                            "('r') or a slider ('t')", j->name, (char)j->kind);
    if (driven[in->joint])
        return lw_error_set(e, LW_E_ARG, "joint \"%s\" is driven twice; drop one input", j->name);
    driven[in->joint] = true;
    if (!sane(in->value) || !sane(in->first) || !sane(in->last) || !sane(in->ratio))
        return lw_error_set(e, LW_E_ARG, "the input at joint \"%s\" has a number that is not finite", j->name);
    if (i == 0 && in->ratio != 0)
        return lw_error_set(e, LW_E_ARG, "the first input, at joint \"%s\", has a ratio: there is none before it "
                            "that it could be tied to", j->name);
    if (i > 0 && in->ratio == 0 && assembly->input[i - 1].ratio != 0)
        return lw_error_set(e, LW_E_ARG, "the input at joint \"%s\" moves by itself and stands after one that is "
                            "tied to the first by its ratio; put it before that one", j->name);
    return LW_OK;
}

static lw_status check_tracer(const lw_assembly *assembly, const lw_tracer *t, lw_error *e)
{
    if (!in_range(t->link, assembly->n_link))
        return lw_error_set(e, LW_E_ARG, "tracer \"%s\" sits on link number %d, which does not exist", t->name, t->link);
    if (!sane(t->at.x) || !sane(t->at.y) || !sane(t->angle))
        return lw_error_set(e, LW_E_ARG, "tracer \"%s\" has a number that is not finite", t->name);
    return LW_OK;
}

static lw_status check_inputs(const lw_assembly *assembly, lw_linkage_place *place, lw_error *e)
{
    bool few[FEW] = { false }, *driven = assembly->n_joint > FEW ? calloc((size_t)assembly->n_joint, sizeof *driven) : few;
    lw_status s = driven ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < assembly->n_input && s == LW_OK; i++) {
        *place = (lw_linkage_place){ LW_PART_INPUT, i };
        s = check_input(assembly, i, driven, e);
    }
    if (driven != few)
        free(driven);
    return s;
}

/* ---- the whole -------------------------------------------------------------------------------- */

/* Index of a link that no path of joints connects to the ground; -1 if there is none, -2 without memory. */
static int find_loose_link(const lw_assembly *assembly)
{
    int few[FEW], *head = assembly->n_link > FEW ? malloc((size_t)assembly->n_link*sizeof *head) : few, loose = -1;
    if (!head)
        return -2;
    for (int i = 0; i < assembly->n_link; i++)
        head[i] = i;
    for (int i = 0; i < assembly->n_joint; i++)
        head[lw_root_of(head, assembly->joint[i].link[0])] = lw_root_of(head, assembly->joint[i].link[1]);
    for (int i = 0; i < assembly->n_link && loose < 0; i++)
        loose = lw_root_of(head, i) == lw_root_of(head, assembly->ground) ? -1 : i;
    if (head != few)
        free(head);
    return loose;
}

/* Names of links, joints and tracers first: later messages quote them. */
static lw_status check_all_names(const lw_assembly *assembly, lw_linkage_place *place, lw_error *e)
{
    const struct { lw_linkage_part part; name_list names; } list[] = {
        { LW_PART_LINK, { "link", (const char *)assembly->link_name, sizeof *assembly->link_name, assembly->n_link } },
        { LW_PART_JOINT,
          { "joint", (const char *)((uintptr_t)assembly->joint + offsetof(lw_joint, name)), sizeof *assembly->joint,
            assembly->n_joint } },
        { LW_PART_TRACER,
          { "tracer", (const char *)((uintptr_t)assembly->tracer + offsetof(lw_tracer, name)), sizeof *assembly->tracer,
            assembly->n_tracer } },
    };
    lw_status s = LW_OK;
    for (size_t i = 0; s == LW_OK && i < sizeof list/sizeof *list; i++) {
        place->part = list[i].part;
        s = check_names(&list[i].names, &place->index, e);
    }
    return s;
}

lw_status lw_assembly_find_fault(const lw_assembly *assembly, lw_linkage_place *place, lw_error *e)
{
    lw_status s;
    *place = (lw_linkage_place){ LW_PART_WHOLE, 0 };
    if ((s = check_counts(assembly, e)) != LW_OK || (s = check_all_names(assembly, place, e)) != LW_OK)
        return s;
    for (int i = 0; i < assembly->n_joint; i++) {
        *place = (lw_linkage_place){ LW_PART_JOINT, i };
        if ((s = check_joint(assembly, &assembly->joint[i], e)) != LW_OK)
            return s;
    }
    if ((s = check_inputs(assembly, place, e)) != LW_OK)
        return s;
    for (int i = 0; i < assembly->n_tracer; i++) {
        *place = (lw_linkage_place){ LW_PART_TRACER, i };
        if ((s = check_tracer(assembly, &assembly->tracer[i], e)) != LW_OK)
            return s;
    }
    *place = (lw_linkage_place){ LW_PART_LINK, assembly->has_nodes ? -1 : find_loose_link(assembly) };
    if (place->index == -2)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (place->index >= 0)
        return lw_error_set(e, LW_E_ARG, "no chain of joints ties link \"%s\" to the ground; join it or "
                            "leave it out", assembly->link_name[place->index]);
    return LW_OK;
}

lw_status lw_assembly_check(const lw_assembly *assembly, lw_error *e)
{
    lw_linkage_place place;
    return lw_assembly_find_fault(assembly, &place, e);
}

lw_status lw_linkage_check(const lw_linkage *linkage, lw_error *e)
{
    const struct { const char *what; int n, most; } count[] = {
        { "links", linkage->n_link, LW_LINK_MAX }, { "joints", linkage->n_joint, LW_JOINT_MAX },
        { "inputs", linkage->n_input, LW_INPUT_MAX }, { "tracers", linkage->n_tracer, LW_TRACER_MAX },
    };
    for (size_t i = 0; i < sizeof count/sizeof *count; i++)
        if (count[i].n > count[i].most)
            return lw_error_set(e, LW_E_ARG, "a linkage has at most %d %s, this one has %d", count[i].most, count[i].what, count[i].n);
    lw_assembly a = lw_linkage_view(linkage);
    return lw_assembly_check(&a, e);
}
