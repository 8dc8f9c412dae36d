/* tests/cli_json.h - read the JSON that the program prints. */
#ifndef LW_TESTS_CLI_JSON_H
#define LW_TESTS_CLI_JSON_H

#include <jansson.h>
#include "tests/cli_run.h"

/* The JSON a command prints that must end with this exit code; NULL when it prints none. */
static inline json_t *json_ending(const char *command, int code)
{
    json_error_t e;
    ran r = run(command);
    CHECK_INT(r.code, code);
    json_t *root = json_loads(r.out, 0, &e);
    if (!root)
        fprintf(stderr, "%s: line %d: %s\n  said: %s", command, e.line, e.text, r.err);
    CHECK(root != NULL);
    ran_free(&r);
    return root;
}

static inline json_t *json_of(const char *command) { return json_ending(command, 0); }

__attribute__((format(printf, 1, 2))) static inline json_t *json_with(const char *format, ...)
{
    RUN_FORMAT(format);
    return json_of(run_text);
}

static inline long integer(const json_t *o, const char *key)
{
    return (long)json_integer_value(json_object_get(o, key));
}

/* Is each mechanism that a search counted for a number of links also accounted for: known[] is the number of links, of
 * chains and of ground choices. */
static inline void check_accounts(const json_t *t, const long known[3])
{
    static const char *const fates[] = { "fitted", "joined_to_ground", "smaller", "no_plan", "no_gear", "not_asked" };
    long sum = 0;
    for (int k = 0; k < 6; k++)
        sum += integer(t, fates[k]);
    CHECK_INT(integer(t, "links"), known[0]);
    CHECK_INT(integer(t, "chains"), known[1]);
    CHECK_INT(integer(t, "grounds"), known[2]);
    CHECK_INT(sum, integer(t, "with_tracer_link"));
    CHECK_INT(integer(t, "searched") + integer(t, "unable") + integer(t, "not_reached"), integer(t, "families"));
}

static inline double real(const json_t *o, const char *key) { return json_number_value(json_object_get(o, key)); }

#endif
