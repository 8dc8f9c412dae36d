/* All six-link mechanisms with pins and sliders whose input is at the ground, one a line, with the class of their
 * hardest Assur group: chains and mechanisms by callbacks.
 *
 *     cc topologies.c $(pkg-config --cflags --libs linkwright) -o topologies
 *     ./topologies | cut -c 1 | sort | uniq -c                                                            */
#include <linkwright.h>
#include <stdio.h>

typedef struct listing { int chains, mechanisms, hardest; } listing;

static lw_status see_group(void *context, const lw_group_info *group)
{
    listing *l = context;
    if (group->group_class > l->hardest)
        l->hardest = group->group_class;
    return LW_OK;
}

static lw_status print_mechanism(void *context, const lw_mechanism *mechanism)
{
    listing *l = context;
    char *text = NULL;
    l->hardest = 0;
    l->mechanisms++;
    lw_status status = lw_mechanism_groups(mechanism, see_group, l, NULL);
    if (status == LW_OK)
        status = lw_mechanism_to_text(mechanism, "edges", &text, NULL);
    if (status == LW_OK)
        printf("%d  %s\n", l->hardest, text);
    lw_free(text);
    return status;
}

static lw_status each_chain(void *context, const lw_chain *chain)
{
    listing *l = context;
    lw_choices choices = lw_choices_default();
    lw_mechanism *mechanism;
    choices.kinds = "rt";
    choices.inputs = 1;
    l->chains++;
    lw_status status = lw_mechanism_of_chain(chain, &mechanism);
    if (status == LW_OK)
        status = lw_enumerate_mechanisms(mechanism, &choices, print_mechanism, l, NULL, NULL);
    lw_mechanism_destroy(mechanism);
    return status;
}

int main(void)
{
    lw_enumeration six = lw_enumeration_default(6, 1);
    listing l = { 0 };
    lw_error error;
    if (lw_enumerate_chains(&six, each_chain, &l, &error) != LW_OK) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    fprintf(stderr, "%d mechanisms of %d chains\n", l.mechanisms, l.chains);
    return l.chains == 2 && l.mechanisms > 0 ? 0 : 1;            /* Watt's and Stephenson's */
}
