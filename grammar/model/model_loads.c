/* grammar/model/model_loads.c - what loads of planar and of spatial models have in common. */
#include "base/real.h"
#include "grammar/model/model_internal.h"

lw_status lw_read_spring_numbers(const lw_json_node *object, const lw_reading *r, lw_expression_scope scope, double unit, double *stiffness,
                                 double *damping, double *free, lw_expression **law, lw_error *e)
{
    const lw_number_key numbers[] = {
        { "stiffness", 1, LW_NOT_NEGATIVE, stiffness, NULL }, { "damping", 1, LW_NOT_NEGATIVE, damping, NULL },
        { "free", unit, scope == LW_OF_LENGTH ? 0 : -INFINITY, INFINITY, free, NULL },
    };
    lw_json_node n;
    double drawn = *free;
    lw_status s = lw_read_numbers(object, numbers, COUNT(numbers), e);
    if (s == LW_OK && scope == LW_OF_LENGTH && *stiffness > 0 && drawn < 1e-12**free && lw_json_member(object, "free", &n))
        s = lw_json_fault(&n, e, "both ends of this spring are at one place in the posture, where its force has no direction; draw them apart, or set "
                            "\"free\" to 0");
    if (s == LW_OK)
        s = lw_read_expression(object, "law", r, scope, law, e);
    for (int i = 0; s == LW_OK && *law && i < COUNT(numbers); i++)
        if (lw_json_member(object, numbers[i].key, &n))
            s = lw_json_fault(&n, e, "\"law\" says all of the force; leave \"%s\" out", numbers[i].key);
    return s;
}

static lw_status read_spring_or_damper(const lw_json_node *object, size_t index, bool damper, const lw_reading *r, lw_error *e)
{
    static const char *const spring[] = { "name", "links", "at", "joint", "coordinate", "stiffness", "damping", "free", "law" };
    static const char *const dashpot[] = { "name", "links", "at", "joint", "coordinate", "damping" };
    const char *known[COUNT(spring)], *what = damper ? "damper" : "spring";
    int n_known = 0;
    lw_json_node n, joint;
    for (int i = 0; i < (damper ? COUNT(dashpot) : COUNT(spring)); i++)
        if (r->spatial || strcmp(spring[i], "coordinate") != 0)
            known[n_known++] = damper ? dashpot[i] : spring[i];
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(object, known, n_known, e);
    if (s != LW_OK)
        return s;
    bool at_joint = lw_json_member(object, "joint", &joint);
    if (at_joint && (lw_json_member(object, "links", &n) || lw_json_member(object, "at", &n)))
        return lw_json_fault(&n, e, "a %s acts at a \"joint\" or between the points \"at\" of two \"links\"; keep one", what);
    if (!lw_json_member(object, damper ? "damping" : "stiffness", &n) && (damper || !lw_json_member(object, "law", &n)))
        return lw_json_fault(object, e, damper ? "\"damping\" is missing" : "\"stiffness\" or \"law\" is missing");
    return r->spring[at_joint](object, what, index, r, e);
}

lw_status lw_read_spring(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    return read_spring_or_damper(object, index, false, r, e);
}

lw_status lw_read_damper(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e)
{
    return read_spring_or_damper(object, index, true, r, e);
}

lw_status lw_read_motor_name(const lw_json_node *object, size_t index, lw_motor *p, lw_error *e)
{
    static const char *const known[] = { "name", "joint", "stall", "free_speed" };
    lw_status s = lw_json_expect(object, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(object, known, COUNT(known), e);
    return s == LW_OK ? lw_read_own_name(object, "motor", index, p->name, e) : s;
}

lw_status lw_read_motor_line(const lw_json_node *object, lw_motor *p, lw_error *e)
{
    const lw_number_key numbers[] = { { "stall", 1, LW_ANY, &p->stall, NULL }, { "free_speed", 1, LW_ANY, &p->free_speed, NULL } };
    lw_json_node n;
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < COUNT(numbers); i++)
        s = lw_read_need(object, numbers[i].key, &n, e);
    if (s == LW_OK)
        s = lw_read_numbers(object, numbers, COUNT(numbers), e);
    if (s == LW_OK && !(p->stall*p->free_speed > 0))
        s = lw_json_fault(object, e, "\"stall\" and \"free_speed\" of a motor have the same sign, that of its motion, and are not 0");
    return s;
}
