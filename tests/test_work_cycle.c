/* test_work_cycle.c - work cycles: known times, limits and continuity over the whole cycle, what is refused. */
#include "grammar/model/work_cycle.h"
#include "tests/json_text.h"

#define AXES "'axes': [{'name': 'y', 'speed': 3, 'acceleration': 20, 'jerk': 400}, " \
             "{'name': 'z', 'speed': 3, " \
             "'acceleration': 20, 'jerk': 400}]"
#define CYCLE(moves) "{'linkwright-cycle': 1, " AXES ",\n'moves': [" moves "]}"

static lw_error error;

static lw_work_cycle read_cycle(const char *text)
{
    lw_work_cycle c;
    error = (lw_error){ 0 };
    char *json = json_quotes(strdup(text));
    CHECK_INT(lw_work_cycle_read(json, strlen(json), "f", &c, &error), LW_OK);
    free(json);
    CHECK_TEXT(error.text, "");
    return c;
}

/* Makkonen 1999, paper D, table 3: up 0.2, over 1.0, down 0.8 m with 20 m/s^2 and 400 m/s^3: 1.209268169 s one way. */
TEST(gantry)
{
    lw_work_cycle c = read_cycle("{'linkwright-cycle': 1, 'cycle_time': 2.5, 'axes': [{'name': 'y', 'acceleration': 20, 'jerk': 400}, {'name': 'z', "
                                 "'acceleration': 20, 'jerk': 400}], 'moves': [{'to': {'z': 0.2}, 'payload': 10}, {'to': {'y': 1}}, {'to': {'z': -0.6}}, "
                                 "{'to': {'z': 0.2}, 'payload': 0}, {'to': {'y': 0}}, {'to': {'z': 0}}]}");
    CHECK_NEAR(c.move[3].start, 1.209268169, 1e-9, 0);
    CHECK_NEAR(c.end, 2.418536337, 1e-9, 0);
    CHECK_NEAR(c.wanted, 2.5, 0, 0);
    CHECK_NEAR(lw_work_cycle_payload(&c, 1.2), 10, 0, 0);
    CHECK_NEAR(lw_work_cycle_payload(&c, 1.21), 0, 0, 0);
    CHECK_NEAR(lw_work_cycle_at(&c, 1, c.end, NULL).x, 0, 0, 0);
    lw_work_cycle_free(&c);
}

/* Over a cycle with overlaps, a passing speed, rests, axes together: positions follow from speeds, these from
 * accelerations, and no limit is exceeded. */
TEST(smooth)
{
    enum { N = 200000 };
    lw_work_cycle c = read_cycle(CYCLE("{'to': {'z': 0.3}}, {'to': {'y': 1.2}, 'blend': 0.1}, {'to': {'z': -0.5}, 'speed': {'z': -0.5}, 'blend': 0.12}, "
                                       "{'to': {'z': -0.6}, 'dwell': 0.2}, {'to': {'y': 0.4, 'z': 0.1}, 'straight': true}, {'to': {'y': 0, 'z': 0}, "
                                       "'duration': 1.5}"));
    double speed = 0, step = c.end/N;
    for (int k = 0; k < 2; k++) {
        lw_axis_state before = lw_work_cycle_at(&c, k, 0, NULL);
        for (int i = 1; i <= N; i++) {
            lw_axis_state s = lw_work_cycle_at(&c, k, c.end*i/N, NULL);
            CHECK(fabs(s.v) <= 3*(1 + 1e-12) && fabs(s.a) <= 20*(1 + 1e-12));
            CHECK_NEAR(s.x - before.x, (s.v + before.v)/2*step, 1e-9, 0);
            CHECK_NEAR(s.v - before.v, (s.a + before.a)/2*step, 1e-6, 0);
            speed = fmax(speed, fabs(s.v));
            before = s;
        }
        CHECK_NEAR(before.x, 0, 0, 0);
    }
    CHECK(speed > 2);
    const lw_cycle_move *m = &c.move[4];                      /* straight: y and z in one proportion */
    for (int i = 1; i < 20; i++) {
        double t = m->start + m->duration*i/20, y = lw_work_cycle_at(&c, 0, t, NULL).x, z = lw_work_cycle_at(&c, 1, t, NULL).x;
        CHECK_NEAR((y - 1.2)/(0.4 - 1.2), (z + 0.6)/0.7, 1e-9, 0);
    }
    CHECK_NEAR(c.move[5].duration, 1.5, 1e-9, 0);
    CHECK_NEAR(lw_work_cycle_at(&c, 1, c.move[3].start, NULL).v, -0.5, 1e-9, 0);
    CHECK_NEAR(m->start - c.move[3].start - c.move[3].duration, 0.2, 1e-12, 0);
    lw_work_cycle_free(&c);
}

TEST(refused)
{
    /* @ marks the place, and is not part of the text */
    static const struct { const char *text, *says; } rows[] = {
        { "{@'linkwright-cicle': 1}", "did you mean \"linkwright-cycle\"" },
        { "{'linkwright-cycle': 1, 'axes': [@{'name': 'y', 'speed': 1}], 'moves': [{}]}", "needs a limit" },
        { "{'linkwright-cycle': 1, 'axes': @[], 'moves': [{}]}", "a list of 1 to 64" },
        { CYCLE("{'to': {@'w': 1}}"), "not known" }, { CYCLE("@{'to': {}}"), "moves no axis" },
        { CYCLE("@{'to': {'y': 1}, 'speed': {'y': 1}}"), "still has a speed of 1 at the end" },
        { CYCLE("{'to': {'y': 1}, 'speed': {'y': @4}}"), "above the limit 3" },
        { CYCLE("{'to': {'y': 1}, 'speed': {'y': 1}}, @{'to': {'z': 1}}"), "has to go on at once" },
        { CYCLE("{'to': {'y': 1}, 'blend': @0.1}"), "there is none before" },
        { CYCLE("{'to': {'y': 1}}, {'to': {'z': 1}, 'blend': @5}"), "at most as long" },
        { CYCLE("{'to': {'y': 1}}, @{'to': {'y': 0}, 'blend': 0.1}"), "still moves until" },
        { CYCLE("{'to': {'y': 1}, 'dwell': 1}, {'to': {'z': 0}, 'blend': @0.1}"), "followed by a rest" },
        { CYCLE("{'to': {'y': 1}, 'duration': @-1}"), "greater than 0" },
        { CYCLE("{'to': {'y': 1}, 'straight': @1}"), "true or false" } };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        char text[600];
        OWN(lw_work_cycle) c = { 0 };
        json_format(text, sizeof text, "%s", rows[i].text);
        char *mark = strchr(text, '@'), *line = memrchr(text, '\n', (size_t)(mark - text));
        memmove(mark, mark + 1, strlen(mark));
        error = (lw_error){ 0 };
        CHECK_INT(lw_work_cycle_read(text, strlen(text), "f", &c, &error), LW_E_NOTATION);
        CHECK_HAS(error.text, rows[i].says);
        CHECK_INT(error.line, line ? 2 : 1);
        CHECK_INT(error.column, mark - (line ? line + 1 : text) + 1);
    }
}
