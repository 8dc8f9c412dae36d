/* Reading a stream of topologies comes to an end, and each topology read fits the largest size of each notation. */
#include "grammar/topology/notation.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    static char text[LW_NOTATION_SIZE];
    lw_topologies t = lw_topologies_open((const char *)data, size, "fuzz");
    lw_mechanism m;
    lw_error e;
    size_t before = 0, length;
    for (lw_status s; (s = lw_topologies_next(&t, &m, &e)) != LW_NOTHING; before = t.at) {
        if (t.at <= before)
            abort();
        for (const lw_notation *n = lw_notations; s == LW_OK && n->name; n++)
            if (n->print(&m, text, sizeof text, &length) == LW_OK && length >= n->most)
                abort();
    }
    return 0;
}
