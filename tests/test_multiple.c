/* Multiple joints against catalogues/data/published-counts.csv (two methods there) and a count over all sets of
 * links. */
#include "check.h"
#include "enumerate/multiple.h"

typedef struct found { int n, dof; char kinds[64][16]; int n_of[64], n_kind; lw_rng *rng; } found;

/* All sets of links by the definition. */
static bool rigid_by_count(const lw_multiple *m)
{
    for (uint32_t s = 1; s < 1u << m->n_link; s++) {
        int f = 3*(__builtin_popcount(s) - 1);
        for (int k = 0; k < m->n_pin; k++)
            f -= m->pin[k] & s ? 2*(__builtin_popcount(m->pin[k] & s) - 1) : 0;
        if ((s & (s - 1)) && f <= 0)
            return true;
    }
    return false;
}

static void check_form(const lw_multiple *m, lw_rng *rng)
{
    lw_multiple shuffled = { .n_link = m->n_link, .n_pin = m->n_pin }, a, b;
    uint8_t to[LW_LINK_MAX];
    for (int i = 0; i < m->n_link; i++) {
        int k = (int)lw_rng_range(rng, 0, i + 1);
        to[i] = to[k];
        to[k] = (uint8_t)i;
    }
    for (int k = 0; k < m->n_pin; k++)
        for (uint32_t s = m->pin[k]; s; s &= s - 1)
            shuffled.pin[m->n_pin - 1 - k] |= 1u << to[__builtin_ctz(s)];
    CHECK_INT(lw_multiple_canonical(m, &a), LW_OK);
    CHECK_INT(lw_multiple_canonical(&shuffled, &b), LW_OK);
    CHECK(!memcmp(&a, &b, sizeof a));
    CHECK(lw_multiple_moves(&b));
    char text[LW_MULTIPLE_SIZE];
    uint8_t lowest[2][LW_LINK_MAX];
    uint64_t order[2];
    size_t n = lw_multiple_print(m, text, sizeof text);
    CHECK_INT(lw_multiple_read(text, n, NULL, &a, NULL), LW_OK);
    CHECK(!memcmp(&a, m, sizeof a));
    CHECK_INT(lw_multiple_symmetry(m, lowest[0], &order[0]), LW_OK);
    CHECK_INT(lw_multiple_symmetry(&shuffled, lowest[1], &order[1]), LW_OK);
    CHECK(order[0] == order[1]);
    for (int i = 0; i < m->n_link; i++)                            /* the same orbits, under other numbers */
        for (int k = 0; k < i; k++)
            CHECK((lowest[0][i] == lowest[0][k]) == (lowest[1][to[i]] == lowest[1][to[k]]));
}

/* F, where a pin counts as the number of its links minus one. */
static int mobility(const lw_multiple *m)
{
    int f = 3*(m->n_link - 1);
    for (int k = 0; k < m->n_pin; k++)
        f -= 2*(__builtin_popcount(m->pin[k]) - 1);
    return f;
}

/* "{2 2}" of the data: multiplicities of the multiple pins, rising, as digits "22". */
static lw_status note(void *context, const lw_multiple *m)
{
    found *f = context;
    char kind[16] = "";
    int n = 0, k = 0;
    CHECK_INT(mobility(m), f->dof);
    CHECK(!rigid_by_count(m));
    check_form(m, f->rng);
    for (int i = m->n_pin - 1; i >= 0; i--)
        if (__builtin_popcount(m->pin[i]) > 2)
            kind[n++] = (char)('0' + __builtin_popcount(m->pin[i]) - 1);
    while (k < f->n_kind && strcmp(f->kinds[k], kind) != 0)
        k++;
    if (k == f->n_kind)
        strcpy(f->kinds[f->n_kind++], kind);
    f->n_of[k]++;
    f->n++;
    return LW_OK;
}

static int number_of(const found *f, const char *kind)
{
    for (int k = 0; k < f->n_kind; k++)
        if (!strcmp(f->kinds[k], kind))
            return f->n_of[k];
    return 0;
}

static found list(int n_link, int dof, lw_rng *rng)
{
    found f = { .dof = dof, .rng = rng };
    CHECK_INT(lw_multiple_each(n_link, dof, 1, note, &f, NULL), LW_OK);
    return f;
}

TEST(published)
{
    static const struct { int n_link, dof; const char *kind; int n; } known[] = {
        { 6, 1, "2", 1 }, { 6, 1, "22", 1 }, { 8, 1, "2", 20 }, { 8, 1, "22", 16 }, { 8, 1, "222", 3 },
        { 8, 1, "2222", 1 }, { 8, 1, "23", 1 }, { 8, 1, "3", 2 }, { 8, 1, "33", 1 }, { 7, 2, "2", 3 },
        { 7, 2, "22", 2 },
    };
    static const struct { int n_link, dof, n; } total[] = {
        { 4, 1, 0 }, { 6, 1, 2 }, { 8, 1, 44 }, { 5, 2, 0 }, { 7, 2, 5 },
    };
    lw_rng rng = check_rng(1);
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        found f = list(known[i].n_link, known[i].dof, &rng);
        CHECK_INT(number_of(&f, known[i].kind), known[i].n);
    }
    for (size_t i = 0; i < sizeof total/sizeof *total; i++)
        CHECK_INT(list(total[i].n_link, total[i].dof, &rng).n, total[i].n);
}

TEST(what_is_refused)
{
    static const struct { const char *text, *says; long column; } bad[] = {
        { "", "no pin", 1 }, { "1-2 2-3 x", "link number", 9 }, { "1-2 3", "two links or more", 5 }, { "1-2-1", "twice", 5 },
        { "1-2-3 2-1", "on one pin already", 7 }, { "1-2 2-4", "no link 3", 1 }, { "1-99", "1 to 32", 3 },
        { "1-2:t", "'-' or a blank", 4 }, { "1-2\n1-3", "one line", 1 }, { "0-1", "1 to 32", 1 },
    };
    lw_multiple m = { .n_link = 77 };
    lw_error e;
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        CHECK_INT(lw_multiple_read(bad[i].text, strlen(bad[i].text), "f", &m, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, bad[i].says);
        CHECK_INT(e.column, bad[i].column);
        CHECK_INT(m.n_link, 77);
    }
}

/* Fractionated chains against all sets of pins: any two share at most one link, every link has two pins or more, all
 * hangs together, no set of links is rigid, and some link or pin separates the rest. */
typedef struct brute { int n_link, n_form; lw_multiple form[256]; lw_multiple m; uint32_t pin[256]; int n_pin; } brute;

static bool joined(const lw_multiple *m, uint32_t without, int lost)
{
    uint32_t all = ((1u << m->n_link) - 1) & ~without, seen = all & -all, before;
    do {
        before = seen;
        for (int k = 0; k < m->n_pin; k++)
            seen |= k != lost && m->pin[k] & seen ? m->pin[k] & all : 0;
    } while (seen != before);
    return seen == all;
}

static void look_at(brute *b)
{
    lw_multiple form;
    bool multiple = false, whole = true;
    if (!joined(&b->m, 0, LW_NONE) || rigid_by_count(&b->m))
        return;
    for (int k = 0; k < b->m.n_pin; k++) {
        multiple = multiple || __builtin_popcount(b->m.pin[k]) > 2;
        whole = whole && joined(&b->m, 0, k);
    }
    for (int i = 0; i < b->n_link; i++)
        whole = whole && joined(&b->m, 1u << i, LW_NONE);
    if (!multiple || whole || lw_multiple_canonical(&b->m, &form) != LW_OK)
        return;
    for (int i = 0; i < b->n_form; i++)
        if (!memcmp(&b->form[i], &form, sizeof form))
            return;
    CHECK(b->n_form < 256);
    b->form[b->n_form++] = form;
}

static void choose_pins(brute *b, int from, int joints, const int *n_pin)
{
    if (joints == 0) {
        for (int i = 0; i < b->n_link; i++)
            if (n_pin[i] < 2)
                return;
        look_at(b);
        return;
    }
    for (int k = from; k < b->n_pin; k++) {
        int size = __builtin_popcount(b->pin[k]), count[LW_LINK_MAX];
        bool fits = size - 1 <= joints;
        if (b->m.n_pin == 0)                                /* the first pin is multiple, of the lowest links */
            fits = fits && size > 2 && b->pin[k] == (1u << size) - 1;
        for (int l = 0; fits && l < b->m.n_pin; l++)
            fits = __builtin_popcount(b->m.pin[l] & b->pin[k]) < 2;
        if (!fits)
            continue;
        for (int i = 0; i < b->n_link; i++)
            count[i] = n_pin[i] + (b->pin[k] >> i & 1);
        b->m.pin[b->m.n_pin++] = b->pin[k];
        choose_pins(b, k + 1, joints - size + 1, count);
        b->m.pin[--b->m.n_pin] = 0;
    }
}

static lw_status count_one(void *context, const lw_multiple *m)
{
    CHECK(!lw_multiple_moves(m));                           /* it separates */
    CHECK(!rigid_by_count(m));
    ++*(int *)context;
    return LW_OK;
}

TEST(fractionated)
{
    static const struct { int n_link, dof; } known[] = { { 7, 2 }, { 8, 1 }, { 8, 3 } };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        FREED brute *b = calloc(1, sizeof *b);
        int n = 0, none[LW_LINK_MAX] = { 0 };
        b->n_link = b->m.n_link = known[i].n_link;
        for (int size = b->n_link; size >= 2; size--)       /* large pins first, as in lw_multiple */
            for (uint32_t p = 0; p < 1u << b->n_link; p++)
                if (__builtin_popcount(p) == size)
                    b->pin[b->n_pin++] = p;
        choose_pins(b, 0, (3*(b->n_link - 1) - known[i].dof)/2, none);
        CHECK_INT(lw_multiple_fractionated_each(known[i].n_link, known[i].dof, 1, count_one, &n, NULL), LW_OK);
        CHECK_INT(n, b->n_form);
        CHECK((n > 0) == (known[i].dof == 3));              /* two four-bars on one pin, for example */
    }
}

TEST(what_moves)
{
    /* Watt's chain with a multiple pin 1-2-5 moves; with two pins shared by links 1 and 2 it does not */
    lw_multiple watt = { 6, 6, { 19, 6, 12, 9, 48, 40 } }, twice = watt, loose = watt;
    char text[100];
    CHECK_INT(mobility(&watt), 1);
    CHECK(lw_multiple_moves(&watt));
    lw_multiple_print(&watt, text, sizeof text);
    CHECK_TEXT(text, "1-2-5 2-3 3-4 1-4 5-6 4-6");
    twice.pin[1] = 3;
    CHECK(!lw_multiple_moves(&twice));
    loose.n_pin = 5;                                        /* link 6 hangs at one pin */
    CHECK(!lw_multiple_moves(&loose));
    lw_multiple rings = { 8, 7, { 0x33, 0x06, 0x0c, 0x09, 0x60, 0xc0, 0x90 } };
    CHECK_INT(mobility(&rings), 3);
    CHECK(!lw_multiple_moves(&rings));                      /* falls apart at the pin */
}

TEST(refusals)
{
    lw_error e = { 0 };
    CHECK_INT(lw_multiple_each(7, 1, 1, note, NULL, &e), LW_E_ARG);
    CHECK(e.text[0] != '\0');
}
