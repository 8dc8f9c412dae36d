#include "optimise/search/families.h"

#include <stdio.h>

/* Copy f, its linkage and its name. */
static void copy_family(const lw_family *f, lw_family_made *made)
{
    made->family = *f;
    made->linkage = *f->linkage;
    snprintf(made->name, sizeof made->name, "%s", f->name);
    made->family.linkage = &made->linkage;
    made->family.name = made->name;
}

static lw_status make_of_array(const void *of, int i, lw_family_made *made)
{
    copy_family((const lw_family *)of + i, made);
    return LW_OK;
}

static lw_turn turn_of_array(const void *of, int i)
{
    return ((const lw_family *)of)[i].posture ? LW_TURN_START : LW_TURN_DYADS;
}

lw_families lw_families_of(const lw_family *family, int n)
{
    return (lw_families){ n, make_of_array, turn_of_array, family };
}

static lw_status make_of_pair(const void *of, int i, lw_family_made *made)
{
    const lw_families_pair *p = of;
    return i < p->first.n ? p->first.make(p->first.of, i, made)
                          : p->second.make(p->second.of, i - p->first.n, made);
}

static lw_turn turn_of_pair(const void *of, int i)
{
    const lw_families_pair *p = of;
    return i < p->first.n ? p->first.turn(p->first.of, i) : p->second.turn(p->second.of, i - p->first.n);
}

lw_families lw_families_join(const lw_families_pair *pair)
{
    return (lw_families){ pair->first.n + pair->second.n, make_of_pair, turn_of_pair, pair };
}
