/* tests/large_models.h - models of any size from text: a rope of n links, a row of n loops. */
#ifndef LW_TESTS_LARGE_MODELS_H
#define LW_TESTS_LARGE_MODELS_H

#include "grammar/model/model.h"
#include "tests/json_text.h"

typedef struct text { char *at; size_t n, capacity; } text;

static inline void put(text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
static inline void put(text *t, const char *format, ...)
{
    if (t->capacity < t->n + 1000)
        t->at = realloc(t->at, t->capacity = 2*t->capacity + 2000);
    va_list arg;
    va_start(arg, format);
    t->n += (size_t)vsnprintf(t->at + t->n, 1000, format, arg);
    va_end(arg);
}

/* Read the text with single quotes for double ones. */
static inline void read_text(text *t, lw_model *m)
{
    CHECK_OK(lw_model_read(json_quotes(t->at), t->n, "text", m, &check_error));
    free(t->at);
}

/* A rope of n links of length 1/n, horizontal, pinned at one end; damping of each pin [N m s/rad]. */
static inline void read_chain(int n, double damping, lw_model *m)
{
    text t = { 0 };
    put(&t, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground'");
    for (int i = 0; i < n; i++)
        put(&t, ",{'name': 'b%d', 'mass': %.17g, 'centre': [%.17g, 0], 'inertia': %.17g}", i, 1.0/n, (i + 0.5)/n,
            1.0/12/n/n/n);
    put(&t, "], 'joints': [");
    for (int i = 0; i < n; i++)
        put(&t, "%s{'name': 'J%d', 'links': ['%s%.0d', 'b%d'], 'at': [%.17g, 0]}", i ? "," : "", i,
            i == 0 ? "ground" : i == 1 ? "b0" : "b", i > 1 ? i - 1 : 0, i, (double)i/n);
    put(&t, "], 'dampers': [");
    for (int i = 0; damping > 0 && i < n; i++)
        put(&t, "%s{'joint': 'J%d', 'damping': %.17g}", i ? "," : "", i, damping);
    put(&t, "]}");
    read_text(&t, m);
}

/* N four-bars in a row: n + 1 upright cranks on the ground, each by `rise` longer than the one before it, their ends joined by rods. */
static inline void read_rising_row(int n, double rise, lw_model *m)
{
    text t = { 0 };
    put(&t, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground'");
    for (int i = 0; i <= n; i++)
        put(&t, ",{'name': 'c%d', 'mass': 1, 'centre': [%d, 0.5], 'inertia': 0.083333333333333333}", i, i);
    for (int i = 0; i < n; i++)
        put(&t, ",{'name': 'r%d', 'mass': 1, 'centre': [%.1f, 1], 'inertia': 0.083333333333333333}", i, i + 0.5);
    put(&t, "], 'joints': [{'name': 'A0', 'links': ['ground', 'c0'], 'at': [0, 0]}");
    for (int i = 1; i <= n; i++)
        put(&t, ",{'name': 'A%d', 'links': ['ground', 'c%d'], 'at': [%d, 0]}"
            ",{'name': 'B%d', 'links': ['c%d', 'r%d'], 'at': [%d, %.17g]},{'name': 'C%d', 'links': ['r%d', 'c%d'], 'at': [%d, %.17g]}",
            i, i, i, i, i - 1, i - 1, i - 1, 1 + rise*(i - 1), i, i - 1, i, i, 1 + rise*i);
    put(&t, "], 'input': {'joint': 'A0', 'speed': 1}}");
    read_text(&t, m);
}

static inline void read_row(int n, lw_model *m) { read_rising_row(n, 0, m); }

#endif
