/* grammar/model/model_joint.c - stops, friction and clearance of a joint. */
#include "grammar/model/model_internal.h"

#include "base/real.h"

lw_status lw_read_stop(const lw_json_node *stop, double unit, lw_joint_stop *p, lw_error *e)
{
    static const char *const known[] = { "least", "greatest", "restitution", "stiffness", "damping" };
    const lw_number_key numbers[] = {
        { "least", unit, LW_ANY, &p->least, &p->has_least },
        { "greatest", unit, LW_ANY, &p->greatest, &p->has_greatest },
        { "restitution", 1, 0, 1, &p->restitution, NULL },
        { "stiffness", 1, LW_NOT_NEGATIVE, &p->stiffness, NULL },
        { "damping", 1, LW_NOT_NEGATIVE, &p->damping, NULL },
    };
    lw_status s = lw_json_known_keys(stop, known, COUNT(known), e);
    if (s == LW_OK)
        s = lw_read_numbers(stop, numbers, COUNT(numbers), e);
    if (s == LW_OK && !p->has_least && !p->has_greatest)
        s = lw_json_fault(stop, e, "a stop needs \"least\", \"greatest\" or both");
    if (s == LW_OK && p->has_least && p->has_greatest && !(p->least < p->greatest))
        s = lw_json_fault(stop, e, "\"least\" must be less than \"greatest\"");
    if (s == LW_OK && ((p->has_least && p->least > 0) || (p->has_greatest && p->greatest < 0)))
        s = lw_json_fault(stop, e, "the posture of the file, displacement 0, lies outside its stop");
    return s;
}

lw_status lw_read_friction(const lw_json_node *n, double metre, bool radius, lw_friction *f, lw_error *e)
{
    static const char *const known[] = { "coefficient", "radius", "speed" };
    bool given = false;
    const lw_number_key numbers[] = {
        { "coefficient", 1, 0, INFINITY, &f->coefficient, NULL },
        { "radius", metre, LW_POSITIVE, &f->radius, &given },
        { "speed", 1, LW_POSITIVE, &f->speed, NULL },
    };
    lw_json_node at;
    f->speed = 0;
    lw_status s = lw_json_expect(n, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(n, known, COUNT(known), e)) == LW_OK && (s = lw_read_need(n, "coefficient", &at, e)) == LW_OK)
        s = lw_read_numbers(n, numbers, COUNT(numbers), e);
    if (s == LW_OK && radius && !given)
        s = lw_json_fault(n, e, "friction of a joint that turns needs the \"radius\" of its pin or ball");
    if (s == LW_OK && !radius && given)
        s = lw_json_fault(n, e, "only joints that turn have a \"radius\"");
    return s;
}

static lw_status read_clearance_model(const lw_json_node *n, lw_clearance *c, lw_error *e)
{
    static const char *const names[] = { "zero", "link", "mlsd", "impact", "hunt-crossley",
                                         "lankarani-nikravesh" };
    int which;
    lw_json_node model;
    lw_status s = lw_read_need(n, "model", &model, e);
    if (s == LW_OK)
        s = lw_read_look_up(&model, "model of clearance", names, COUNT(names), &which, e);
    if (s == LW_OK)
        c->model = (lw_clearance_model)(LW_CLEARANCE_ZERO + which);
    return s;
}

/* The losses of a model of contact are those of its "damping", or of its "restitution": the other key alone would be without effect. */
static lw_status check_losses(const lw_json_node *n, const lw_clearance *c, bool restitution, lw_error *e)
{
    lw_json_node at;
    bool restores = c->model == LW_CLEARANCE_HUNT_CROSSLEY || c->model == LW_CLEARANCE_LANKARANI;
    if (restores && c->damping > 0 && !restitution && lw_json_member(n, "damping", &at))
        return lw_json_fault(&at, e, "the losses of this model of contact are those of its \"restitution\", and a damping has no effect: give that instead");
    if ((c->model == LW_CLEARANCE_MLSD || c->model == LW_CLEARANCE_IMPACT) && c->restitution < 1 && !(c->damping > 0) &&
        lw_json_member(n, "restitution", &at))
        return lw_json_fault(&at, e, "the losses of this model of contact are those of its \"damping\", and a restitution has no effect: give that instead");
    return LW_OK;
}

lw_status lw_read_clearance(const lw_json_node *n, double metre, lw_clearance *c, lw_error *e)
{
    static const char *const known[] = { "model", "gap", "stiffness", "exponent", "damping", "depth",
                                         "restitution", "friction", "friction_speed" };
    bool stiff = false, restitution = false;
    const lw_number_key numbers[] = {
        { "gap", metre, LW_POSITIVE, &c->gap, NULL },
        { "stiffness", 1, LW_POSITIVE, &c->stiffness, &stiff },
        { "exponent", 1, 1, 10, &c->exponent, NULL },
        { "damping", 1, 0, INFINITY, &c->damping, NULL },
        { "depth", metre, 0, INFINITY, &c->depth, NULL },
        { "restitution", 1, 0, 1, &c->restitution, &restitution },
        { "friction", 1, 0, INFINITY, &c->friction, NULL },
        { "friction_speed", 1, LW_POSITIVE, &c->friction_speed, NULL },
    };
    lw_json_node at;
    *c = (lw_clearance){ .exponent = 1, .restitution = 1, .friction_speed = 0.001 };
    lw_status s = lw_json_expect(n, LW_JSON_OBJECT, e);
    if (s == LW_OK && (s = lw_json_known_keys(n, known, COUNT(known), e)) == LW_OK &&
        (s = read_clearance_model(n, c, e)) == LW_OK && (s = lw_read_need(n, "gap", &at, e)) == LW_OK)
        s = lw_read_numbers(n, numbers, COUNT(numbers), e);
    if (s == LW_OK && c->model >= LW_CLEARANCE_MLSD && !stiff)
        s = lw_read_need(n, "stiffness", &at, e);
    return s == LW_OK ? check_losses(n, c, restitution, e) : s;
}

lw_status lw_read_check_centre(const lw_json_node *root, int link, const char *name, double away, double extent, lw_error *e)
{
    const double most = 1e6, rounding = 1e-7;      /* times the extent; [m]: joints in one point, such as those of a wrist, differ by rounding */
    lw_json_node links, at, centre;
    if (extent < rounding || away <= most*extent || !lw_json_member(root, "links", &links))
        return LW_OK;
    at = lw_json_element(&links, (size_t)link);
    return lw_json_fault(lw_json_member(&at, "centre", &centre) ? &centre : &at, e,
                         "the centre of mass of link \"%s\" lies %.3g m from its joint, but all joints and tracers lie within %.3g m: the "
                         "digits of their places would be lost; check the centre and its unit", name, away, extent);
}
