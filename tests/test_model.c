/* Models as text: what is read, what is refused and where. */
#include "grammar/model/model.h"
#include "tests/json_text.h"

#define JOINTS \
    "'joints': [{'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0]%s},\n" \
    "{'name': 'D', 'kind': 't', 'links': ['crank', 'slide'], 'at': [10, 0], 'along': [1, 0]%s}]"

static lw_model m;
static lw_error e;

/* A crank with a slider on it, with extras for the joints, the crank, and the whole. */
static lw_status read_with(const char *pin, const char *slider, const char *crank, const char *more)
{
    static char text[8192], joints[4096];
    snprintf(joints, sizeof joints, JOINTS, pin, slider);
    snprintf(text, sizeof text, "{'linkwright': 1, 'units': {'length': 'mm', 'angle': 'deg'},\n"
             "'links': ['ground', {'name': 'crank'%s}, 'slide'],\n%s,\n"
             "'tracers': [{'name': 'P', 'link': 'slide', 'at': [20, 0]}]%s}", crank, joints, more);
    e = (lw_error){ 0 };
    return lw_model_read(json_quotes(text), strlen(text), "f", &m, &e);
}

static double value(const lw_expression *x, double a, double b)
{
    double v[LW_EXPRESSION_VARIABLE_MAX] = { a, b };
    return lw_expression_value(x, v);
}

TEST(a_linkage_is_a_model)
{
    CHECK_INT(read_with("", "", "", ""), LW_OK);
    CHECK_INT(m.linkage.n_joint, 2);
    CHECK(!m.body[1].given && m.n_spring == 0 && m.gravity.y == 0 && !m.motion[0]);
    lw_model_free(&m);
}

TEST(bodies_in_their_units)
{
    CHECK_INT(read_with("", "", ", 'mass': 2, 'centre': [500, 100], 'inertia': 0.5",
                        ", 'gravity': [0, -9.81], 'input': {'joint': 'D', 'speed': 3}"), LW_OK);
    CHECK(m.body[1].given);
    CHECK_NEAR(m.body[1].mass, 2, 0, 0);
    CHECK_POINT(m.body[1].centre, 0.5, 0.1, 0, 1e-15);
    CHECK_NEAR(m.body[1].inertia, 0.5, 0, 0);
    CHECK_NEAR(m.gravity.y, -9.81, 0, 0);
    CHECK(m.has_speed[0]);
    CHECK_NEAR(m.speed[0], 3, 0, 0);
    lw_model_free(&m);
}

TEST(joints_and_loads)
{
    CHECK_INT(read_with(", 'friction': {'coefficient': 0.2, 'radius': 5}, 'stop': {'least': -90, "
        "'restitution': 0.5}, 'clearance': {'model': 'impact', 'gap': 0.1, 'stiffness': 1e8}",
        ", 'stop': {'greatest': 30, 'stiffness': 1e5}", "",
        ", 'springs': [{'joint': 'A', 'stiffness': 3, 'free': 180}, {'links': ['ground', 'slide'], 'at': [[0, 30], [40, 0]], 'stiffness': 7}, {'joint': "
        "'D', 'law': '-100*displacement^3 - rate'}], 'dampers': [{'name': 'dash', 'links': ['ground', 'slide'], 'at': [[0, 0], [9, 0]], 'damping': 4}], "
        "'forces': [{'link': 'slide', 'at': [10, 0], 'frame': 'link', 'fx': -5, 'fy': 'v(D)*x(P)'}], 'motors': [{'joint': 'A', 'stall': 2, 'free_speed': "
        "10}], 'input': {'joint': 'A', 'motion': '2*pi*t'}"), LW_OK);
    CHECK_NEAR(m.friction[0].radius, 0.005, 0, 1e-15);
    CHECK_NEAR(m.friction[0].speed, 0, 0, 0);
    CHECK(m.stop[0].has_least && !m.stop[0].has_greatest);
    CHECK_NEAR(m.stop[0].least, -LW_PI/2, 1e-15, 0);
    CHECK_NEAR(m.stop[1].greatest, 0.03, 0, 1e-15);
    CHECK_INT(m.clearance[0].model, LW_CLEARANCE_IMPACT);
    CHECK_NEAR(m.clearance[0].gap, 1e-4, 0, 1e-15);
    CHECK_INT(m.n_joint_spring, 2);
    CHECK_INT(m.n_spring, 2);
    CHECK_NEAR(m.joint_spring[0].free, LW_PI, 1e-15, 0);
    CHECK_NEAR(m.spring[0].free, 0.05, 1e-16, 0);
    CHECK_TEXT(m.spring[0].name, "spring 2");
    CHECK_TEXT(m.spring[1].name, "dash");
    CHECK_NEAR(value(m.joint_spring[1].law, 2, 3), -803, 0, 0);
    CHECK_NEAR(value(m.force[0].force[0], 0, 0), -5, 0, 0);
    CHECK(m.force[0].follows && !m.force[0].torque[2]);
    const int *which;
    CHECK_INT(lw_expression_variables(m.force[0].force[1], &which), 2);
    CHECK_INT(which[0], lw_variable(LW_QUANTITY_V, 1));
    CHECK_INT(which[1], lw_variable(LW_QUANTITY_X, 0));
    CHECK_NEAR(m.motor[0].stall, 2, 0, 0);
    CHECK_NEAR(value(m.motion[0], 0.5, 0), LW_PI, 0, 1e-15);
    lw_model_free(&m);
}

/* Each with a part of the text that tells it. */
TEST(faults)
{
    static const struct { const char *pin, *slider, *crank, *more, *text; } bad[] = {
        { "", "", ", 'mass': -1, 'centre': [0, 0]", "", "links[1].mass: this must not be negative" },
        { "", "", ", 'inertia': 1", "", "no \"mass\"" },
        { "", "", ", 'mass': 1", "", "no \"centre\"" },
        { "", "", ", 'mass': 1, 'centre': [0, 1e12]", "", "links[1].centre: the centre of mass of link" },
        { "", "", ", 'mas': 1", "", "did you mean \"mass\"" },
        { ", 'friction': {'coefficient': 1}", "", "", "", "needs the \"radius\"" },
        { "", ", 'friction': {'coefficient': 1, 'radius': 2}", "", "", "only joints that turn" },
        { "", ", 'clearance': {'model': 'impact', 'gap': 1, 'stiffness': 1}", "", "", "only pins" },
        { ", 'clearance': {'model': 'impct', 'gap': 1}", "", "", "", "did you mean \"impact\"" },
        { ", 'clearance': {'model': 'impact', 'gap': 1}", "", "", "", "\"stiffness\" is missing" },
        { ", 'clearance': {'model': 'zero', 'gap': 0}", "", "", "", "greater than 0" },
        { ", 'clearance': {'model': 'hunt-crossley', 'gap': 1, 'stiffness': 1, 'damping': 1}", "", "", "", "are those of its \"restitution\"" },
        { ", 'clearance': {'model': 'impact', 'gap': 1, 'stiffness': 1, 'restitution': 0.5}", "", "", "", "are those of its \"damping\"" },
        { ", 'stop': {}", "", "", "", "needs \"least\"" },
        { ", 'stop': {'least': 10}", "", "", "", "outside its stop" },
        { ", 'stop': {'least': -1, 'restitution': 2}", "", "", "", "between 0 and 1" },
        { "", "", "", ", 'springs': [{'joint': 'A'}]", "\"stiffness\" or \"law\" is missing" },
        { "", "", "", ", 'springs': [{'joint': 'B', 'stiffness': 1}]", "no joint \"B\"" },
        { "", "", "", ", 'springs': [{'joint': 'A', 'law': 'rate', 'free': 1}]", "leave \"free\" out" },
        { "", "", "", ", 'springs': [{'joint': 'A', 'law': 'length'}]", "displacement, rate and t" },
        { "", "", "", ", 'springs': [{'links': ['crank', 'crank'], 'at': [[0, 0], [1, 1]], 'stiffness': 1}]", "both ends are on link" },
        { "", "", "", ", 'springs': [{'links': ['ground', 'crank'], 'at': [[1, 1], [1, 1]], 'stiffness': 1, 'free': 2}]", "its force has no direction" },
        { "", "", "", ", 'forces': [{'link': 'slide', 'fx': 1}]", "\"at\" is missing" },
        { "", "", "", ", 'forces': [{'link': 'slide'}]", "needs \"fx\"" },
        { "", "", "", ", 'forces': [{'link': 'slide', 'torque': 'q(P)'}]", "no joint \"P\"" },
        { "", "", "", ", 'forces': [{'link': 'slide', 'torque': true}]", "a number or an expression" },
        { "", "", "", ", 'motors': [{'joint': 'A', 'stall': 1, 'free_speed': -1}]", "same sign" },
        { "", "", "", ", 'input': {'joint': 'A', 'motion': 't', 'speed': 1}", "keep one" },
        { "", "", "", ", 'input': {'joint': 'A', 'motion': 'q(A)'}", "depends on t alone" },
        { "", "", "", ", 'forces': [{'link': 'slide', 'torque': 'q(AA)'}]", "no joint \"AA\"; did you mean \"A\"?" },
        { "", "", "", ", 'forces': [{'link': 'slide', 'torque': 'omega(slid)'}]", "did you mean \"slide\"?" },
        { "", "", "", ", 'forces': [{'link': 'slide', 'torque': 'length(S)'}]", "no spring or cylinder between two points \"S\"" },
        { "", "", "", ", 'forces': [{'link': 'slide', 'torque': 't**2'}]", "a power is written a^b" },
        { "", "", "", ", 'springs': [{'name': 'S', 'joint': 'A', 'stiffness': 1}], "
          "'dampers': [{'joint': 'A', 'damping': 1}, {'name': 'S', 'joint': 'A', 'damping': 1}]",
          "dampers[1]: this is the second damper of the name \"S\"" },
        { "", "", "", ", 'forces': [{'name': 'force 2', 'link': 'slide', 'torque': 1}, {'link': 'slide', 'torque': 1}]",
          "second force of the name \"force 2\"" },
        { "", "", ", 'shapes': [{'polygon': [[0, 0], [1, 1], [1, 0], [0, 1]]}]", "", "the side from corner 3 meets that from corner 1" },
        { "", "", ", 'shapes': [{'polygon': [[0, 0], [1, 0], [1, 1], [0, 0]]}]", "", "the last corner is the first one again" },
        { "", "", "", ", 'gravity': 9.81", "a list" },
        { "", "", "", ", 'gravty': [0, 0]", "did you mean \"gravity\"" },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        CHECK_INT(read_with(bad[i].pin, bad[i].slider, bad[i].crank, bad[i].more), LW_E_NOTATION);
        CHECK_HAS(e.text, bad[i].text);
        CHECK(e.line > 0 && e.column > 0);
    }
}

/* The column counts in the file, past escapes. */
TEST(column_inside_an_expression)
{
    CHECK_INT(read_with("", "", "", ",\n'input': {'joint': 'A', 'motion': 't + foo'}"), LW_E_NOTATION);
    CHECK_INT(e.column, 40);
    CHECK_INT(read_with("", "", "", ",\n'input': {'joint': 'A', 'motion': '\\u0074 + foo'}"), LW_E_NOTATION);
    CHECK_INT(e.column, 45);
}
