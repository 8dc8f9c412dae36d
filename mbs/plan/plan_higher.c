/* Higher groups in a plan: the frames of their links, their loops as sums of vectors, and the steps that give the
 * frames from the solved directions and displacements. */
#include "mbs/plan/plan_build_internal.h"

#include <string.h>

typedef lw_builder builder;

/* ---- frames ------------------------------------------------------------------------------------------- */

static bool carries_pin(const lw_topology *t, int link, int j)
{
    return lw_joint_turns(t->k->joint[j].kind) && t->pin[j] == j && t->on_pin[j] >> link & 1;
}

/* A pin of the link other than `not`, if possible one shared with the group or a known link; -1 when there is none. */
static int other_pin(const lw_topology *t, const lw_cluster *c, int link, int not)
{
    int any = -1;
    for (int j = 0; j < t->k->n_joint; j++) {
        if (!carries_pin(t, link, j) || j == not || (not >= 0 && lw_same_place(t->k->joint[j].at, t->k->joint[not].at)))
            continue;
        if (t->on_pin[j] & (c->links | c->bases) & ~(1u << link))
            return j;
        any = any < 0 ? j : any;
    }
    return any;
}

static int other_slider(const lw_topology *t, int link, int not)
{
    for (int j = 0; j < t->k->n_joint; j++)
        if (j != not && lw_joint_translates(t->k->joint[j].kind) && lw_joint_has(&t->k->joint[j], link))
            return j;
    return -1;
}

static lw_frame frame_of(const builder *b, const lw_cluster *c, const lw_tie *reach)
{
    const lw_topology *t = b->t;
    int via = reach->joint, link = reach->b;
    if (lw_build_is_slider(b, via)) {
        int pin = other_pin(t, c, link, -1);
        return (lw_frame){ pin, { via, pin < 0 ? other_slider(t, link, via) : -1 }, via, -1 };
    }
    int pin = other_pin(t, c, link, t->pin[via]);
    return (lw_frame){ t->pin[via], { -1, -1 }, pin >= 0 ? pin : other_slider(t, link, -1), -1 };
}

void lw_build_higher_frames(builder *b, const lw_cluster *c)
{
    for (int i = 0; i < c->n_link; i++) {
        const lw_tie *q = &c->reach[i];
        b->p->frame[q->b] = frame_of(b, c, q);
        lw_build_slider(b, q->joint, q->a, b->p->frame[q->b].origin);
    }
}

void lw_build_rack_frame(builder *b, const lw_plan_group *g)
{
    const lw_cluster c = { .n_link = 1, .reach = { { g->base[0], g->link[0], g->joint[0] } }, .links = 1u << g->link[0],
                           .bases = 1u << g->base[0] };
    lw_build_higher_frames(b, &c);
}

/* ---- loops -------------------------------------------------------------------------------------------- */

/* One vector of a path: known point, (x + iy) u, or d u. */
typedef struct term { int sign, dir, x, y, disp, point; } term;

#define PATH_MAX 64
typedef struct path { int n; term term[PATH_MAX]; } path;

typedef struct group_builder {
    builder *b;
    const lw_cluster *c;
    lw_higher *g;
    int   dir[LW_LINK_MAX];                /* number of each link's direction; -1: not in the group */
    int   line[LW_LINK_MAX][2];            /* point and direction of the known line a link slides on */
    path *at;                              /* path to each link's origin                            */
} group_builder;

/* Add a term to a path; it cancels the same term of opposite sign. */
static void add_term(group_builder *q, path *p, term t)
{
    for (int i = 0; i < p->n; i++) {
        const term *o = &p->term[i];
        if (o->sign == -t.sign && o->dir == t.dir && o->x == t.x && o->y == t.y && o->disp == t.disp
            && o->point == t.point) {
            p->term[i] = p->term[--p->n];
            return;
        }
    }
    if (p->n == PATH_MAX)
        q->b->full = true;
    else
        p->term[p->n++] = t;
}

static int add_dir(group_builder *q, lw_higher_dir d)
{
    if (q->g->n_dir == LW_HIGHER_DIR_MAX) {
        q->b->full = true;
        return 0;
    }
    q->g->dir[q->g->n_dir] = d;
    return q->g->n_dir++;
}

static bool in_group(const group_builder *q, int link) { return q->c->links >> link & 1; }

/* Add the path to pin `pin` on a link of the group or on a known link. */
static void path_to(group_builder *q, int link, int pin, int sign, path *p)
{
    if (!in_group(q, link)) {
        add_term(q, p, (term){ sign, -1, -1, -1, -1, lw_build_pin(q->b, pin, link) });
        return;
    }
    int x, y;
    for (int i = 0; i < q->at[link].n; i++) {
        term t = q->at[link].term[i];
        t.sign *= sign;
        add_term(q, p, t);
    }
    lw_build_pin_dims(q->b, link, pin, &x, &y);
    if (x >= 0 || y >= 0)
        add_term(q, p, (term){ sign, q->dir[link], x, y, -1, -1 });
}

/* The number of a new displacement; -2 stands for the input until the number of displacements is known. */
static int new_disp(group_builder *q, int joint)
{
    lw_higher *g = q->g;
    if (joint == q->b->t->input_joint) {
        g->disp_input = true;
        return -2;
    }
    g->disp_joint[g->n_disp] = joint;
    g->disp_reg[g->n_disp] = lw_build_reg(q->b);
    return g->n_disp++;
}

static void reach_by_slide(group_builder *q, const lw_tie *r)
{
    builder *b = q->b;
    path *p = &q->at[r->b];
    int disp = new_disp(q, r->joint), e, beta, dir;
    if (!in_group(q, r->a)) {
        lw_build_line(b, r->joint, r->a, &q->line[r->b][0], &q->line[r->b][1]);
        add_term(q, p, (term){ 1, -1, -1, -1, -1, q->line[r->b][0] });
        dir = add_dir(q, (lw_higher_dir){ -1, -1, (short)q->line[r->b][1], -1, -1, 0 });
    } else {
        *p = q->at[r->a];
        lw_build_line_dims(b, r->joint, r->a, &e, &beta);
        dir = q->dir[r->a];
        if (beta >= 0)
            dir = add_dir(q, (lw_higher_dir){ q->g->dir[dir].root, (short)dir, -1, (short)beta, -1, 0 });
        if (e >= 0)
            add_term(q, p, (term){ 1, dir, -1, e, -1, -1 });
    }
    q->dir[r->b] = dir;
    add_term(q, p, (term){ 1, dir, -1, -1, disp, -1 });
}

/* The number of a link's direction, -1 for the ground's. */
static int direction_of(group_builder *q, int link)
{
    const lw_topology *t = q->b->t;
    if (in_group(q, link))
        return q->dir[link];
    return link == t->k->ground ? -1 : add_dir(q, (lw_higher_dir){ -1, -1, (short)q->b->p->link_dir[link], -1, -1, 0 });
}

static void reach_by_pin(group_builder *q, const lw_tie *r)
{
    lw_higher *g = q->g;
    const lw_topology *t = q->b->t;
    const lw_joint *in = &t->k->joint[t->input_joint];
    path_to(q, r->a, t->pin[r->joint], 1, &q->at[r->b]);
    if (t->driven < 0 && t->pin[r->joint] == t->pin[t->input_joint] && lw_joint_has(in, r->a)
        && lw_joint_has(in, r->b)) {
        int from = direction_of(q, r->a);        /* a link that is known already, or of the group */
        q->dir[r->b] = add_dir(q, (lw_higher_dir){ g->dir[from].root, (short)from, (short)q->b->input_reg, -1, -1,
                                                   r->b == in->link[1] ? 1 : -1 });
        return;
    }
    g->turn_reg[g->n_turn] = lw_build_reg(q->b);
    g->turn_link[g->n_turn] = r->b;
    q->dir[r->b] = add_dir(q, (lw_higher_dir){ (short)g->n_turn, -1, (short)g->turn_reg[g->n_turn], -1, -1, 0 });
    g->n_turn++;
}

/* The number of the sum of the vectors of one direction in one loop. */
static int entry_of(group_builder *q, int loop, int dir)
{
    lw_higher *g = q->g;
    for (int i = 0; i < g->n_entry; i++)
        if (g->entry[i].loop == loop && g->entry[i].dir == dir)
            return i;
    if (g->n_entry == LW_HIGHER_TERM_MAX) {
        q->b->full = true;
        return 0;
    }
    g->entry[g->n_entry] = (lw_higher_entry){ (short)loop, (short)dir };
    return g->n_entry++;
}

static void put_loop(group_builder *q, int loop, const path *p)
{
    lw_higher *g = q->g;
    for (int i = 0; i < p->n; i++) {
        const term *t = &p->term[i];
        if (g->n_point == LW_HIGHER_TERM_MAX || g->n_slide == LW_HIGHER_TERM_MAX || g->n_vector == LW_HIGHER_TERM_MAX)
            q->b->full = true;
        else if (t->point >= 0)
            g->point[g->n_point++] = (lw_higher_point){ (short)loop, (short)t->sign, (short)t->point };
        else if (t->disp != -1)
            g->slide[g->n_slide++] = (lw_higher_slide){ (short)loop, (short)t->sign, (short)t->dir, (short)t->disp };
        else
            g->vector[g->n_vector++] = (lw_higher_vector){ (short)loop, (short)t->sign, (short)t->dir, (short)t->x,
                                                           (short)t->y, (short)entry_of(q, loop, t->dir) };
    }
}

static void set_loops(group_builder *q)
{
    lw_higher *g = q->g;
    const lw_cluster *c = q->c;
    for (int i = 0; i < c->n_link; i++) {
        const lw_tie *r = &c->reach[i];
        if (lw_build_is_slider(q->b, r->joint))
            reach_by_slide(q, r);
        else
            reach_by_pin(q, r);
        g->link[g->n_link++] = r->b;
    }
    for (int i = 0; i < c->n_loop; i++) {
        path p = { 0 };
        const lw_tie *r = &c->loop[i];
        path_to(q, r->a, q->b->t->pin[r->joint], 1, &p);
        path_to(q, r->b, q->b->t->pin[r->joint], -1, &p);
        put_loop(q, g->n_loop++, &p);
    }
    if (g->disp_input)
        g->disp_reg[g->n_disp] = q->b->input_reg;
    for (int i = 0; i < g->n_slide; i++)
        if (g->slide[i].disp == -2)
            g->slide[i].disp = (short)g->n_disp;
}

/* ---- gears -------------------------------------------------------------------------------------------- */

static int disp_number(const group_builder *q, int joint)
{
    int i = 0;
    while (i < q->g->n_disp && q->g->disp_joint[i] != joint)
        i++;
    return i;                                            /* n_disp: the input */
}

static void set_gears(group_builder *q)
{
    const lw_topology *t = q->b->t;
    for (int i = 0; i < q->c->n_gear; i++) {
        int joint = q->c->gear[i], disp = -1;
        const lw_gear *gear = &t->gear[joint];
        const int *link = t->k->joint[joint].link;
        int dir[3] = { direction_of(q, link[0]), direction_of(q, link[1]), direction_of(q, gear->carrier) };
        for (int side = 0; side < 2; side++)
            if (gear->slider[side] >= 0)
                disp = disp_number(q, gear->slider[side]);
        if (q->g->n_gear == LW_HIGHER_GEAR_MAX)
            q->b->full = true;
        else
            q->g->gear[q->g->n_gear++] = lw_build_gear_row(q->b, joint, dir, disp);
    }
}

/* ---- steps after the group ---------------------------------------------------------------------------- */

static int disp_of(const group_builder *q, int joint)
{
    for (int i = 0; i < q->g->n_disp; i++)
        if (q->g->disp_joint[i] == joint)
            return q->g->disp_reg[i];
    return q->b->input_reg;
}

/* Add the steps for the frames of the links, each from the link it is reached from. */
static void emit_links(group_builder *q)
{
    builder *b = q->b;
    for (int i = 0; i < q->c->n_link; i++) {
        const lw_tie *r = &q->c->reach[i];
        const lw_higher_dir *d = &q->g->dir[q->dir[r->b]];
        if (lw_build_is_slider(b, r->joint)) {
            int *line = q->line[r->b];
            if (in_group(q, r->a))
                lw_build_line(b, r->joint, r->a, &line[0], &line[1]);
            lw_build_ride(b, r->b, line[0], line[1], disp_of(q, r->joint));
            continue;
        }
        int origin = lw_build_pin(b, r->joint, r->a), dir = d->reg;
        if (d->input) {
            lw_step *s = lw_build_step(b, LW_STEP_TURN);
            s->in[0] = b->p->link_dir[r->a];
            s->in[1] = b->input_reg;
            s->power[0] = d->input;
            dir = s->out[0] = lw_build_reg(b);
        }
        lw_build_link(b, r->b, origin, dir);
    }
    for (int i = 0; i < q->c->n_loop; i++)
        lw_build_pin(b, q->c->loop[i].joint, q->c->loop[i].a);
}

void lw_build_higher(builder *b, const lw_cluster *c)
{
    path at[LW_LINK_MAX];
    group_builder q = { .b = b, .c = c, .g = &b->p->higher[b->p->n_higher], .at = at };
    if (2*c->n_loop + c->n_gear > LW_UNKNOWN_MAX || c->n_link > LW_UNKNOWN_MAX) {
        b->full = true;
        return;
    }
    for (int i = 0; i < LW_LINK_MAX; i++) {
        q.dir[i] = -1;
        at[i].n = 0;
    }
    set_loops(&q);
    set_gears(&q);
    q.g->n_unknown = q.g->n_turn + q.g->n_disp;
    lw_step *s = lw_build_step(b, LW_STEP_HIGHER);
    s->dim[0] = b->p->n_higher++;
    emit_links(&q);
}

/* ---- finish ------------------------------------------------------------------------------------------- */

static void renumber(short *d, const int *to)
{
    if (*d >= 0)
        *d = (short)to[*d];
}

void lw_build_higher_renumber(lw_higher *g, const int *to)
{
    for (int i = 0; i < g->n_vector; i++) {
        renumber(&g->vector[i].x, to);
        renumber(&g->vector[i].y, to);
    }
    for (int i = 0; i < g->n_dir; i++)
        renumber(&g->dir[i].dim, to);
    for (int i = 0; i < g->n_gear; i++) {
        renumber(&g->gear[i].phase, to);
        renumber(&g->gear[i].rho, to);
        renumber(&g->gear[i].shift, to);
        renumber(&g->gear[i].middle, to);
    }
}

void lw_build_higher_angle(lw_higher *g, int dim, int number)
{
    for (int i = 0; i < g->n_dir; i++)
        if (g->dir[i].dim == dim)
            g->dir[i].angle = (short)number;
    for (int i = 0; i < g->n_gear; i++)
        if (g->gear[i].phase == dim)
            g->gear[i].angle = (short)number;
}

bool lw_build_higher_needs(const lw_higher *g, bool *need)
{
    bool any = false;
    for (int i = 0; i < g->n_turn; i++)
        any |= need[g->turn_reg[i]];
    for (int i = 0; i < g->n_disp; i++)
        any |= need[g->disp_reg[i]];
    if (!any)
        return false;
    for (int i = 0; i < g->n_point; i++)
        need[g->point[i].reg] = true;
    for (int i = 0; i < g->n_dir; i++)
        if (g->dir[i].reg >= 0 && (g->dir[i].root < 0 || g->dir[i].input))
            need[g->dir[i].reg] = true;
    if (g->disp_input)
        need[g->disp_reg[g->n_disp]] = true;
    return true;
}
