/* catalogues/exchange/export.c - functions that several writers use. */
#include "catalogues/exchange/export.h"
#include "base/real.h"
#include "catalogues/draw/scene.h"

double lw_export_constant(const lw_expression *x) { return x ? lw_expression_value(x, NULL) : 0; }

bool lw_export_varies(const lw_expression *x)
{
    const int *which;
    return x && lw_expression_variables(x, &which) > 0;
}

lw_status lw_export_states(const lw_states *z, const char *format, lw_error *e)
{
    const char *name = z->n_state ? z->state[0].name : z->n_signal ? z->signal[0].name : NULL;
    if (!name)
        return LW_OK;
    return lw_error_set(e, LW_E_KIND, "'%s' is a variable of first order, or a value that stands on one, which is not written to %s: take circuits of "
                        "motors, controllers, cylinders, integrals and lags out of a copy of the file to export the rest", name, format);
}

double lw_export_size(const lw_assembly *linkage)
{
    double d = 0;
    for (int j = 1; j < linkage->n_joint; j++)
        d = fmax(d, lw_v2_norm(lw_v2_sub(linkage->joint[j].at, linkage->joint[0].at)));
    for (int t = 0; t < linkage->n_tracer; t++)
        d = fmax(d, lw_v2_norm(lw_v2_sub(linkage->tracer[t].at, linkage->joint[0].at)));
    return d;
}

/* The pin of a link with the carrier at the centre; -1: none. */
static int pin_on_carrier(const lw_assembly *linkage, int link, int carrier, lw_vec2 centre)
{
    for (int j = 0; j < linkage->n_joint; j++) {
        const lw_joint *p = &linkage->joint[j];
        bool joins = (p->link[0] == link && p->link[1] == carrier) || (p->link[1] == link && p->link[0] == carrier);
        if (joins && lw_joint_turns(p->kind) && p->at.x == centre.x && p->at.y == centre.y)
            return j;
    }
    return -1;
}

lw_status lw_export_gear(const lw_assembly *linkage, int gear, int joint[2], double sign[2], lw_error *e)
{
    lw_gear g;
    lw_status s = lw_assembly_gear(linkage, gear, &g, NULL, e);
    for (int i = 0; s == LW_OK && i < 2; i++) {
        int link = linkage->joint[gear].link[i];
        joint[i] = g.slider[i] >= 0 ? g.slider[i] : pin_on_carrier(linkage, link, g.carrier, g.centre[i]);
        if (joint[i] < 0)
            return lw_error_set(e, LW_E_KIND,
                                "gear '%s': '%s' turns on '%s' by no pin of their own, which this format needs",
                                linkage->joint[gear].name, linkage->link_name[link], linkage->link_name[g.carrier]);
        const lw_joint *p = &linkage->joint[joint[i]];
        bool second = g.slider[i] < 0 && p->link[1] == linkage->ground ? p->link[0] == link : p->link[1] == link;
        sign[i] = g.slider[i] >= 0 ? g.way[i] : second ? 1 : -1;
    }
    return s;
}

lw_status lw_export_way(const lw_assembly *linkage, const lw_model *m, int input, double *down, double *up, bool *turns, bool *ends)
{
    const lw_input *in = &linkage->input[input];
    bool slider = lw_joint_slides(linkage->joint[in->joint].kind);
    lw_scene scene;
    *turns = *ends = false;
    if (in->first < in->last) {
        *down = in->value - in->first;
        *up = in->last - in->value;
        return LW_OK;
    }
    *down = *up = slider ? 0.1*lw_export_size(linkage) : 0.1;
    const lw_scene_options o = { .n_frame = 181, .n_curve_point = 8 };
    if (linkage->n_input > 1 && linkage->input[1].ratio == 0)          /* several move by themselves */
        return LW_OK;
    lw_status s = lw_scene_make_any(linkage, m, NULL, &o, &scene, NULL);
    if (s != LW_OK)
        return s == LW_E_MEMORY ? s : LW_OK;
    double here = scene.input[scene.first_frame], least = here, most = here;
    for (size_t f = 0; f < scene.n_frame; f++) {
        least = fmin(least, scene.input[f]);
        most = fmax(most, scene.input[f]);
    }
    *turns = !slider && scene.loops && most - least > 1.95*LW_PI;
    if (scene.n_frame > 1) {
        *down = here - least;
        *up = most - here;
        *ends = !*turns && (scene.loops || (!slider && most - least < 2*LW_PI));
    }
    lw_scene_free(&scene);
    return LW_OK;
}

void lw_export_law_within(double down, double up, double part, lw_export_law *law)
{
    double middle = 0.5*(up - down);
    law->half = part*0.5*(up + down);
    law->phase = law->half > 0 ? asin(fmax(-1, fmin(1, -middle/law->half))) : 0;
}

lw_status lw_export_law_of(const lw_assembly *linkage, const lw_model *m, int input, lw_export_law *law)
{
    double down, up;
    bool ends;
    *law = (lw_export_law){ .turns = false };
    lw_status s = lw_export_way(linkage, m, input, &down, &up, &law->turns, &ends);
    if (s != LW_OK || law->turns)
        return s;
    lw_export_law_within(down, up, 0.99, law);
    return LW_OK;
}
