/* grammar/topology/sentence_read.c - text -> sentence -> mechanism: the tokens first, then whether the words
 * fit together. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "grammar/text/text_internal.h"
#include "grammar/topology/circuit.h"
#include "grammar/topology/sentence.h"

/* The places of atoms and words in the text. */
typedef struct places { lw_cursor part[LW_ATOM_MAX], word[LW_WORD_MAX]; } places;

typedef struct check {
    const lw_sentence *s;
    const places      *where;                             /* NULL: made by a program             */
    lw_error          *e;
    lw_mechanism       m;
    int                highest;                           /* the highest part number             */
    short              atom[LW_LINK_MAX][LW_LINK_MAX];    /* an atom of the joint + 1, both ways */
    uint8_t            sides[LW_LINK_MAX][LW_LINK_MAX];   /* how often words walk along it       */
} check;

/* The atom after i in word w, and the one before; links count from 0. */
static int after(const lw_sentence *s, int w, int i)
{
    return i + 1 < s->first[w + 1] ? i + 1 : s->first[w];
}

static int link_at(const check *c, int i) { return c->s->part[i] - 1; }

/* An error of meaning at an atom, or at the whole word when atom is LW_NONE. */
__attribute__((format(printf, 4, 5)))
static lw_status fault(const check *c, int word, int atom, const char *format, ...)
{
    char text[512];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    if (c->where)
        return lw_cursor_fail(atom == LW_NONE ? &c->where->word[word] : &c->where->part[atom], "%s", text);
    return lw_error_set(c->e, LW_E_NOTATION, "word %d: %s", word + 1, text);
}

static lw_status check_joint(check *c, int w, int i)
{
    int k = after(c->s, w, i), a = link_at(c, i), b = link_at(c, k);
    char kind = c->s->joint[i];
    if (a < 0 || a >= LW_LINK_MAX)
        return fault(c, w, i, "parts are numbered 1 to %d", LW_LINK_MAX);
    if (a == b)
        return fault(c, w, i, "part %d is joined to itself", a + 1);
    if (lw_joint_freedoms(kind) == 0 || lw_joint_freedoms(kind) == 3)        /* a free link has no joint */
        return fault(c, w, i, "a joint is r, t, p or g");
    if (b < 0 || b >= LW_LINK_MAX)
        return LW_OK;                                      /* reported when that word is checked */
    if (c->atom[a][b] && c->s->joint[c->atom[a][b] - 1] != kind)
        return fault(c, w, i, "the joint of parts %d and %d is %c here and %c elsewhere", a + 1,
                     b + 1, kind, c->s->joint[c->atom[a][b] - 1]);
    c->atom[a][b] = c->atom[b][a] = (short)(i + 1);
    if (c->sides[a][b] < 255)
        c->sides[a][b]++;
    c->sides[b][a] = c->sides[a][b];
    if (a >= c->highest)
        c->highest = a + 1;
    return LW_OK;
}

static lw_status check_joints(check *c)
{
    for (int w = 0; w < c->s->n_word; w++)
        for (int i = c->s->first[w]; i < c->s->first[w + 1]; i++) {
            lw_status s = check_joint(c, w, i);
            if (s != LW_OK)
                return s;
        }
    return LW_OK;
}

static int word_of(const lw_sentence *s, int atom)
{
    int w = 0;
    while (s->first[w + 1] <= atom)
        w++;
    return w;
}

/* Collect all joints in c->m; check that part numbers have no gap and that all is connected. */
static lw_status collect(check *c)
{
    lw_chain chain;
    lw_mechanism_clear(&c->m, c->highest);
    for (int i = 0; i < c->highest; i++)
        for (int k = i + 1; k < c->highest; k++)
            if (c->atom[i][k]) {
                int atom = c->atom[i][k] - 1;
                if (lw_mechanism_join(&c->m, i, k, c->s->joint[atom]) != LW_OK)
                    return fault(c, word_of(c->s, atom), atom, "this joint is one too many: at most %d joints are handled", LW_JOINT_MAX);
            }
    lw_mechanism_chain(&c->m, &chain);
    for (int i = 0; i < c->highest; i++)
        if (lw_chain_degree(&chain, i) == 0)
            return fault(c, 0, LW_NONE, "there is a part %d but no part %d: parts are numbered 1 to P without a gap", c->highest, i + 1);
    if (!lw_chain_is_connected(&chain))
        return fault(c, 0, LW_NONE, "the words speak of parts that nothing connects");
    return LW_OK;
}

/* At each part, the corners of the words must connect its neighbours to one ring. */
static lw_status check_ring(const check *c, int link)
{
    uint32_t beside[LW_LINK_MAX] = { 0 }, all = 0, seen, front;
    int atom_here = 0;
    for (int w = 0; w < c->s->n_word; w++)
        for (int i = c->s->first[w]; i < c->s->first[w + 1]; i++) {
            int k = after(c->s, w, i), before = link_at(c, i), next = link_at(c, after(c->s, w, k));
            if (link_at(c, k) != link)
                continue;
            beside[before] |= 1u << next;
            beside[next] |= 1u << before;
            all |= 1u << next | 1u << before;
            atom_here = k;
        }
    for (seen = front = all & -all; front; seen |= front) {
        uint32_t reached = 0;
        for (; front; front &= front - 1)
            reached |= beside[__builtin_ctz(front)];
        front = reached & ~seen;
    }
    return seen == all ? LW_OK
                       : fault(c, word_of(c->s, atom_here), atom_here, "the regions around part %d "
                               "do not follow each other in one ring", link + 1);
}

/* Check Euler's v - e + a = 2 (Makkonen 1999, eq. 6), and that every joint is a side of two regions. */
static lw_status check_regions(const check *c)
{
    for (int j = 0; j < c->m.n_joint; j++) {
        int a = c->m.link[j][0], b = c->m.link[j][1], atom = c->atom[a][b] - 1;
        if (c->sides[a][b] != 2)
            return fault(c, word_of(c->s, atom), atom, "the joint of parts %d and %d is a side of %d "
                         "word%s; each joint separates two regions (a list of circuits begins with "
                         "the atom basis)", a + 1, b + 1, c->sides[a][b],
                         c->sides[a][b] == 1 ? " only" : "s");
    }
    int want = c->m.n_joint - c->m.n_link + 2;
    if (c->s->n_word != want)
        return fault(c, 0, LW_NONE, "%d parts and %d joints in the plane make %d regions, but there "
                     "are %d words", c->m.n_link, c->m.n_joint, want, c->s->n_word);
    for (int i = 0; i < c->m.n_link; i++) {
        lw_status s = check_ring(c, i);
        if (s != LW_OK)
            return s;
    }
    return LW_OK;
}

/* The joints of a circuit as bits. */
static lw_status circuit_edges(const check *c, int w, uint64_t *edges)
{
    uint32_t seen = 0;
    *edges = 0;
    for (int i = c->s->first[w]; i < c->s->first[w + 1]; i++) {
        int a = link_at(c, i), b = link_at(c, after(c->s, w, i));
        if (seen >> a & 1)
            return fault(c, w, i, "a circuit passes part %d once, not twice", a + 1);
        seen |= 1u << a;
        *edges |= (uint64_t)1 << lw_mechanism_joint(&c->m, a, b);
    }
    return LW_OK;
}

static lw_status check_basis(const check *c)
{
    uint64_t rows[LW_WORD_MAX], edges;
    int n_row = 0, loops = c->m.n_joint - c->m.n_link + 1;
    for (int w = 0; w < c->s->n_word; w++) {
        int i = c->s->first[w];
        if (c->s->first[w + 1] - i == 2) {
            if (c->sides[link_at(c, i)][link_at(c, i + 1)] != 2)
                return fault(c, w, i, "a word of two parts is a bridge joint, which stands in no other word");
            continue;
        }
        lw_status s = circuit_edges(c, w, &edges);
        if (s != LW_OK)
            return s;
        if (!lw_gf2_add(rows, &n_row, edges))
            return fault(c, w, LW_NONE, "this circuit follows from those before it");
    }
    if (n_row != loops)
        return fault(c, 0, LW_NONE, "the chain has %d independent circuits, the sentence %d", loops, n_row);
    return LW_OK;
}

static lw_status check_sentence(const lw_sentence *s, const places *where, lw_mechanism *m, lw_error *e)
{
    check *c = calloc(1, sizeof *c);
    if (!c)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    *c = (check){ .s = s, .where = where, .e = e };
    lw_status status = check_joints(c);
    if (status == LW_OK)
        status = collect(c);
    if (status == LW_OK)
        status = s->basis ? check_basis(c) : check_regions(c);
    if (status == LW_OK && m)
        *m = c->m;
    free(c);
    return status;
}

lw_status lw_sentence_mechanism(const lw_sentence *s, lw_mechanism *m, lw_error *e)
{
    return check_sentence(s, NULL, m, e);
}

/* One part and the joint after it. */
static lw_status read_atoms(lw_cursor *c, lw_sentence *s, int at, const lw_cursor *word)
{
    int part;
    char name[24];
    if (lw_cursor_peek(c) < 0 || lw_cursor_peek(c) == '(')
        return lw_cursor_fail(word, "this word is not closed: a ')' is missing");
    if (at == LW_ATOM_MAX)
        return lw_cursor_fail(c, "the sentence is too long: at most %d parts in all words", LW_ATOM_MAX);
    if (!lw_cursor_number(c, &part))
        return lw_cursor_fail(c, "%s where a part number was expected", lw_byte_name(lw_cursor_peek(c), name));
    s->part[at] = (uint8_t)(part > LW_LINK_MAX ? 0 : part);
    lw_cursor_skip(c, true, ';');
    int byte = lw_cursor_peek(c);
    if (byte == ')')
        return lw_cursor_fail(c, "a joint letter is missing between part %d and the first part of the word", part);
    if (byte < 0 || byte == '(')
        return lw_cursor_fail(word, "this word is not closed: a ')' is missing");
    if (byte > 127 || !lw_joint_freedoms((char)byte))
        return lw_cursor_fail(c, "%s is no joint letter; a joint is r (pin), t (slider), p (pin in "
                              "slot) or g (gear or cam)", lw_byte_name(byte, name));
    s->joint[at] = (char)lw_cursor_next(c);
    return LW_OK;
}

static lw_status read_word(lw_cursor *c, lw_sentence *s, places *where)
{
    lw_cursor open = *c;
    int at = s->first[s->n_word];
    if (s->n_word == LW_WORD_MAX)
        return lw_cursor_fail(c, "more than %d words", LW_WORD_MAX);
    where->word[s->n_word] = open;
    lw_cursor_next(c);
    for (lw_cursor_skip(c, true, ';'); lw_cursor_peek(c) != ')'; lw_cursor_skip(c, true, ';')) {
        if (at < LW_ATOM_MAX)
            where->part[at] = *c;
        lw_status status = read_atoms(c, s, at, &open);
        if (status != LW_OK)
            return status;
        at++;
    }
    if (at == s->first[s->n_word])
        return lw_cursor_fail(&open, "this word is empty");
    lw_cursor_next(c);
    s->first[++s->n_word] = at;
    return LW_OK;
}

/* "(", perhaps "basis". */
static lw_status read_opening(lw_cursor *c, lw_sentence *s)
{
    char name[24];
    lw_cursor_skip(c, true, ';');
    if (lw_cursor_peek(c) != '(')
        return lw_cursor_fail(c, "a sentence begins with '(', not %s", lw_byte_name(lw_cursor_peek(c), name));
    lw_cursor_next(c);
    lw_cursor_skip(c, true, ';');
    if (lw_cursor_begins(c, "basis")) {
        lw_cursor_step(c, 5);
        s->basis = true;
    }
    return LW_OK;
}

static lw_status read_tokens(lw_cursor *c, lw_sentence *s, places *where)
{
    char name[24];
    lw_cursor_skip(c, true, ';');
    lw_cursor open = *c;
    lw_status status = read_opening(c, s);
    for (;;) {
        if (status != LW_OK)
            return status;
        lw_cursor_skip(c, true, ';');
        int byte = lw_cursor_peek(c);
        if (byte == ')')
            break;
        if (byte < 0)
            return lw_cursor_fail(&open, "this sentence is not closed: a ')' is missing");
        if (byte != '(')
            return lw_cursor_fail(c, "%s where a word, which begins with '(', was expected", lw_byte_name(byte, name));
        status = read_word(c, s, where);
    }
    lw_cursor_next(c);
    if (s->n_word == 0)
        return lw_cursor_fail(&open, "the sentence has no word");
    lw_cursor_skip(c, true, ';');
    if (lw_cursor_peek(c) >= 0)
        return lw_cursor_fail(c, "%s stands after the end of the sentence", lw_byte_name(lw_cursor_peek(c), name));
    return LW_OK;
}

lw_status lw_sentence_read(const char *text, size_t size, const char *file, lw_sentence *s, lw_error *e)
{
    lw_cursor c = lw_cursor_start(text, size, file, e);
    lw_sentence *out = calloc(1, sizeof *out);
    places *where = malloc(sizeof *where);
    lw_status status = LW_E_MEMORY;
    if (!out || !where)
        lw_error_set(e, LW_E_MEMORY, "out of memory");
    else
        status = read_tokens(&c, out, where);
    if (status == LW_OK)
        status = check_sentence(out, where, NULL, e);
    if (status == LW_OK)
        *s = *out;
    free(where);
    free(out);
    return status;
}
