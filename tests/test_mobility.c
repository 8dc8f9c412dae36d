/* Mobility of linkages whose answer is known: counts, special geometry, singular postures, shaky ones. */
#include "mbs/constraints/mobility.h"
#include "tests/check.h"
#include "tests/mbs_random.h"

/* ---- frameworks: points joined by bars ----------------------------------------------------------- */

typedef struct frame { int n_point, n_bar; lw_vec2 at[16]; int bar[32][2]; } frame;

static void bar(frame *f, int i, int k)
{
    f->bar[f->n_bar][0] = i;
    f->bar[f->n_bar++][1] = k;
}

/* Every bar a link, the first the ground; at every point the bars are pinned to the first of them. */
static void framework(const frame *f, lw_linkage *k)
{
    blank_linkage(k, f->n_bar);
    for (int p = 0; p < f->n_point; p++) {
        int first = -1;
        for (int b = 0; b < f->n_bar; b++)
            if (f->bar[b][0] == p || f->bar[b][1] == p) {
                if (first >= 0)
                    add_pin(k, first, b, f->at[p]);
                else
                    first = b;
            }
    }
}

static lw_mobility find(const lw_linkage *k)
{
    static lw_mobility m;
    lw_mobility_options o = lw_mobility_options_default();
    lw_error e = { 0 };
    lw_status s = lw_mobility_find(k, &o, &m, &e);
    if (s != LW_OK)
        fprintf(stderr, "    %s\n", e.text);
    CHECK_INT(s, LW_OK);
    return m;
}

/* What everybody agrees upon: n_q = rank + along, rows = rank + redundant, and the rest. */
static void agrees(const lw_mobility *m)
{
    CHECK_INT(m->rank + m->along, m->n_q);
    CHECK_INT(m->rank + m->n_redundant, m->n_row);
    CHECK_INT(m->posture_rank + m->instant, m->n_q);
    CHECK_INT(m->count, m->n_q - m->n_row);
    CHECK(m->along >= m->freedom && m->instant >= m->freedom);
    CHECK(m->kind != LW_MOBILITY_MOVES || (m->residual <= 1e-12*m->unit && m->distance > 0.05));
    CHECK_INT(m->kind == LW_MOBILITY_MOVES, m->freedom > 0);
    CHECK_INT(m->kind == LW_MOBILITY_RIGID, m->instant == 0);
}

static void expect_generic(const lw_linkage *k, int generic) { CHECK_INT(find(k).generic, generic); }

static void expect(const lw_linkage *k, lw_mobility_kind kind, int count, int freedom, int instant, int redundant)
{
    lw_mobility m = find(k);
    agrees(&m);
    CHECK_TEXT(lw_mobility_kind_text(m.kind), lw_mobility_kind_text(kind));
    CHECK_INT(m.count, count);
    CHECK_INT(m.freedom, freedom);
    CHECK_INT(m.instant, instant);
    CHECK_INT(m.n_redundant, redundant);
}

/* ---- moved by special geometry --------------------------------------------------------------------- */

static void parallelogram(lw_linkage *k, double third, double angle)
{
    lw_vec2 up = lw_v2_polar(2, angle);
    blank_linkage(k, 5);
    for (int i = 0; i < 3; i++) {
        lw_vec2 foot = lw_v2(i == 2 ? 1.3 : 3.0*i, i == 2 ? 0.4 : 0);
        lw_vec2 reach = lw_v2_scale(up, i == 2 ? third : 1);
        add_pin(k, 0, 1 + i, foot);
        add_pin(k, 1 + i, 4, lw_v2_add(foot, reach));
    }
    add_input(k, 0, angle);
    add_tracer(k, 4, lw_v2(1, 5));
}

TEST(parallelogram_with_a_third_bar)
{
    lw_linkage k;
    parallelogram(&k, 1, 1.1);
    expect(&k, LW_MOBILITY_MOVES, 0, 1, 1, 1);
    expect_generic(&k, 0);
    parallelogram(&k, 1.001, 1.1);                         /* three parallel bars, one longer: shaky */
    expect(&k, LW_MOBILITY_SHAKY, 0, 0, 1, 1);
    parallelogram(&k, 1, 1.1);
    k.joint[5].at.x += 1e-3;
    expect(&k, LW_MOBILITY_RIGID, 0, 0, 0, 0);
    parallelogram(&k, 1, 0.0);
    lw_mobility m = find(&k);                              /* folded: two motions of first order at least */
    agrees(&m);
    CHECK_INT(m.freedom, 1);
}

/* Tables on n legs, stacked: every storey moves although all its legs but two are redundant, each in its own way */
TEST(stacked_tables)
{
    for (int n = 2; n <= 6; n++)
        for (int storeys = 1; storeys <= (n < 4 ? 5 : 2); storeys++) {
            lw_linkage k;
            lw_vec2 foot[6], up;
            blank_linkage(&k, 1 + storeys*(n + 1));
            for (int i = 0; i < n; i++)
                foot[i] = lw_v2(0.7*i + 0.1*i*i, 0.3*sin(i));
            for (int s = 0, plate = 0; s < storeys; s++) {
                int next = 1 + s*(n + 1);                       /* then its legs */
                up = lw_v2_polar(1, 0.9 + 0.3*s);
                for (int i = 0; i < n; i++) {
                    add_pin(&k, plate, next + 1 + i, foot[i]);
                    foot[i] = lw_v2_add(foot[i], up);
                    add_pin(&k, next + 1 + i, next, foot[i]);
                }
                plate = next;
            }
            expect(&k, LW_MOBILITY_MOVES, storeys*(3 - n), storeys, storeys, storeys*(n - 2));
            expect_generic(&k, n == 2 ? storeys : 0);
        }
}

/* Two triangles joined by three bars (Desargues): rigid; shaky when the bars meet in a point, or are parallel and not
 * of one length; movable when they are equal and parallel */
TEST(triangles_and_three_bars)
{
    static const lw_vec2 t[3] = { { 0, 0 }, { 2, 0 }, { 0.7, 1.6 } };
    static const double share[3] = { 0.5, 0.3, 0.62 }, length[3] = { 1, 1.4, 0.7 };
    for (int i = 0; i < 4; i++) {
        lw_linkage k;
        blank_linkage(&k, 5);
        for (int j = 0; j < 3; j++) {
            lw_vec2 o = { 5, -1 }, d = { 1, 2 };
            lw_vec2 far = i == 1 ? lw_v2_add(o, lw_v2_scale(lw_v2_sub(t[j], o), share[j]))
                        : lw_v2_add(t[j], lw_v2_scale(d, i == 2 ? length[j] : 1));
            if (i == 0)
                far = lw_v2_add(far, lw_v2(0.3*j*j, -0.2*j));
            add_pin(&k, 0, 2 + j, t[j]);
            add_pin(&k, 2 + j, 1, far);
        }
        if (i == 3)
            expect(&k, LW_MOBILITY_MOVES, 0, 1, 1, 1);
        else
            expect(&k, i ? LW_MOBILITY_SHAKY : LW_MOBILITY_RIGID, 0, 0, i > 0, i > 0);
    }
}

static void fold(lw_linkage *k, double stretch)
{
    blank_linkage(k, 4);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, 0), PIN(2, 3, 4 + stretch, 0), PIN(3, 0, 3, 0)));
}

/* Parallelogram and antiparallelogram meet where it is folded: a singular posture, no special geometry. */
TEST(folded_four_bar)
{
    lw_linkage k;
    fold(&k, 0);
    lw_mobility m = find(&k);
    agrees(&m);
    CHECK_INT(m.instant, 2);
    CHECK_INT(m.freedom, 1);
    CHECK_INT(m.along, 1);
    CHECK_INT(m.posture_rank, m.rank - 1);
    CHECK_INT(m.n_redundant, 0);
    CHECK_INT(m.generic, 1);
    fold(&k, 0.5);                                         /* all in line by its lengths: cannot leave */
    k.joint[1].at = lw_v2(-1, 0);
    k.joint[2].at = lw_v2(5, 0);                           /* 3 + 2 + 1 = 6 is the coupler */
    expect(&k, LW_MOBILITY_SHAKY, 1, 0, 2, 1);
}

/* Dixon 1899, first kind: K(m, n) with one class on each of two lines at a right angle. */
TEST(dixon_first)
{
    frame f = { .n_point = 6, .at = { { 1, 0 }, { -1.7, 0 }, { 2.9, 0 }, { 0, 0.8 }, { 0, -2.1 }, { 0, 1.6 } } };
    lw_linkage k;
    for (int i = 0; i < 3; i++)
        for (int j = 3; j < 6; j++)
            bar(&f, i, j);
    framework(&f, &k);
    expect(&k, LW_MOBILITY_MOVES, 0, 1, 1, 1);
    f.at[5].x = 0.3;
    framework(&f, &k);
    expect(&k, LW_MOBILITY_RIGID, 0, 0, 0, 0);
}

/* Dixon's second kind: K(4, 4), two rectangles with one centre and parallel sides. */
TEST(dixon_second)
{
    frame f = { .n_point = 8 };
    lw_linkage k;
    for (int i = 0; i < 4; i++) {
        f.at[i] = lw_v2(i & 1 ? 1.2 : -1.2, i & 2 ? 0.7 : -0.7);
        f.at[4 + i] = lw_v2(i & 1 ? 0.5 : -0.5, i & 2 ? 1.9 : -1.9);
    }
    for (int i = 0; i < 4; i++)
        for (int j = 4; j < 8; j++)
            bar(&f, i, j);
    framework(&f, &k);
    lw_mobility m = find(&k);
    agrees(&m);
    CHECK_INT(m.count, -3);
    CHECK_INT(m.freedom, 1);
    CHECK_INT(m.generic, 0);
}

/* Bolker & Roth 1980: K(3, 3) is shaky when its six points lie on a conic, here a circle. */
TEST(six_points_on_a_conic)
{
    frame f = { .n_point = 6 };
    static const double angle[] = { 0.1, 1.0, 2.3, 3.1, 4.4, 5.5 };
    lw_linkage k;
    for (int i = 0; i < 6; i++)
        f.at[i] = lw_v2_polar(1, angle[i]);
    for (int i = 0; i < 6; i += 2)
        for (int j = 1; j < 6; j += 2)
            bar(&f, i, j);
    framework(&f, &k);
    expect(&k, LW_MOBILITY_SHAKY, 0, 0, 1, 1);
    lw_mobility m = find(&k);
    CHECK_INT(m.order, 1);
    f.at[2] = lw_v2_scale(f.at[2], 1.1);
    framework(&f, &k);
    expect(&k, LW_MOBILITY_RIGID, 0, 0, 0, 0);
}

/* The three four-bars of one coupler curve, on one ground, their coupler points pinned together
 * (Roberts 1875): ten links, count -1. */
TEST(roberts_and_cayley)
{
    lw_vec2 a0 = { 0, 0 }, b0 = { 4, 0 }, a = lw_v2_polar(1.5, 1.2), b = meet(a, 3.1, b0, 2.4, 1), c = { 0.6, 0.5 };
    lw_vec2 p = lw_v2_add(a, lw_v2_turn(lw_v2_sub(b, a), c)), c0 = lw_v2_turn(b0, c);
    lw_vec2 d = lw_v2_sub(p, a), e = lw_v2_add(b0, lw_v2_sub(p, b));         /* of the parallelograms */
    lw_vec2 g = lw_v2_add(d, lw_v2_turn(lw_v2_sub(p, d), c)), h;
    /* coupler triangles d p g and p e h are like a b p */
    h = lw_v2_add(p, lw_v2_turn(lw_v2_sub(e, p), c));
    lw_linkage k;
    blank_linkage(&k, 10);
    add_pin(&k, 0, 1, a0); add_pin(&k, 1, 2, a); add_pin(&k, 2, 3, b); add_pin(&k, 3, 0, b0);
    add_pin(&k, 0, 4, a0); add_pin(&k, 4, 5, d); add_pin(&k, 5, 6, g); add_pin(&k, 6, 0, c0);
    add_pin(&k, 0, 7, b0); add_pin(&k, 7, 8, e); add_pin(&k, 8, 9, h); add_pin(&k, 9, 0, c0);
    add_pin(&k, 2, 5, p); add_pin(&k, 2, 8, p);
    expect(&k, LW_MOBILITY_MOVES, -1, 1, 1, 2);
    expect_generic(&k, 0);
    k.joint[6].at.x += 0.01;
    lw_mobility m = find(&k);
    CHECK(m.kind != LW_MOBILITY_MOVES);
}

/* Three sliders in a ring: no link can turn, and that is said once too often. */
TEST(wedges)
{
    lw_linkage k;
    blank_linkage(&k, 3);
    add_joints(&k, JOINTS(SLIDE(0, 1, 0, 0, 0.2), SLIDE(1, 2, 1, 1, 1.3), SLIDE(2, 0, 2, 0, 2.2)));
    expect(&k, LW_MOBILITY_MOVES, 0, 1, 1, 1);
    expect_generic(&k, 1);                                 /* whatever their directions */
    lw_mobility m = find(&k);
    CHECK_TEXT(m.redundant[0].row.what, "turn");
    CHECK_INT(m.redundant[0].row.joint, 2);
    CHECK_INT(m.redundant[0].joints, 3);
}

/* Burmester's focal linkage (Kempe 1878, Burmester 1893): a four-bar A B C D whose sides are joined to one
 * point F by bars to P, Q, R, S.  The quadrilaterals at A and C are similar, and those at B and D:
 *     AP/FR = PF/RC = FS/CQ = SA/QF = k1,    BQ/FS = QF/SD = FP/DR = PB/RF = k2,
 * and the cosines at P and S are tied by one equation from A and one from B, made the same by k2. */
TEST(focal_linkage)
{
    double p = 1, q = 1.3, r = 1.2, s = 0.9, x = 1.2, c = (r*r - q*q) + p*p - s*s;
    double k2 = (-c + sqrt(c*c - 4*(r*r - s*s)*(p*p - q*q)))/(2*(r*r - s*s));      /* k1 = 1 */
    lw_vec2 f = { 0, 0 }, vp = { p, 0 }, to_a = lw_v2_polar(1, LW_PI - x);
    lw_vec2 va = lw_v2_add(vp, lw_v2_scale(to_a, r)), vb = lw_v2_sub(vp, lw_v2_scale(to_a, k2*r));
    int n_closed = 0;
    for (int branch = 0; branch < 4; branch++) {
        lw_vec2 vs = meet(f, s, va, q, branch & 1 ? 1 : -1), vq = meet(f, q, vb, k2*s, branch & 2 ? 1 : -1);
        lw_vec2 vd = lw_v2_add(vs, lw_v2_scale(lw_v2_sub(vs, va), 1/k2));
        lw_vec2 vc = lw_v2_add(vq, lw_v2_scale(lw_v2_sub(vq, vb), 1/k2));
        lw_vec2 vr = lw_v2_add(vc, lw_v2_scale(lw_v2_sub(vd, vc), k2/(1 + k2)));
        if (fabs(lw_v2_norm(vr) - r) > 1e-12 || fabs(lw_v2_norm(lw_v2_sub(vd, vc)) - (1 + 1/k2)*p) > 1e-12)
            continue;
        lw_linkage k;
        blank_linkage(&k, 8);
        lw_vec2 corner[4] = { vb, vc, vd, va }, side[4] = { vp, vq, vr, vs };
        for (int i = 0; i < 4; i++)
            add_pin(&k, i, (i + 1)%4, corner[i]);          /* links 0 .. 3: AB, BC, CD, DA */
        for (int i = 0; i < 4; i++)
            add_pin(&k, i, 4 + i, side[i]);
        for (int i = 1; i < 4; i++)
            add_pin(&k, 4, 4 + i, f);
        expect(&k, LW_MOBILITY_MOVES, -1, 1, 1, 2);
        k.joint[6].at.x += 0.02;
        lw_mobility m = find(&k);
        CHECK(m.kind != LW_MOBILITY_MOVES);
        n_closed++;
    }
    CHECK_INT(n_closed, 2);                                /* the equation leaves a sign open */
}

/* Connelly & Servatius 1994: two mirrored Watt linkages whose tracers are joined by a bar meet in a cusp.
 * It is rigid by every test of higher order there, and yet it moves. */
TEST(cusp)
{
    lw_linkage k;
    blank_linkage(&k, 8);
    for (int side = 0; side < 2; side++) {
        double at = side ? 5 : 0, way = side ? -1 : 1;
        int first = 1 + 3*side;
        add_joints(&k, JOINTS(PIN(0, first, at + way*(0.4 - 2), 1), PIN(first, first + 1, at + way*0.4, 1),
                              PIN(first + 1, first + 2, at - way*0.4, -1), PIN(first + 2, 0, at + way*(2 - 0.4), -1)));
    }
    add_pin(&k, 2, 7, lw_v2(0, 0));
    add_pin(&k, 5, 7, lw_v2(5, 0));
    lw_mobility m = find(&k);
    agrees(&m);
    CHECK_INT(m.count, 1);
    CHECK_INT(m.instant, 2);
    CHECK_INT(m.freedom, 1);
    CHECK_INT(m.along, 1);
    CHECK_INT(m.n_redundant, 0);
}

/* ---- shaky ----------------------------------------------------------------------------------------- */

static void two_bars_in_line(lw_linkage *k, double height)
{
    blank_linkage(k, 3);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, height), PIN(2, 0, 2.5, 0)));
}

TEST(bars_in_line)
{
    lw_linkage k;
    two_bars_in_line(&k, 0);
    expect(&k, LW_MOBILITY_SHAKY, 0, 0, 1, 1);
    lw_mobility m = find(&k);
    CHECK_INT(m.order, 1);
    CHECK(m.misfit > 1e-5 && m.misfit < 0.01);
    two_bars_in_line(&k, 0.01);
    expect(&k, LW_MOBILITY_RIGID, 0, 0, 0, 0);
    m = find(&k);
    CHECK(m.misfit > 1e-5 && m.misfit < 0.01);
    two_bars_in_line(&k, 1);
    expect(&k, LW_MOBILITY_RIGID, 0, 0, 0, 0);
}

/* A bar from the coupler point to the centre of curvature of its path follows to second order; the
 * centre by Euler and Savary, from differences of the path. */
TEST(bar_to_the_centre_of_curvature)
{
    const double dim[9] = { 4, 1.5, 3.1, 2.4, 1.2, 0.9, 0, 0, 0 };
    double h = 1e-3;
    lw_vec2 p[5];
    for (int i = 0; i < 5; i++)
        p[i] = fourbar_at(dim, 1, 1.2 + (i - 2)*h).p;
    lw_vec2 v = lw_v2_scale(lw_v2_add(lw_v2_sub(p[0], p[4]), lw_v2_scale(lw_v2_sub(p[3], p[1]), 8)), 1/(12*h));
    lw_vec2 a = lw_v2_scale(lw_v2_add(lw_v2_scale(lw_v2_add(p[1], p[3]), 16),
                            lw_v2_sub(lw_v2_scale(p[2], -30), lw_v2_add(p[0], p[4]))), 1/(12*h*h));
    double curve = (v.x*a.y - v.y*a.x)/pow(lw_v2_norm(v), 3);
    lw_vec2 centre = lw_v2_add(p[2], lw_v2_scale(lw_v2_perp(v), 1/(curve*lw_v2_norm(v))));
    lw_linkage k;
    fourbar_linkage(&k, dim, 1, 1.2);
    k.n_link = 5;
    strcpy(k.link_name[4], "L5");
    add_pin(&k, 2, 4, p[2]);
    add_pin(&k, 4, 0, centre);
    expect(&k, LW_MOBILITY_SHAKY, 0, 0, 1, 1);
    CHECK_INT(find(&k).order, 2);
    k.joint[5].at = lw_v2_add(p[2], lw_v2_scale(lw_v2_sub(centre, p[2]), 0.7));
    CHECK_INT(find(&k).order, 1);
}

/* A four-bar that carries two bars in line: it moves, and shakes everywhere on its way. */
TEST(shaky_everywhere)
{
    const double dim[9] = { 4, 1.5, 3.1, 2.4, 1.2, 0.9, 0, 0, 0 };
    lw_linkage k;
    fourbar_linkage(&k, dim, 1, 1.2);
    lw_vec2 a = k.joint[0].at, b = k.joint[1].at;          /* on the crank */
    k.n_link = 6;
    strcpy(k.link_name[4], "L5");
    strcpy(k.link_name[5], "L6");
    add_pin(&k, 1, 4, a);
    add_pin(&k, 4, 5, lw_v2_scale(lw_v2_add(a, b), 0.5));
    add_pin(&k, 5, 1, b);
    lw_mobility m = find(&k);
    agrees(&m);
    CHECK_INT(m.freedom, 1);
    CHECK_INT(m.along, 2);
    CHECK_INT(m.count, 1);
    CHECK_INT(m.n_redundant, 1);
    CHECK_INT(m.idle, 0);                                  /* the shaking is no freedom */
}

/* ---- freedoms and what they reach -------------------------------------------------------------------- */

TEST(rollers_spin)
{
    lw_linkage k;
    blank_linkage(&k, 5);
    add_pin(&k, 0, 1, lw_v2(0, 0));
    int pin = add_pin(&k, 1, 2, lw_v2(0, 1));              /* roller 2 in the slot of 3, a slider */
    add_joint(&k, LW_JOINT_SLOT, 3, 2, k.joint[pin].at, LW_PI/2);
    add_slide(&k, 0, 3, lw_v2(2, 0), 0);
    add_pin(&k, 3, 4, lw_v2(2, 0));                        /* and a wheel on the slider */
    add_input(&k, 0, 1.57);
    lw_mobility m = find(&k);
    agrees(&m);
    CHECK_INT(m.freedom, 3);
    CHECK_INT(m.driven, 1);
    CHECK_INT(m.idle, 2);
    CHECK_INT(m.idle_links, 1 << 2 | 1 << 4);
    CHECK_INT(m.loose_links, 0);
    add_tracer(&k, 3, lw_v2(3, 3));
    m = find(&k);
    CHECK_INT(m.idle, 2);
    CHECK_INT(m.idle_links, 1 << 2 | 1 << 4);
    add_tracer(&k, 4, lw_v2(2, 0.5));                      /* now the wheel is looked at */
    m = find(&k);
    CHECK_INT(m.idle, 1);
    CHECK_INT(m.idle_links, 1 << 2);
    CHECK_INT(m.loose_links, 1 << 4);
    k.tracer[1].at = k.joint[4].at;                        /* but not its middle */
    m = find(&k);
    CHECK_INT(m.idle, 2);
}

TEST(arm_without_inputs)
{
    lw_linkage k;
    blank_linkage(&k, 4);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, 0), PIN(2, 3, 1, 1)));
    add_tracer(&k, 3, lw_v2(2, 1));
    lw_mobility m = find(&k);
    agrees(&m);
    CHECK_INT(m.freedom, 3);
    CHECK_INT(m.driven, 0);
    CHECK_INT(m.idle, 1);                                  /* the tracer can stand still while links move */
    CHECK_INT(m.still_links, 0);
    CHECK_INT(m.least_freedom, 3);
}

/* A rigid triangle hangs on a four-bar: its inner joints stand still, its links do not. */
TEST(what_stands_still)
{
    const double dim[9] = { 4, 1.5, 3.1, 2.4, 1.2, 0.9, 0, 0, 0 };
    lw_linkage k;
    fourbar_linkage(&k, dim, 1, 1.2);
    k.n_link = 8;
    for (int i = 4; i < 8; i++)
        snprintf(k.link_name[i], LW_NAME_SIZE, "L%d", i + 1);
    add_pin(&k, 2, 4, k.joint[1].at);
    add_pin(&k, 4, 5, lw_v2(3, 5));
    add_pin(&k, 5, 2, k.joint[2].at);
    add_joints(&k, JOINTS(PIN(0, 6, 0, -1), PIN(6, 7, 1, -2), PIN(7, 0, 2, -1)));
    lw_mobility m = find(&k);
    agrees(&m);
    CHECK_INT(m.freedom, 1);
    CHECK_INT(m.still_links, 1 << 6 | 1 << 7);
    CHECK_INT(m.still_joints, 0x3f0);
    CHECK_INT(m.generic, 1);
}

TEST(gears_and_welds)
{
    lw_linkage k;
    blank_linkage(&k, 4);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(0, 2, 3, 0), GEAR(1, 2, 1, 0, -0.5)));
    add_joint(&k, LW_JOINT_FIXED, 2, 3, lw_v2(3, 1), 0);
    k.joint[3].along = lw_v2(0, 0);
    expect(&k, LW_MOBILITY_MOVES, 1, 1, 1, 0);
    add_gear(&k, 2, 1, lw_v2(1, 0), -2);                   /* the same once more */
    expect(&k, LW_MOBILITY_MOVES, 0, 1, 1, 1);
    k.joint[4].ratio = -3;
    expect(&k, LW_MOBILITY_RIGID, 0, 0, 0, 0);
}

TEST(dyads_on_dyads)
{
    lw_rng r = check_rng(0);
    for (int trial = 0; trial < 25; trial++) {
        lw_linkage k;
        random_grown(&r, 1 + trial%4, &k);
        lw_mobility m = find(&k);
        agrees(&m);
        CHECK_INT(m.count, 1);
        CHECK_INT(m.freedom, 1);
        CHECK_INT(m.driven, 1);
        CHECK_INT(m.idle, 0);
    }
}

/* The freedom of a chain of pins at places by chance: edges of a graph with three freedoms a link and two
 * rows a pin, taken in as long as they are independent.  Tay 1984, by brute force over sets of links: a set
 * of rows is independent when every set of links has at most 3 (links - 1) of them. */
static int generic_freedom(const lw_linkage *k)
{
    int n = k->n_link, taken[LW_JOINT_MAX] = { 0 }, sum = 0;
    for (int j = 0; j < k->n_joint; j++)
        for (int copy = 0; copy < 2; copy++) {
            bool fits = true;
            taken[j]++;
            for (unsigned set = 1; fits && set < 1u << n; set++) {
                int rows = 0;
                for (int i = 0; i <= j; i++)
                    if (set >> k->joint[i].link[0] & 1 && set >> k->joint[i].link[1] & 1)
                        rows += taken[i];
                fits = rows <= 3*(__builtin_popcount(set) - 1);
            }
            if (fits)
                sum++;
            else
                taken[j]--;
        }
    return 3*(n - 1) - sum;
}

TEST(random_chains)
{
    lw_rng r = check_rng(1);
    int rigid = 0, moved = 0, over = 0;
    for (int trial = 0; trial < 60; trial++) {
        lw_linkage k;
        int n = 3 + (int)(lw_rng_bits(&r)%6), extra = (int)(lw_rng_bits(&r)%(uint64_t)(n/2 + 2));
        blank_linkage(&k, n);
        for (int i = 1; i < n; i++)
            add_pin(&k, (int)(lw_rng_bits(&r)%(uint64_t)i), i, random_place(&r));
        for (int i = 0; i < extra; i++) {
            int a = (int)(lw_rng_bits(&r)%(uint64_t)n), b = (a + 1 + (int)(lw_rng_bits(&r)%(uint64_t)(n - 1)))%n;
            add_pin(&k, a, b, random_place(&r));
        }
        lw_mobility m = find(&k);
        agrees(&m);
        CHECK_INT(m.generic, m.freedom);
        CHECK_INT(m.freedom, generic_freedom(&k));         /* places by chance: no motion is of first order only */
        rigid += m.freedom == 0;
        moved += m.freedom > 0;
        over += m.n_redundant > 0;
    }
    CHECK(rigid > 0 && moved > 10 && over > 0);
}

/* Coordinates of six digits: closed to 1e-5 Dixon's linkage moves, closed to 1e-12 it does not. */
TEST(rounded_coordinates)
{
    frame f = { .n_point = 6, .at = { { 1, 0 }, { -1.7, 0 }, { 2.9, 0 }, { 0, 0.8 }, { 0, -2.1 }, { 0, 1.6 } } };
    lw_linkage k;
    lw_mobility m;
    lw_mobility_options o = lw_mobility_options_default();
    for (int i = 0; i < 9; i++)
        bar(&f, i/3, 3 + i%3);
    for (int i = 0; i < 6; i++) {
        lw_vec2 turned = lw_v2_turn(f.at[i], lw_v2_polar(1, 0.3));
        f.at[i] = lw_v2(round(1e6*turned.x)/1e6, round(1e6*turned.y)/1e6);
    }
    framework(&f, &k);
    m = find(&k);
    CHECK(m.kind != LW_MOBILITY_MOVES);
    CHECK(m.misfit > 1e-10 && m.misfit < 1e-6);
    o.tolerance = 1e-5;
    CHECK_INT(lw_mobility_find(&k, &o, &m, NULL), LW_OK);
    CHECK_INT(m.freedom, 1);
    CHECK_INT(m.n_redundant, 1);
    CHECK(m.residual < 1e-5*m.unit && m.residual > 1e-12);
}

TEST(refused)
{
    lw_linkage k;
    lw_mobility m;
    lw_mobility_options o = lw_mobility_options_default();
    blank_linkage(&k, 2);
    CHECK_INT(lw_mobility_find(&k, &o, &m, &check_error), LW_E_ARG);
    add_pin(&k, 0, 1, lw_v2(0, 0));
    o.tolerance = 1e-3;
    CHECK_FAILS(lw_mobility_find(&k, &o, &m, &check_error), LW_E_ARG, "tolerance");
}
