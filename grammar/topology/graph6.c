#include "grammar/topology/graph6.h"

#include <string.h>
#include "grammar/text/text_internal.h"

/* Reverse the bits: bit i becomes bit 31 - i. */
static uint32_t reversed(uint32_t v)
{
    v = (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
    v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
    v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(v);
}

/* Write the upper triangle column by column.  A column of it is a row of the lower triangle and so a word of bits;
 * six bits make a byte, the first is the highest. */
static void print_word(lw_text *t, int n, const uint32_t *one, const uint32_t *two)
{
    uint64_t bits = 0;
    int n_bit = 0;
    lw_text_byte(t, (char)(63 + n));
    for (int k = 1; k < n; k++) {
        bits = bits << k | reversed(one[k] | two[k]) >> (32 - k);
        for (n_bit += k; n_bit >= 6; n_bit -= 6)
            lw_text_byte(t, (char)(63 + (bits >> (n_bit - 6) & 63)));
    }
    if (n_bit > 0)
        lw_text_byte(t, (char)(63 + (bits << (6 - n_bit) & 63)));
}

size_t lw_graph6_print(const lw_chain *c, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    print_word(&t, c->n_link, c->one, c->two);
    if (lw_chain_count(c, 2) > 0) {
        lw_text_byte(&t, ' ');
        print_word(&t, c->n_link, c->two, c->two);
    }
    return t.length;
}

/* The next byte of a word as its six bits; -1 with e filled when the word ends too early. */
static int six_bits(lw_cursor *c, int n_left)
{
    int byte = lw_cursor_peek(c);
    char name[24];
    if (byte >= 63 && byte <= 126)
        return lw_cursor_next(c) - 63;
    if (byte == ' ' || byte == '\n' || byte == '\r' || byte < 0)
        lw_cursor_fail(c, "the graph6 word ends too early: %d more byte%s due for this number of "
                       "links", n_left, n_left == 1 ? " is" : "s are");
    else
        lw_cursor_fail(c, "%s is no byte of graph6, which uses '?' to '~' only", lw_byte_name(byte, name));
    return -1;
}

static lw_status read_size(lw_cursor *c, int *n)
{
    lw_cursor start = *c;
    char name[24];
    int byte = lw_cursor_peek(c);
    if (byte == ':' || byte == ';' || byte == '&')
        return lw_cursor_fail(c, "this line is %s, not graph6; convert it, for example by nauty's "
                              "copyg -g", byte == '&' ? "digraph6" : "sparse6");
    if (byte < 63 || byte > 126)
        return lw_cursor_fail(c, "a graph6 word was expected, not %s", lw_byte_name(byte, name));
    *n = lw_cursor_next(c) - 63;
    if (*n < 1)
        return lw_cursor_fail(&start, "the graph has no vertex; a chain has at least one link");
    if (*n > LW_LINK_MAX)
        return lw_cursor_fail(&start, "the graph has more than %d vertices, the most links a chain may have", LW_LINK_MAX);
    return LW_OK;
}

static lw_status read_word(lw_cursor *c, int *n, uint32_t *row)
{
    lw_status s = read_size(c, n);
    int bits = 0, n_bit = 0, n_left = s == LW_OK ? (*n*(*n - 1)/2 + 5)/6 : 0;
    memset(row, 0, LW_LINK_MAX*sizeof *row);
    for (int k = 1; s == LW_OK && k < *n; k++)
        for (int i = 0; i < k; i++) {
            if (n_bit == 0) {
                if ((bits = six_bits(c, n_left--)) < 0)
                    return LW_E_NOTATION;
                n_bit = 6;
            }
            if (bits >> --n_bit & 1) {
                row[i] |= 1u << k;
                row[k] |= 1u << i;
            }
        }
    if (s == LW_OK && bits & ((1 << n_bit) - 1)) {
        lw_cursor last = *c;
        last.column--;
        return lw_cursor_fail(&last, "the last byte has bits beyond the last pair of links");
    }
    return s;
}

static void skip_header(lw_cursor *c)
{
    static const char header[] = ">>graph6<<";
    if (c->size >= sizeof header - 1 && !memcmp(c->text, header, sizeof header - 1)) {
        c->at = sizeof header - 1;
        c->column = (long)sizeof header;
    }
}

/* Read the second word: the joints of two freedoms, each of which must be a joint of the first word. */
static lw_status read_two(lw_cursor *c, lw_chain *out)
{
    lw_cursor start = *c;
    uint32_t two[LW_LINK_MAX];
    int n;
    lw_status s = read_word(c, &n, two);
    if (s != LW_OK)
        return s;
    if (n != out->n_link)
        return lw_cursor_fail(&start, "the second word has %d links, the first %d", n, out->n_link);
    for (int i = 0; i < n; i++)
        if (two[i] & ~out->one[i])
            return lw_cursor_fail(&start, "the second word joins links %d and %d, which the first "
                                  "word, that of all joints, does not", i + 1,
                                  1 + __builtin_ctz(two[i] & ~out->one[i]));
    for (int i = 0; i < n; i++) {
        out->two[i] = two[i];
        out->one[i] &= ~two[i];
    }
    return LW_OK;
}

lw_status lw_graph6_read(const char *text, size_t size, const char *file, lw_chain *c, lw_error *e)
{
    lw_cursor at = lw_cursor_start(text, size, file, e);
    lw_chain out = { 0 };
    char name[24];
    skip_header(&at);
    lw_status s = read_word(&at, &out.n_link, out.one);
    if (s != LW_OK)
        return s;
    size_t end = at.at;
    lw_cursor_skip(&at, false, 0);
    int byte = lw_cursor_peek(&at);
    if (byte >= 63 && byte <= 126 && at.at > end)
        s = read_two(&at, &out);
    if (s != LW_OK)
        return s;
    lw_cursor_skip(&at, true, 0);
    if (lw_cursor_peek(&at) >= 0)
        return lw_cursor_fail(&at, "%s stands after the end of the graph6 word", lw_byte_name(lw_cursor_peek(&at), name));
    *c = out;
    return LW_OK;
}
