/* tests/cli_json.h - what the program said as JSON. */
#ifndef LW_TESTS_CLI_JSON_H
#define LW_TESTS_CLI_JSON_H

#include <jansson.h>
#include "tests/cli_run.h"

/* Of a run that had to end with this code; the run is freed. */
static inline json_t *json_of_run(ran r, int code)
{
    CHECK_INT(r.code, code);
    json_t *root = json_loads(r.out, 0, NULL);
    CHECK(root != NULL);
    ran_free(&r);
    return root;
}

static inline long integer(const json_t *o, const char *key)
{
    return (long)json_integer_value(json_object_get(o, key));
}

static inline double real(const json_t *o, const char *key) { return json_number_value(json_object_get(o, key)); }

#endif
