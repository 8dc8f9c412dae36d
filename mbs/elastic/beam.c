#include "mbs/elastic/beam.h"

#include <string.h>
#include "base/real.h"

void lw_beam_stiffness(const lw_section *s, const lw_material *m, double h, double out[3])
{
    double ei = m->e*s->iz, k = 12*s->zeta_y*ei/(m->g*s->area*h*h);
    out[0] = m->e*s->area/h;
    out[1] = 12*ei/(h*h*h*(1 + k));
    out[2] = ei/h;
}

/* ---- in the plane ---------------------------------------------------------------------------------- */

/* The vector between the nodes in the mid frame (along, across), and the directions of its axes. */
typedef struct frame { double along, across, c, s; } frame;

static frame frame_of(const lw_beam *b, const double x[6])
{
    double turn = b->direction + 0.5*(x[2] + x[5]), c = cos(turn), s = sin(turn), dx = x[3] - x[0], dy = x[4] - x[1];
    return (frame){ c*dx + s*dy, c*dy - s*dx, c, s };
}

static void strain(const lw_beam *b, const frame *f, const double x[6], double e[3])
{
    e[0] = f->along - b->length + 0.5*f->across*f->across/b->length;
    e[1] = f->across;
    e[2] = x[5] - x[2];
}

double lw_beam_energy(const lw_beam *b, const double x[6])
{
    frame f = frame_of(b, x);
    double e[3];
    strain(b, &f, x, e);
    return 0.5*(b->stiffness[0]*e[0]*e[0] + b->stiffness[1]*e[1]*e[1] + b->stiffness[2]*e[2]*e[2]);
}

/* Second derivatives of along (k = 0) and across. */
static void bend_of(const frame *f, int k, double h[6][6])
{
    double ux = k ? -f->c : -f->s, uy = k ? -f->s : f->c;      /* derivative of the axis by the turn of the frame */
    double turn = k ? -0.25*f->across : -0.25*f->along;
    memset(h, 0, 36*sizeof h[0][0]);
    for (int end = 0; end < 2; end++)
        for (int node = 0; node < 2; node++) {
            double sign = end ? 0.5 : -0.5;
            h[3*end][3*node + 2] = h[3*node + 2][3*end] = sign*ux;
            h[3*end + 1][3*node + 2] = h[3*node + 2][3*end + 1] = sign*uy;
            h[3*end + 2][3*node + 2] = turn;
        }
}

/* Second derivatives of e[0] and e[1], g: derivative of e[1]; those of e[2] are 0. */
static void strain_bends(const lw_beam *b, const frame *f, const double g[6], double h[2][6][6])
{
    double by = 1/b->length, turned = f->across*by;
    bend_of(f, 0, h[0]);
    bend_of(f, 1, h[1]);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            h[0][i][j] += turned*h[1][i][j] + by*g[i]*g[j];
}

void lw_beam_at(const lw_beam *b, const double x[6], const double v[6], bool derivatives, const double *pull, lw_beam_state *out)
{
    frame f = frame_of(b, x);
    double inner[3], g[3][6] = {
        { -f.c, -f.s, 0.5*f.across, f.c, f.s, 0.5*f.across },
        { f.s, -f.c, -0.5*f.along, -f.s, f.c, -0.5*f.along },
        { 0, 0, -1, 0, 0, 1 }
    };
    for (int i = 0; i < 6; i++)
        g[0][i] += f.across/b->length*g[1][i];
    strain(b, &f, x, out->e);
    for (int k = 0; k < 3; k++) {
        out->rate[k] = 0;
        for (int i = 0; i < 6; i++)
            out->rate[k] += g[k][i]*v[i];
        inner[k] = b->stiffness[k]*(out->e[k] + b->damping*out->rate[k]);
    }
    for (int i = 0; i < 6; i++)
        out->force[i] = -(inner[0]*g[0][i] + inner[1]*g[1][i] + inner[2]*g[2][i]);
    if (!derivatives)
        return;
    if (pull)
        inner[0] = *pull;
    memset(out->by_x, 0, sizeof out->by_x);
    memset(out->by_v, 0, sizeof out->by_v);
    double h[2][6][6];
    strain_bends(b, &f, g[1], h);
    for (int k = 0; k < 3; k++) {
        double hv[6] = { 0 };
        for (int i = 0; k < 2 && b->damping > 0 && i < 6; i++)
            for (int j = 0; j < 6; j++)
                hv[i] += h[k][i][j]*v[j];
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 6; j++) {
                out->by_x[i][j] -= b->stiffness[k]*g[k][i]*(g[k][j] + b->damping*hv[j]) + (k < 2 ? inner[k]*h[k][i][j] : 0);
                out->by_v[i][j] -= b->stiffness[k]*b->damping*g[k][i]*g[k][j];
            }
    }
}

/* ---- consistent mass --------------------------------------------------------------------------------- */

/* Deflection and rotation of the section at s in 0 .. 1, by the four end values (w, turn) of both nodes. */
static void shape_at(double s, double h, double k, double w[4], double turn[4])
{
    double f = 1/(1 + k), s2 = s*s, s3 = s2*s;
    w[0] = f*(2*s3 - 3*s2 - k*s + 1 + k);
    w[1] = h*f*(s3 - (2 + k/2)*s2 + (1 + k/2)*s);
    w[2] = f*(3*s2 - 2*s3 + k*s);
    w[3] = h*f*(s3 - (1 - k/2)*s2 - k/2*s);
    turn[0] = 6*f/h*(s2 - s);
    turn[1] = f*(3*s2 - (4 + k)*s + 1 + k);
    turn[2] = -turn[0];
    turn[3] = f*(3*s2 - (2 - k)*s);
}

void lw_beam_mass(double m, double h, double k, double r2, double direction, double out[6][6])
{
    /* Gauss's rule of four points: exact to degree 7, the products have 6 */
    static const double at[4] = { -0.861136311594052575, -0.339981043584856265, 0.339981043584856265, 0.861136311594052575 };
    static const double weight[4] = { 0.347854845137453857, 0.652145154862546143, 0.652145154862546143, 0.347854845137453857 };
    static const int place[4] = { 1, 2, 4, 5 };
    double own[6][6] = { { 0 } }, c = cos(direction), s = sin(direction);
    own[0][0] = own[3][3] = m/3;
    own[0][3] = own[3][0] = m/6;
    for (int p = 0; p < 4; p++) {
        double w[4], turn[4];
        shape_at(0.5*(1 + at[p]), h, k, w, turn);
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++)
                own[place[i]][place[j]] += 0.5*weight[p]*m*(w[i]*w[j] + r2*turn[i]*turn[j]);
    }
    const double t[3][3] = { { c, s, 0 }, { -s, c, 0 }, { 0, 0, 1 } };
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) {
            out[i][j] = 0;
            for (int a = 0; a < 3; a++)
                for (int d = 0; d < 3; d++)
                    out[i][j] += t[a][i%3]*own[3*(i/3) + a][3*(j/3) + d]*t[d][j%3];
        }
}
