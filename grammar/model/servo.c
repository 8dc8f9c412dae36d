#include "grammar/model/servo.h"

#include <string.h>
#include "base/real.h"
#include "base/vec2.h"
#include "grammar/linkage/read_internal.h"
#include "grammar/model/model_internal.h"

/* An object that may be left out: *out is false then. */
static lw_status part(const lw_json_node *of, const char *key, const char *const *known, int n, bool need, lw_json_node *out,
                      bool *given, lw_error *e)
{
    *given = lw_json_member(of, key, out);
    if (!*given)
        return need ? lw_read_need(of, key, out, e) : LW_OK;
    lw_status s = lw_json_expect(out, LW_JSON_OBJECT, e);
    return s == LW_OK ? lw_json_known_keys(out, known, n, e) : s;
}

#define PART(of, key, known, need, out, given) part(of, key, known, COUNT(known), need, out, given, e)
#define NUMBERS(object, ...) lw_read_numbers(object, (const lw_number_key[]){ __VA_ARGS__ }, \
    COUNT(((const lw_number_key[]){ __VA_ARGS__ })), e)
#define AMOUNT(key, to) { key, 1, 0, INFINITY, to, NULL }
#define MORE(key, to) { key, 1, LW_POSITIVE, to, NULL }

static lw_status need_all(const lw_json_node *object, const char *const *key, int n, lw_error *e)
{
    lw_json_node any;
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < n; i++)
        s = lw_read_need(object, key[i], &any, e);
    return s;
}

static lw_status read_motor(const lw_json_node *root, lw_servo *p, lw_error *e)
{
    static const char *const known[] = { "torque_constant", "inertia", "resistance", "inductance", "coulomb", "viscous",
                                         "smoothing" };
    static const char *const amplifier[] = { "voltage", "current" };
    lw_json_node n;
    bool given;
    p->motor.smoothing = 0.1;
    lw_status s = PART(root, "motor", known, true, &n, &given);
    if (s == LW_OK && (s = need_all(&n, known, 3, e)) == LW_OK)
        s = NUMBERS(&n, MORE("torque_constant", &p->constant), MORE("inertia", &p->inertia),
                    AMOUNT("resistance", &p->resistance), AMOUNT("inductance", &p->inductance),
                    AMOUNT("coulomb", &p->motor.coulomb), AMOUNT("viscous", &p->motor.viscous),
                    MORE("smoothing", &p->motor.smoothing));
    p->motor.breakaway = p->motor.coulomb;
    p->voltage = p->current = INFINITY;
    if (s == LW_OK)
        s = PART(root, "amplifier", amplifier, false, &n, &given);
    return s == LW_OK && given ? NUMBERS(&n, MORE("voltage", &p->voltage), MORE("current", &p->current)) : s;
}

static lw_status read_load(const lw_json_node *root, lw_servo *p, lw_error *e)
{
    static const char *const known[] = { "radius", "ratio", "stiffness", "damping", "backlash" };
    static const char *const load[] = { "mass", "inertia", "coulomb", "breakaway", "stribeck", "viscous", "smoothing",
                                        "force" };
    lw_json_node n, other;
    bool given;
    double ratio = 1;
    p->factor = 1;
    lw_status s = PART(root, "transmission", known, false, &n, &given);
    if (s == LW_OK && given) {
        p->slides = lw_json_member(&n, "radius", &other);
        if (p->slides && lw_json_member(&n, "ratio", &other))
            return lw_json_fault(&other, e, "a slide has a \"radius\" (way over the turn of the motor), a shaft a \"ratio\"; keep one");
        s = NUMBERS(&n, MORE("radius", &p->factor), MORE("ratio", &ratio), { "stiffness", 1, LW_POSITIVE, &p->stiffness,
                    &p->elastic }, AMOUNT("damping", &p->damping), AMOUNT("backlash", &p->backlash));
        p->factor = p->slides ? p->factor : 1/ratio;
        if (s == LW_OK && !p->elastic && (p->damping > 0 || p->backlash > 0))
            s = lw_json_fault(&n, e, "\"damping\" and \"backlash\" need a \"stiffness\"");
    }
    if (s == LW_OK)
        s = PART(root, "load", load, false, &n, &given);
    p->friction.smoothing = 1e-3;
    p->friction.stribeck = 0.01;
    if (s != LW_OK || !given)
        return s == LW_OK && p->elastic ? lw_json_fault(root, e, "an elastic transmission needs a \"load\"") : s;
    if (lw_json_member(&n, p->slides ? "inertia" : "mass", &other))
        return lw_json_fault(&other, e, p->slides ? "a slide has a \"mass\", not an inertia"
                             : "a shaft has an \"inertia\"; a \"mass\" needs the \"radius\" of a \"transmission\"");
    s = NUMBERS(&n, AMOUNT("mass", &p->load), AMOUNT("inertia", &p->load), AMOUNT("coulomb", &p->friction.coulomb),
                AMOUNT("viscous", &p->friction.viscous), MORE("stribeck", &p->friction.stribeck),
                MORE("smoothing", &p->friction.smoothing));
    p->friction.breakaway = p->friction.coulomb;
    if (s == LW_OK)
        s = NUMBERS(&n, AMOUNT("breakaway", &p->friction.breakaway));
    if (s == LW_OK && p->elastic && !(p->load > 0))
        s = lw_json_fault(&n, e, "behind an elastic transmission the load needs a %s", p->slides ? "\"mass\"" : "\"inertia\"");
    return s == LW_OK ? lw_read_expression(&n, "force", &(lw_reading){ 0 }, LW_OF_TIME, &p->force, e) : s;
}

static lw_status read_loop(const lw_json_node *n, lw_servo_loop *loop, lw_error *e)
{
    lw_json_node at;
    lw_status s = NUMBERS(n, AMOUNT("sample", &loop->sample), AMOUNT("delay", &loop->delay));
    if (s == LW_OK && loop->delay > loop->sample) {
        lw_json_member(n, "delay", &at);
        s = lw_json_fault(&at, e, "the delay from a sample to the output is at most the \"sample\" time");
    }
    return s;
}

static lw_status read_control(const lw_json_node *root, lw_servo *p, lw_error *e)
{
    static const char *const loops[] = { "position", "speed", "current" };
    static const char *const position[] = { "gain", "speed_feed_forward", "acceleration_feed_forward", "sample", "delay" };
    static const char *const speed[] = { "proportional", "integral", "sample", "delay" };
    static const char *const current[] = { "bandwidth", "proportional", "integral", "emf_compensation", "sample", "delay" };
    lw_json_node all, n, at;
    bool given;
    double bandwidth = 0;
    lw_status s = PART(root, "control", loops, true, &all, &given);
    if (s == LW_OK && (s = PART(&all, "position", position, true, &n, &given)) == LW_OK &&
        (s = lw_read_need(&n, "gain", &at, e)) == LW_OK &&
        (s = NUMBERS(&n, AMOUNT("gain", &p->position.proportional), AMOUNT("speed_feed_forward", &p->speed_feed_forward),
                     AMOUNT("acceleration_feed_forward", &p->acceleration_feed_forward))) == LW_OK &&
        (s = read_loop(&n, &p->position, e)) == LW_OK && (s = PART(&all, "speed", speed, true, &n, &given)) == LW_OK &&
        (s = lw_read_need(&n, "proportional", &at, e)) == LW_OK &&
        (s = NUMBERS(&n, AMOUNT("proportional", &p->speed.proportional), AMOUNT("integral", &p->speed.integral))) == LW_OK &&
        (s = read_loop(&n, &p->speed, e)) == LW_OK)
        s = PART(&all, "current", current, false, &n, &given);
    p->ideal_current = !given;
    if (s != LW_OK || !given)
        return s;
    if (!(p->inductance > 0) || !(p->resistance > 0))
        return lw_json_fault(&n, e, "a current controller needs a motor with \"resistance\" and \"inductance\"; without the "
                             "controller the wanted current flows");
    bool both = lw_json_member(&n, "bandwidth", &at) &&
                (lw_json_member(&n, "proportional", &at) || lw_json_member(&n, "integral", &at));
    if (both)
        return lw_json_fault(&at, e, "\"bandwidth\" sets both gains; leave it or them out");
    s = NUMBERS(&n, MORE("bandwidth", &bandwidth), AMOUNT("proportional", &p->circuit.proportional),
                AMOUNT("integral", &p->circuit.integral));
    if (s == LW_OK && bandwidth > 0) {                     /* the zero of the controller lies on the pole R/L of the coil */
        p->circuit.proportional = bandwidth*p->inductance;
        p->circuit.integral = bandwidth*p->resistance;
    }
    if (s == LW_OK && !(p->circuit.proportional > 0))
        s = lw_json_fault(&n, e, "a current controller needs a \"bandwidth\" [1/s] or a \"proportional\" gain [V/A]");
    if (s == LW_OK && lw_json_member(&n, "emf_compensation", &at)) {
        int truth = lw_json_truth(&at);
        p->emf_compensation = truth == 1;
        s = truth < 0 ? lw_json_fault(&at, e, "this must be true or false") : LW_OK;
    }
    return s == LW_OK ? read_loop(&n, &p->circuit, e) : s;
}

static lw_status read_encoder(const lw_json_node *root, lw_servo *p, lw_error *e)
{
    static const char *const known[] = { "steps", "at" };
    static const char *const places[] = { "motor", "load" };
    lw_json_node n, at;
    bool given;
    int place = 0;
    lw_status s = PART(root, "encoder", known, false, &n, &given);
    if (s != LW_OK || !given)
        return s;
    s = NUMBERS(&n, MORE("steps", &p->encoder));
    if (s == LW_OK && lw_json_member(&n, "at", &at))
        s = lw_read_look_up(&at, "place of an encoder", places, COUNT(places), &place, e);
    p->encoder_at_load = place == 1;
    if (s == LW_OK && p->encoder > 0 && !(p->position.sample > 0 && p->speed.sample > 0))
        s = lw_json_fault(&n, e, "an encoder with steps needs a \"sample\" time of the position and of the speed controller");
    return s;
}

static lw_status read_motion(const lw_json_node *root, lw_servo *p, lw_error *e)
{
    static const char *const known[] = { "expression", "speed", "acceleration", "jerk", "from", "start", "mass", "moves" };
    lw_json_node n, moves;
    bool given;
    lw_status s = PART(root, "motion", known, true, &n, &given);
    if (s != LW_OK)
        return s;
    if (lw_json_member(&n, "expression", &moves))
        return lw_json_member(&n, "moves", &moves) ? lw_json_fault(&moves, e, "a motion has an \"expression\" or \"moves\"")
             : lw_read_expression(&n, "expression", &(lw_reading){ 0 }, LW_OF_TIME, &p->reference, e);
    return lw_moves_read(&n, &p->moves, e);
}

lw_status lw_servo_read(const char *text, size_t size, const char *file, lw_servo *p, lw_error *e)
{
    static const char *const known[] = { "linkwright", "name", "$schema", "servo" };
    static const char *const parts[] = { "motor", "amplifier", "transmission", "load", "encoder", "control", "motion" };
    lw_json json;
    lw_json_node n, servo;
    bool given;
    double version = 0;
    memset(p, 0, sizeof *p);
    lw_status s = lw_json_open(text, size, file, &json, e);
    if (s != LW_OK)
        return s;
    lw_json_node root = lw_json_root(&json);
    s = lw_json_expect(&root, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(&root, known, COUNT(known), e)) == LW_OK &&
        (s = lw_read_need(&root, "linkwright", &n, e)) == LW_OK && (s = lw_json_number(&n, &version, e)) == LW_OK &&
        version != 1)
        s = lw_json_fault(&n, e, "this program reads version 1");
    if (s == LW_OK && lw_json_member(&root, "name", &n))
        s = lw_json_name(&n, p->name, sizeof p->name, e);
    if (s == LW_OK && (s = PART(&root, "servo", parts, true, &servo, &given)) == LW_OK &&
        (s = read_motor(&servo, p, e)) == LW_OK && (s = read_load(&servo, p, e)) == LW_OK &&
        (s = read_control(&servo, p, e)) == LW_OK && (s = read_encoder(&servo, p, e)) == LW_OK)
        s = read_motion(&servo, p, e);
    lw_json_close(&json);
    if (s != LW_OK)
        lw_servo_free(p);
    return s;
}

void lw_servo_free(lw_servo *p)
{
    lw_moves_free(&p->moves);
    lw_expression_free(p->force);
    lw_expression_free(p->reference);
    memset(p, 0, sizeof *p);
}

/* ---- the wanted motion ------------------------------------------------------------------------------------- */

lw_axis_state lw_servo_wanted(const lw_servo *p, double t)
{
    if (p->reference) {
        double series[3] = { t, 1, 0 }, out[3];
        lw_expression_series(p->reference, 2, series, out);
        return (lw_axis_state){ out[0], out[1], 2*out[2] };
    }
    return lw_moves_at(&p->moves, t);
}

double lw_servo_next_kink(const lw_servo *p, double t) { return lw_moves_next_kink(&p->moves, t); }
