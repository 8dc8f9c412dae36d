/* A sentence that can be read is printed and read back the same, and its mechanism has a sentence too. */
#include "grammar/topology/sentence.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    static lw_sentence s, other;
    static char text[LW_SENTENCE_SIZE];
    lw_mechanism m, back;
    lw_error e;
    if (lw_sentence_read((const char *)data, size, "fuzz", &s, &e) != LW_OK)
        return 0;
    size_t n = lw_sentence_print(&s, text, sizeof text);
    if (n >= sizeof text || lw_sentence_read(text, n, "fuzz", &other, &e) != LW_OK
        || lw_sentence_mechanism(&other, &m, &e) != LW_OK
        || lw_sentence_from_mechanism(&m, &other) != LW_OK
        || lw_sentence_mechanism(&other, &back, &e) != LW_OK || !lw_mechanism_same(&m, &back))
        abort();
    return 0;
}
