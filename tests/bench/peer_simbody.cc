/* peer_simbody.cc - scenes of `linkwright bench mbs` in Simbody 3.7 (peer.h says what comes in and goes out): pins as a
 * tree of mobilizers, the others as points held on lines across the plane, two equations each. */
#include <Simbody.h>
#include <cmath>
#include <csignal>
#include <memory>
#include <unistd.h>
#include <string>
#include <vector>
#include "tests/bench/peer.h"

using namespace SimTK;

/* A rotation whose column `k` is z. */
static Rotation along(const Vec3 &z, CoordinateAxis k) { return z.norm() > 0 ? Rotation(UnitVec3(z), k) : Rotation(); }

/* Frames of all bodies are parallel to the ground's in the posture, with their origins in the centres of mass. */
struct Model {
    const peer_scene &scene;
    MultibodySystem system;
    SimbodyMatterSubsystem matter{system};
    GeneralForceSubsystem forces{system};
    std::vector<MobilizedBody> body;       /* body[0]: ground                                */
    std::vector<int> parent;

    Vec3 at(int link, double x, double y) const
    {
        return link ? Vec3(x - scene.body[link - 1].x, y - scene.body[link - 1].y, 0) : Vec3(x, y, 0);
    }

    void hang(const peer_pin &p, int from, int to)
    {
        const peer_body &b = scene.body[to - 1];
        MassProperties mass(b.mass, Vec3(0), Inertia(0.5*b.inertia, 0.5*b.inertia, b.inertia));
        body[to] = MobilizedBody::Pin(body[from], Transform(at(from, p.x, p.y)), Body::Rigid(mass),
                                      Transform(at(to, p.x, p.y)));
        parent[to] = from;
    }

    /* ---- in space ---- */

    std::vector<int> tree;                 /* joint from the parent to a body of a model in space */
    std::vector<bool> turned;              /* its first link is the child */

    /* Turn, rate and acceleration of a drive at the moment that the time counts; before 0 on the way there. */
    struct Cycle : Motion::Custom::Implementation {
        const peer_scene &scene;
        int drive;
        Cycle(const peer_scene &s, int d) : scene(s), drive(d) {}
        Implementation *clone() const override { return new Cycle(*this); }
        Motion::Level getLevel(const State &) const override { return Motion::Position; }
        double value(const State &state, int derivative) const
        {
            double t = state.getTime(), part = t < 0 ? 1 + t : 1;
            return derivative && t < 0 ? 0 : part*scene.at3[t < 0 ? 0 : (int)std::lround(t)][drive][derivative];
        }
        void calcPrescribedPosition(const State &s, int, Real *q) const override { q[0] = value(s, 0); }
        void calcPrescribedPositionDot(const State &s, int, Real *v) const override { v[0] = value(s, 1); }
        void calcPrescribedPositionDotDot(const State &s, int, Real *a) const override { a[0] = value(s, 2); }
    };

    /* The other joint of a link between two balls, which does not spin here; -1: it is none. */
    int other_ball(int link, int j) const
    {
        int other = -1, n = 0;
        for (int i = 0; i < scene.n_joint3; i++)
            if (scene.joint3[i].a == link || scene.joint3[i].b == link)
                n += scene.joint3[i].kind == 'b' ? 1 : 9, other = i == j ? other : i;
        return n == 2 ? other : -1;
    }

    static Vec3 vec(const double *x) { return Vec3(x[0], x[1], x[2]); }
    Vec3 at(int link, const double *x) const { return link ? vec(x) - vec(scene.body3[link - 1].at) : vec(x); }

    void hang3(int j, int from, int to)
    {
        const peer_joint3 &p = scene.joint3[j];
        const peer_body3 &b = scene.body3[to - 1];
        const double *i = b.inertia;
        Body::Rigid mass(MassProperties(b.mass, Vec3(0), Inertia(i[0], i[1], i[2], i[3], i[4], i[5])));
        Rotation r = p.kind == 't' ? along(vec(p.axis), XAxis) : along(vec(p.axis), ZAxis);
        bool back = p.a == to;
        if (p.kind == 'u')
            r = Rotation(UnitVec3(vec(p.axis)), XAxis, vec(p.second), YAxis);
        Transform f(r, at(from, p.at)), m(r, at(to, p.at));
        int ball = p.kind == 'b' && scene.n_at3 ? other_ball(to, j) : -1;
        if (ball >= 0) {
            UnitVec3 z(vec(scene.joint3[ball].at) - vec(p.at)), x = z.perp();
            f = Transform(Rotation(x, XAxis, z % x, YAxis), f.p());
            m = Transform(f.R(), m.p());
        }
        auto way = back ? MobilizedBody::Reverse : MobilizedBody::Forward;
        body[to] = ball >= 0 ? MobilizedBody(MobilizedBody::Universal(body[from], f, mass, m, way))
                 : p.kind == 'r' ? MobilizedBody(MobilizedBody::Pin(body[from], f, mass, m, way))
                 : p.kind == 't' ? MobilizedBody(MobilizedBody::Slider(body[from], f, mass, m, way))
                 : p.kind == 'b' ? MobilizedBody(MobilizedBody::Ball(body[from], f, mass, m, way))
                 : p.kind == 'u' ? MobilizedBody(MobilizedBody::Universal(body[from], f, mass, m, way))
                 : p.kind == 'c' ? MobilizedBody(MobilizedBody::Cylinder(body[from], f, mass, m, way))
                                 : MobilizedBody(MobilizedBody::Weld(body[from], f, mass, m));
        parent[to] = from;
        tree[to] = j;
        turned[to] = back;
    }

    /* Joints are taken into the tree in this order; those left close loops. */
    void make3()
    {
        static const char *const order = "ftrcub";
        const peer_scene &s = scene;
        std::vector<bool> used(s.n_joint3, false);
        tree.resize(s.n_body3 + 1);
        turned.resize(s.n_body3 + 1);
        Force::UniformGravity(forces, matter, vec(s.gravity));
        for (bool more = true; more;) {
            more = false;
            for (const char *k = order; *k && !more; k++)
                for (int j = 0; j < s.n_joint3; j++) {
                    const peer_joint3 &p = s.joint3[j];
                    if (p.kind != *k || used[j] || (parent[p.a] < 0) == (parent[p.b] < 0))
                        continue;
                    hang3(j, parent[p.a] < 0 ? p.b : p.a, parent[p.a] < 0 ? p.a : p.b);
                    used[j] = more = true;
                }
        }
        for (int j = 0; j < s.n_joint3; j++) {
            const peer_joint3 &p = s.joint3[j];
            if (used[j])
                continue;
            Constraint::Ball(body[p.a], at(p.a, p.at), body[p.b], at(p.b, p.at));
            if (p.kind == 'b')
                continue;
            if (p.kind != 'r')
                throw std::runtime_error("a loop is closed by a joint that is neither ball nor hinge");
            UnitVec3 axis(vec(p.axis));
            UnitVec3 x = axis.perp(), y(axis % x);
            Constraint::ConstantAngle(body[p.a], x, body[p.b], axis);
            Constraint::ConstantAngle(body[p.a], y, body[p.b], axis);
        }
        for (int b = 1; b <= s.n_body3 && s.n_at3; b++)
            for (int d = 0; d < 3; d++)
                if (tree[b] == s.drive3[d])
                    Motion::Custom(body[b], new Cycle(s, d));
        for (int k = 0; k < s.n_spring3; k++) {
            const peer_spring3 &c = s.spring3[k];
            Force::TwoPointLinearSpring(forces, body[c.a], at(c.a, c.at[0]), body[c.b], at(c.b, c.at[1]), c.stiffness,
                                        c.free);
            if (c.damping > 0)
                Force::TwoPointLinearDamper(forces, body[c.a], at(c.a, c.at[0]), body[c.b], at(c.b, c.at[1]), c.damping);
        }
    }

    void start3(State &state)
    {
        for (int b = 1; b <= scene.n_body3; b++) {
            const peer_joint3 &p = scene.joint3[tree[b]];
            Vec3 v[2], w[2];
            for (int k = 0; k < 2; k++) {
                int link = k ? b : parent[b];
                const peer_body3 *own = link ? &scene.body3[link - 1] : nullptr;
                w[k] = own ? vec(own->omega) : Vec3(0);
                v[k] = own ? vec(own->v) + w[k] % at(link, p.at) : Vec3(0);
            }
            Rotation r = body[b].getDefaultInboardFrame().R();
            body[b].setUToFitVelocity(state, SpatialVec(~r*(w[1] - w[0]), ~r*(v[1] - v[0])));
        }
    }

    explicit Model(const peer_scene &s) : scene(s), body(s.n_body + s.n_body3 + 1), parent(s.n_body + s.n_body3 + 1, -1)
    {
        body[0] = matter.Ground();
        parent[0] = 0;
        if (s.space) {
            make3();
            return;
        }
        std::vector<bool> used(s.n_pin, false);
        Force::UniformGravity(forces, matter, Vec3(s.gx, s.gy, 0));
        for (bool more = true; more;) {
            more = false;
            for (int j = 0; j < s.n_pin; j++) {
                const peer_pin &p = s.pin[j];
                if (used[j] || (parent[p.a] < 0) == (parent[p.b] < 0))
                    continue;
                hang(p, parent[p.a] < 0 ? p.b : p.a, parent[p.a] < 0 ? p.a : p.b);
                used[j] = more = true;
            }
        }
        for (int j = 0; j < s.n_pin; j++) {
            const peer_pin &p = s.pin[j];
            if (!used[j])
                Constraint::PointOnLine(body[p.a], UnitVec3(0, 0, 1), at(p.a, p.x, p.y), body[p.b], at(p.b, p.x, p.y));
        }
        for (int k = 0; k < s.n_spring; k++) {
            const peer_spring &c = s.spring[k];
            Force::TwoPointLinearSpring(forces, body[c.a], at(c.a, c.ax, c.ay), body[c.b], at(c.b, c.bx, c.by),
                                        c.stiffness, c.free);
        }
        for (int k = 0; k < s.n_torque; k++)
            Force::ConstantTorque(forces, body[s.torque[k].body], Vec3(0, 0, s.torque[k].value));
    }

    State start()
    {
        State state = system.realizeTopology();
        system.realize(state, Stage::Position);
        for (int b = 1; b <= scene.n_body; b++)
            body[b].setOneU(state, 0, scene.body[b - 1].omega - (parent[b] ? scene.body[parent[b] - 1].omega : 0));
        if (scene.space)
            start3(state);
        system.realize(state, Stage::Velocity);
        return state;
    }

    /* Turns add up along the tree; angles of pins are not wrapped. */
    void print(const State &state) const
    {
        system.realize(state, Stage::Position);
        if (scene.space) {
            Vec3 x = body[scene.point_body].findStationLocationInGround(state, at(scene.point_body, scene.point));
            std::printf("%.17g %.17g %.17g\n", x[0], x[1], x[2]);
        }
        for (int b = 1; b <= scene.n_body; b++) {
            Vec3 x = body[b].getBodyOriginLocation(state);
            double turn = 0;
            for (int k = b; k; k = parent[k])
                turn += body[k].getOneQ(state, 0);
            std::printf("%.17g %.17g %.17g%c", x[0], x[1], turn, b == scene.n_body ? '\n' : ' ');
        }
    }
};

static const char *const method_name[] = { "Merson", "Feldberg", "CPodes", "inverse" };

static std::unique_ptr<Integrator> make(int method, double accuracy, const MultibodySystem &system)
{
    std::unique_ptr<Integrator> i;
    if (method == 0)
        i.reset(new RungeKuttaMersonIntegrator(system));
    else if (method == 1)
        i.reset(new RungeKuttaFeldbergIntegrator(system));
    else
        i.reset(new CPodesIntegrator(system));
    i->setAccuracy(accuracy);
    i->setProjectEveryStep(true);             /* else it is on another branch after a singular posture */
    if (method == 2)
        i->setConstraintTolerance(1e-3*accuracy);
    i->setInternalStepLimit(50000);
    return i;
}

static void to(TimeStepper &ts, double end)
{
    if (ts.stepTo(end) == Integrator::ReachedStepLimit)
        throw std::runtime_error("50000 steps do not lead to the end");
}

/* Seconds of the best run; rows go out. */
static double row(const peer_scene &s, int method, double accuracy)
{
    double begun = peer_clock();
    Model m(s);
    State first = m.start();
    double set_up = peer_clock() - begun, best = INFINITY, spent = 0;
    int steps = 0, evaluations = 0;
    for (int k = 0; k < PEER_REPEAT && (k == 0 || spent < s.repeat); k++) {
        auto integrator = make(method, accuracy, m.system);
        TimeStepper ts(m.system, *integrator);
        double t0 = peer_clock();
        ts.initialize(first);
        to(ts, s.end);
        double t = peer_clock() - t0;
        best = std::fmin(best, t);
        spent += t;
        steps = integrator->getNumStepsTaken();
        evaluations = integrator->getNumRealizations();
    }
    auto integrator = make(method, accuracy, m.system);
    TimeStepper ts(m.system, *integrator);
    ts.initialize(first);
    std::vector<State> moment;
    for (int k = 0; k < s.moments; k++) {
        to(ts, s.end*k/(s.moments - 1));
        moment.push_back(ts.getState());
    }
    std::printf("run %g %.9g %.9g %d %d %s\n", accuracy, set_up, best, steps, evaluations, method_name[method]);
    for (const State &state : moment)
        m.print(state);
    std::fflush(stdout);
    return best;
}

/* The torques of the drives along the cycle, by prescribed motions and projection of the others. */
static double inverse_row(const peer_scene &s, double accuracy)
{
    double begun = peer_clock();
    Model m(s);
    State first = m.system.realizeTopology();
    auto place = [&](State &state, double t) {
        state.setTime(t);
        m.system.realize(state, Stage::Time);
        m.system.prescribeQ(state);
        m.system.realize(state, Stage::Position);
        m.system.projectQ(state, accuracy);
    };
    for (int k = -40; k < 0; k++)
        place(first, k/40.0);
    double set_up = peer_clock() - begun, best = INFINITY, spent = 0;
    std::vector<Vec3> torque(s.n_at3);
    for (int repeat = 0; repeat < PEER_REPEAT && (repeat == 0 || spent < s.repeat); repeat++) {
        State state = first;
        double t0 = peer_clock();
        for (int k = 0; k < s.n_at3; k++) {
            Vector force;
            place(state, k);
            m.system.prescribeU(state);
            m.system.realize(state, Stage::Velocity);
            m.system.projectU(state, accuracy);
            m.system.realize(state, Stage::Acceleration);
            m.matter.findMotionForces(state, force);
            for (int b = 1; b <= s.n_body3; b++)
                for (int d = 0; d < 3; d++)
                    if (m.tree[b] == s.drive3[d])
                        torque[k][d] = -force[m.body[b].getFirstUIndex(state)];
        }
        double t = peer_clock() - t0;
        best = std::fmin(best, t);
        spent += t;
    }
    std::printf("run %g %.9g %.9g %d %d inverse\n", accuracy, set_up, best, s.n_at3, s.n_at3);
    for (const Vec3 &t : torque)
        std::printf("%.17g %.17g %.17g\n", t[0], t[1], t[2]);
    std::fflush(stdout);
    return best;
}

struct one_row { const peer_scene *scene; int method; double accuracy; };

/* CPodes may creep for ever within one step: each row is a process of its own. */
static double row_apart(void *context)
{
    const one_row &r = *static_cast<one_row *>(context);
    try {
        return r.method < 3 ? row(*r.scene, r.method, r.accuracy) : inverse_row(*r.scene, r.accuracy);
    } catch (const std::exception &e) {
        std::string why = e.what();
        for (char &c : why)
            c = c == '\n' ? ' ' : c;
        std::printf("fail %g %s: %.140s\n", r.accuracy, method_name[r.method], why.c_str());
    }
    return 0;
}

int main()
{
    const peer_scene *s = peer_read();
    for (int method = s->n_at3 ? 3 : 0; method < (s->n_at3 ? 4 : 3); method++)
        for (int k = 1, slow = 0; k <= 12 && slow < 2; k++) {
            one_row r = { s, method, std::pow(10., -k) };
            bool late = peer_apart(s, row_apart, &r, r.accuracy, method_name[method]);
            slow += late && k > 2;           /* CPodes fails at loose accuracies of loops, and goes on at tighter ones */
        }
    return 0;
}
