/* Make the frames, dimensions, registers and steps of a plan from its topology. */
#include "mbs/plan/plan_build_internal.h"

#include <string.h>

typedef lw_builder builder;

static bool is_slider(const builder *b, int j) { return lw_build_is_slider(b, j); }

/* ---- frames ------------------------------------------------------------------------------------ */

/* Are the lines of two sliders not parallel? */
static bool across(const builder *b, int i, int j)
{
    lw_vec2 u = b->t->k->joint[i].along, v = b->t->k->joint[j].along;
    return fabs(lw_v2_cross(u, v)) > 1e-9;
}

/* List the needed joints on the ground in the order of use. */
static int ground_joints(const lw_topology *t, int *joint)
{
    int n = 0;
    if (t->driven >= 0)
        joint[n++] = t->input_joint;
    for (int i = 0; i < t->n_group; i++) {
        const lw_plan_group *g = &t->group[i];
        const lw_cluster *c = &t->cluster[g->cluster];
        for (int side = 0; side < (lw_plan_group_is_gear(g) ? 1 : 2) && g->kind != LW_STEP_HIGHER; side++)
            if ((g->need[0] || g->need[1]) && g->base[side] == t->k->ground)
                joint[n++] = g->joint[2*side];
        for (int h = 0; g->kind == LW_STEP_HIGHER && c->need && h < c->n_link + c->n_loop; h++) {
            const lw_tie *q = h < c->n_link ? &c->reach[h] : &c->loop[h - c->n_link];
            if (q->a == t->k->ground)
                joint[n++] = q->joint;
        }
    }
    return n;
}

/* The ground frame lies on the first two pins, or a pin and a line, or two lines, in the order of use. */
static void ground_frame(builder *b)
{
    const lw_topology *t = b->t;
    int pin[2] = { -1, -1 }, line[2] = { -1, -1 }, n_pin = 0, n_line = 0, joint[2*LW_JOINT_MAX];
    int n = ground_joints(t, joint);
    for (int i = 0; i < n; i++) {
        int j = joint[i];
        if (is_slider(b, j)) {
            if (n_line < 2)
                line[n_line++] = j;
        } else if (n_pin < 2 && (n_pin == 0 || pin[0] != t->pin[j]))
            pin[n_pin++] = t->pin[j];
    }
    if (n_line == 2 && !across(b, line[0], line[1]))
        line[1] = -1;
    b->p->frame[t->k->ground] = (lw_frame){ pin[0], { line[0], line[1] }, n_pin > 1 ? pin[1] : line[0], -1 };
}

static lw_frame input_frame(const builder *b)
{
    const lw_topology *t = b->t;
    if (!is_slider(b, t->input_joint))
        return lw_build_turning_frame(b, t->driven, t->input_joint);
    lw_frame f = { -1, { t->input_joint, -1 }, t->input_joint, -1 };
    for (int j = t->k->n_joint - 1; j >= 0; j--)
        if (j != t->input_joint && lw_joint_has(&t->k->joint[j], t->driven)) {
            if (!is_slider(b, j))
                f.origin = t->pin[j];
            else if (across(b, j, t->input_joint))
                f.meet[1] = j;
        }
    return f;
}

/* The frame of a link of a dyad, by its joints. */
static lw_frame dyad_frame(const builder *b, int outer, int inner, int other_outer)
{
    const int *pin = b->t->pin;
    bool p_outer = is_slider(b, outer), p_inner = is_slider(b, inner);
    if (!p_outer)                                /* RRx: axis towards the inner pin; RPx: along a slide */
        return (lw_frame){ pin[outer], { -1, -1 },
                           !p_inner ? pin[inner] : is_slider(b, other_outer) ? other_outer : inner, -1 };
    if (!p_inner)
        return (lw_frame){ pin[inner], { -1, -1 }, outer, -1 };
    return (lw_frame){ -1, { outer, inner }, outer, -1 };
}

static void set_frames(builder *b)
{
    const lw_topology *t = b->t;
    lw_frame *frame = b->p->frame;
    ground_frame(b);
    if (t->driven >= 0) {
        frame[t->driven] = input_frame(b);
        lw_build_slider(b, t->input_joint, t->k->ground, frame[t->driven].origin);
    }
    for (int i = 0; i < t->n_group; i++) {
        const lw_plan_group *g = &t->group[i];
        if (g->kind == LW_STEP_HIGHER) {
            lw_build_higher_frames(b, &t->cluster[g->cluster]);
            continue;
        }
        if (lw_plan_group_is_gear(g)) {
            if (g->kind == LW_STEP_RACK)
                lw_build_rack_frame(b, g);
            else
                lw_build_gear_frame(b, g);
            continue;
        }
        const int *j = g->joint;
        frame[g->link[0]] = dyad_frame(b, j[0], j[1], j[2]);
        frame[g->link[1]] = dyad_frame(b, j[2], j[1], j[0]);
        int ref = is_slider(b, j[1]) ? -1 : t->pin[j[1]];
        lw_build_slider(b, j[0], g->base[0], ref);
        lw_build_slider(b, j[2], g->base[1], ref);
        bool first_has_pin = !is_slider(b, j[0]);       /* PPR: the inner line is of the slider link */
        bool second_has_pin = !is_slider(b, j[2]);
        lw_build_slider(b, j[1], g->link[!second_has_pin], t->pin[second_has_pin ? j[2] : first_has_pin ? j[0] : 0]);
    }
}

/* ---- steps ------------------------------------------------------------------------------------- */

static void emit_input(builder *b)
{
    const lw_topology *t = b->t;
    int j = t->input_joint, q, w;
    lw_build_link(b, t->k->ground, LW_ORIGIN_REG, LW_AXIS_REG);
    if (t->driven < 0) {                            /* a higher group takes the turn or displacement */
        lw_step *s = lw_build_step(b, is_slider(b, j) ? LW_STEP_INPUT_SLIDE : LW_STEP_INPUT_PIN);
        if (is_slider(b, j)) {
            s->in[0] = LW_ORIGIN_REG;
            s->in[1] = LW_AXIS_REG;
        }
        s->out[0] = lw_build_reg(b);
        b->input_reg = is_slider(b, j) ? s->out[0] : lw_build_turns_per_period(b, s->out[0]);
        return;
    }
    if (!is_slider(b, j)) {
        lw_step *s = lw_build_step(b, LW_STEP_INPUT_PIN);
        b->period_reg = s->out[0] = lw_build_reg(b);
        lw_build_link(b, t->driven, lw_build_pin(b, j, t->k->ground), lw_build_turns_per_period(b, b->period_reg));
        return;
    }
    lw_build_line(b, j, t->k->ground, &q, &w);
    lw_step *s = lw_build_step(b, LW_STEP_INPUT_SLIDE);
    s->in[0] = q;
    s->in[1] = w;
    lw_build_link(b, t->driven, s->out[0] = lw_build_reg(b), w);
    if (b->p->frame[t->driven].origin >= 0)
        b->pin_reg[b->p->frame[t->driven].origin] = s->out[0];
}

static void emit_rrr(builder *b, const lw_plan_group *g)
{
    int in0 = lw_build_pin(b, g->joint[0], g->base[0]), in1 = lw_build_pin(b, g->joint[2], g->base[1]);
    int r0 = lw_build_dim(b, LW_ROLE_R, g->link[0], b->t->pin[g->joint[1]], 0);
    int r1 = lw_build_dim(b, LW_ROLE_R, g->link[1], b->t->pin[g->joint[1]], 0);
    lw_step *s = lw_build_step(b, LW_STEP_RRR);
    s->in[0] = in0;
    s->in[1] = in1;
    s->dim[0] = r0;
    s->dim[1] = r1;
    lw_build_link(b, g->link[0], in0, s->out[0] = lw_build_reg(b));
    lw_build_link(b, g->link[1], in1, s->out[1] = g->need[1] ? lw_build_reg(b) : -1);
    b->pin_reg[b->t->pin[g->joint[1]]] = s->out[2] = lw_build_reg(b);
    s->dyad = b->p->n_dyad;
}

static void emit_rrp(builder *b, const lw_plan_group *g)
{
    int pin = is_slider(b, g->joint[0]), slide = !pin, q, w;       /* sides of the dyad */
    int in0 = lw_build_pin(b, g->joint[2*pin], g->base[pin]);
    lw_build_line(b, g->joint[2*slide], g->base[slide], &q, &w);
    int r = lw_build_dim(b, LW_ROLE_R, g->link[pin], b->t->pin[g->joint[1]], 0);
    lw_step *s = lw_build_step(b, LW_STEP_RRP);
    s->in[0] = in0;
    s->in[1] = q;
    s->in[2] = w;
    s->dim[0] = r;
    lw_build_link(b, g->link[pin], in0, s->out[0] = lw_build_reg(b));
    b->pin_reg[b->t->pin[g->joint[1]]] = s->out[1] = lw_build_reg(b);
    lw_build_link(b, g->link[slide], s->out[1], w);
    s->dyad = b->p->n_dyad;
}

static void emit_rpr(builder *b, const lw_plan_group *g)
{
    int in0 = lw_build_pin(b, g->joint[0], g->base[0]), in1 = lw_build_pin(b, g->joint[2], g->base[1]);
    int e = lw_build_dim(b, LW_ROLE_E, g->link[0], g->joint[1], 0);
    lw_step *s = lw_build_step(b, LW_STEP_RPR);
    s->in[0] = in0;
    s->in[1] = in1;
    s->dim[0] = e;
    s->out[0] = lw_build_reg(b);
    lw_build_link(b, g->link[0], in0, s->out[0]);
    lw_build_link(b, g->link[1], in1, s->out[0]);
    b->p->slider_dir[g->joint[1]] = s->out[0];
    s->dyad = b->p->n_dyad;
}

static void emit_prp(builder *b, const lw_plan_group *g)
{
    int q[2], w[2];
    lw_build_line(b, g->joint[0], g->base[0], &q[0], &w[0]);
    lw_build_line(b, g->joint[2], g->base[1], &q[1], &w[1]);
    lw_step *s = lw_build_step(b, LW_STEP_PRP);
    for (int i = 0; i < 2; i++) {
        s->in[2*i] = q[i];
        s->in[2*i + 1] = w[i];
    }
    b->pin_reg[b->t->pin[g->joint[1]]] = s->out[0] = lw_build_reg(b);
    lw_build_link(b, g->link[0], s->out[0], w[0]);
    lw_build_link(b, g->link[1], s->out[0], w[1]);
    s->dyad = b->p->n_dyad;
}

/* The outer slide line meets the inner slide line, which passes through the pin of the other link.  No link turns
 * against the outer slide, so that both have its direction. */
static void emit_ppr(builder *b, const lw_plan_group *g)
{
    int pin = is_slider(b, g->joint[0]), slide = !pin, q, w;
    int in = lw_build_pin(b, g->joint[2*pin], g->base[pin]);
    lw_build_line(b, g->joint[2*slide], g->base[slide], &q, &w);
    lw_build_link(b, g->link[pin], in, w);
    if (!g->need[slide])
        return;
    lw_step *s = lw_build_step(b, LW_STEP_LINE);
    s->in[0] = in;
    s->in[1] = w;
    s->dim[1] = lw_build_dim(b, LW_ROLE_BETA, g->link[slide], g->joint[1], 0);
    int at = s->out[0] = lw_build_reg(b), v = s->out[1] = lw_build_reg(b);
    b->p->slider_dir[g->joint[1]] = v;
    s = lw_build_step(b, LW_STEP_PPR);
    s->in[0] = q;
    s->in[1] = w;
    s->in[2] = at;
    s->in[3] = v;
    lw_build_link(b, g->link[slide], s->out[0] = lw_build_reg(b), w);
    s->dyad = b->p->n_dyad;
}

static void emit_groups(builder *b)
{
    for (int i = 0; i < b->t->n_group; i++) {
        const lw_plan_group *g = &b->t->group[i];
        if (g->kind == LW_STEP_HIGHER && b->t->cluster[g->cluster].need)
            lw_build_higher(b, &b->t->cluster[g->cluster]);
        if (!g->need[0] && !g->need[1])
            continue;
        int before = b->p->n_step;
        switch (g->kind) {
        case LW_STEP_RRR: emit_rrr(b, g); break;
        case LW_STEP_RRP: emit_rrp(b, g); break;
        case LW_STEP_RPR: emit_rpr(b, g); break;
        case LW_STEP_PRP: emit_prp(b, g); break;
        case LW_STEP_PPR: emit_ppr(b, g); break;
        case LW_STEP_GEAR:
        case LW_STEP_ROLL:
        case LW_STEP_RACK: lw_build_gear(b, g); break;
        case LW_STEP_HIGHER: case LW_STEP_INPUT_PIN: case LW_STEP_INPUT_SLIDE: case LW_STEP_POINT: case LW_STEP_LINE:
        case LW_STEP_TURN: case LW_STEP_SLIDE: case LW_STEP_ALONG: break;          /* no groups, or built above */
        }
        if (b->p->n_step > before && b->p->step[b->p->n_step - 1].dyad == b->p->n_dyad)
            b->p->dyad[b->p->n_dyad++] = (lw_dyad){ { g->link[0], g->link[1] },
                                                    { g->joint[0], g->joint[1], g->joint[2] } };
    }
}

/* ---- outputs ------------------------------------------------------------------------------------ */

static void emit_outputs(builder *b, lw_plan_options options)
{
    lw_plan *p = b->p;
    for (int i = 0; i < b->t->k->n_tracer; i++) {
        if (!(options.tracers >> i & 1))
            continue;
        int o = p->n_output++, link = b->t->k->tracer[i].link;
        p->i_cx[o] = lw_build_dim(b, LW_ROLE_CX, link, i, o);
        p->i_cy[o] = lw_build_dim(b, LW_ROLE_CY, link, i, o);
        p->output_point[o] = lw_build_point(b, link, p->i_cx[o], p->i_cy[o]);
        p->output_dir[o] = p->link_dir[link];
        p->output_link[o] = link;
        p->output_tracer[o] = i;
    }
    p->i_x0 = lw_build_dim(b, LW_ROLE_X0, b->t->k->ground, -1, 0);
    p->i_y0 = lw_build_dim(b, LW_ROLE_Y0, b->t->k->ground, -1, 0);
    p->i_theta0 = lw_build_dim(b, LW_ROLE_THETA0, b->t->k->ground, -1, 0);
}

/* Find the steps that output o depends on, from the last to the first. */
static void slice_output(lw_plan *p, int o)
{
    bool need[LW_REG_MAX] = { false }, step[LW_STEP_MAX] = { false };
    unsigned char keep[LW_STEP_MAX] = { 0 };
    need[p->output_point[o]] = need[p->output_dir[o]] = need[p->link_origin[p->output_link[o]]] = true;
    for (int i = p->n_step - 1; i >= 0; i--) {
        const lw_step *s = &p->step[i];
        if (s->kind == LW_STEP_HIGHER) {
            step[i] = lw_build_higher_needs(&p->higher[s->dim[0]], need);
            continue;
        }
        for (int h = 0; h < 4; h++)
            if (s->out[h] >= 0 && need[s->out[h]])
                keep[i] |= (unsigned char)(1 << h);
        step[i] = keep[i] != 0;
        for (int h = 0; step[i] && h < 4; h++)
            if (s->in[h] >= 0)
                need[s->in[h]] = true;
    }
    for (int i = 0; i < p->n_step; i++)
        if (step[i]) {
            p->output_keep[o][p->n_output_step[o]] = keep[i];
            p->output_step[o][p->n_output_step[o]++] = (unsigned char)i;
        }
}

/* ---- finish ------------------------------------------------------------------------------------- */

static void renumber(int *d, const int *to)
{
    if (*d >= 0)
        *d = to[*d];
}

static void sort_dims(builder *b)
{
    lw_plan *p = b->p;
    lw_dim_info old[LW_DIM_MAX];
    int to[LW_DIM_MAX];
    memcpy(old, p->dim, sizeof old);
    for (int i = 0; i < p->n_dim; i++) {
        to[i] = 0;
        for (int j = 0; j < p->n_dim; j++)
            to[i] += b->place[j] < b->place[i];
        p->dim[to[i]] = old[i];
    }
    for (int i = 0; i < p->n_step; i++)
        for (int h = 0; h < 3 && p->step[i].kind != LW_STEP_HIGHER; h++)
            renumber(&p->step[i].dim[h], to);
    for (int g = 0; g < p->n_higher; g++)
        lw_build_higher_renumber(&p->higher[g], to);
    for (int o = 0; o < p->n_output; o++) {
        renumber(&p->i_cx[o], to);
        renumber(&p->i_cy[o], to);
    }
    renumber(&p->i_x0, to);
    renumber(&p->i_y0, to);
    renumber(&p->i_theta0, to);
}

/* Number the angles.  Their cosines and sines are computed before the steps. */
static void number_angles(lw_plan *p)
{
    for (int d = 0; d < p->n_dim; d++) {
        if (p->dim[d].kind != LW_DIM_ANGLE)
            continue;
        for (int i = 0; i < p->n_step; i++)
            if ((p->step[i].kind == LW_STEP_LINE && p->step[i].dim[1] == d) || (p->step[i].kind == LW_STEP_GEAR && p->step[i].dim[0] == d))
                p->step[i].dim[2] = p->n_angle;
        for (int g = 0; g < p->n_higher; g++)
            lw_build_higher_angle(&p->higher[g], d, p->n_angle);
        p->angle[p->n_angle++] = d;
    }
}

/* The point of a slider is its pin, or else the origin of the link that slides on the line. */
static void set_joint_points(builder *b)
{
    const lw_linkage *k = b->t->k;
    lw_plan *p = b->p;
    for (int j = 0; j < k->n_joint; j++)
        if (lw_joint_has_ratio(k->joint[j].kind))
            continue;
        else if (!is_slider(b, j))
            p->joint_point[j] = b->pin_reg[b->t->pin[j]];
        else if (p->slider_ref[j] >= 0)
            p->joint_point[j] = b->pin_reg[p->slider_ref[j]];
        else
            p->joint_point[j] = p->link_origin[lw_joint_other(&k->joint[j], p->slider_base[j])];
}

static void number_links(builder *b)
{
    const lw_topology *t = b->t;
    lw_plan *p = b->p;
    p->link[p->n_link++] = t->k->ground;
    if (t->driven >= 0)
        p->link[p->n_link++] = t->driven;
    for (int i = 0; i < t->n_group; i++) {
        const lw_plan_group *g = &t->group[i];
        const lw_cluster *c = &t->cluster[g->cluster];
        for (int l = 0; g->kind == LW_STEP_HIGHER && c->need && l < c->n_link; l++)
            p->link[p->n_link++] = c->reach[l].b;
        bool any = g->need[0] || g->need[1], alone = g->kind == LW_STEP_PPR;
        for (int s = 0; s < (lw_plan_group_is_gear(g) ? 1 : 2); s++)
            if (any && (g->need[s] || !alone || !is_slider(b, g->joint[2*s])))
                p->link[p->n_link++] = g->link[s];
    }
    for (int i = 0; i < p->n_link; i++)
        b->number[p->link[i]] = i + 1;
}

/* Is link[0] of an input slider between moving links reached from link[1]? */
static bool input_runs_back(const lw_topology *t)
{
    for (int i = 0; i < t->n_cluster; i++)
        for (int l = 0; l < t->cluster[i].n_link; l++)
            if (t->cluster[i].reach[l].joint == t->input_joint)
                return t->cluster[i].reach[l].a == t->k->joint[t->input_joint].link[1];
    return false;
}

static void start(builder *b)
{
    const lw_linkage *k = b->t->k;
    lw_plan *p = b->p;
    p->n_reg = 2;
    p->input_joint = b->t->input_joint;
    p->input_is_slider = is_slider(b, p->input_joint);
    for (int i = 0; i < LW_LINK_MAX; i++)
        p->link_origin[i] = p->link_dir[i] = -1;
    for (int j = 0; j < LW_JOINT_MAX; j++) {
        b->pin_reg[j] = p->joint_point[j] = p->slider_ref[j] = p->slider_base[j] = p->slider_dir[j] = -1;
        p->joint_pin[j] = j < k->n_joint ? b->t->pin[j] : -1;
        p->slider_sign[j] = 1;
    }
    const int *in = k->joint[p->input_joint].link;
    bool back = b->t->driven >= 0 ? in[1] == k->ground : p->input_is_slider && input_runs_back(b->t);
    p->input_link[0] = in[back];
    p->input_link[1] = in[!back];
    if (p->input_is_slider && back)
        p->slider_sign[p->input_joint] = -1;
}

/* Place the seeds of the higher groups in mode[], and their unknowns in the rows. */
static void set_modes(builder *b)
{
    lw_plan *p = b->p;
    p->n_mode = p->n_dyad;
    for (int g = 0; g < p->n_higher; g++) {
        p->higher[g].first_mode = p->n_mode;
        p->higher[g].first_row = p->n_row;
        p->n_mode += p->higher[g].n_turn + p->higher[g].n_disp;
        p->n_row += 2*p->higher[g].n_turn + p->higher[g].n_disp;
    }
    p->n_mode += p->n_higher > 0;
    b->full |= p->n_mode > LW_MODE_MAX;
}

lw_status lw_plan_emit(const lw_topology *t, lw_plan_options options, lw_plan *plan, lw_error *e)
{
    builder b = { .t = t, .p = plan };
    start(&b);
    number_links(&b);
    set_frames(&b);
    emit_input(&b);
    emit_groups(&b);
    emit_outputs(&b, options);
    set_modes(&b);
    if (b.full)
        return lw_error_set(e, LW_E_KIND,
                            "the plan needs more than %d dimensions, %d steps, %d registers or %d numbers of "
                            "assembly", LW_DIM_MAX, LW_STEP_MAX, LW_REG_MAX, LW_MODE_MAX);
    set_joint_points(&b);
    sort_dims(&b);
    number_angles(plan);
    for (int o = 0; o < plan->n_output; o++)
        slice_output(plan, o);
    for (int o = 0; o < plan->n_output; o++)
        plan->output_fast_dyad[o] = lw_plan_find_fast_dyad(plan, o);
    return LW_OK;
}
