/* bench_mechanisms.c - from chains to mechanisms: how many of each step go through a core in a second.
 * Processor seconds of one thread, the best of three. */
#include <stdio.h>
#include "base/clock.h"
#include "enumerate/assur.h"
#include "enumerate/derive.h"
#include "enumerate/higher.h"
#include "enumerate/mechanisms.h"
#include "enumerate/multiple.h"
#include "grammar/topology/notation.h"

/* What one row does; returns how many went through. */
typedef struct tally { uint64_t n; lw_mechanism_steps steps; } tally;

static lw_status count_one(void *context, const lw_mechanism *m)
{
    (void)m;
    ((tally *)context)->n++;
    return LW_OK;
}

static lw_status take_steps(void *context, const lw_chain_item *item)
{
    tally *t = context;
    lw_mechanism m;
    lw_mechanism_counts counts = { 0 };
    lw_status s = lw_mechanism_from_chain(item->chain, &m);
    return s == LW_OK ? lw_mechanisms_each(&m, &t->steps, &counts, count_one, NULL, t) : s;
}

static lw_status decompose(void *context, const lw_mechanism *m)
{
    lw_assur a;
    ((tally *)context)->n++;
    return lw_assur_decompose(m, &a, NULL);
}

static lw_status solve_order(void *context, const lw_chain_item *item)
{
    tally *t = context;
    lw_mechanism m;
    lw_mechanism_counts counts = { 0 };
    lw_status s = lw_mechanism_from_chain(item->chain, &m);
    return s == LW_OK ? lw_mechanisms_each(&m, &t->steps, &counts, decompose, NULL, t) : s;
}

static lw_status say_again(void *context, const lw_chain_item *item)
{
    static char text[LW_NOTATION_SIZE];
    const lw_notation *n = lw_notation_find("sentence");
    lw_mechanism m, back;
    size_t length;
    lw_status s = lw_mechanism_from_chain(item->chain, &m);
    if (s == LW_OK)
        s = n->print(&m, text, sizeof text, &length);
    ((tally *)context)->n++;
    return s == LW_OK ? n->read(text, length, NULL, &back, NULL) : s;
}

static lw_status count_multiple(void *context, const lw_multiple *m)
{
    (void)m;
    ((tally *)context)->n++;
    return LW_OK;
}

static lw_status count_higher(void *context, const lw_chain *c)
{
    (void)c;
    ((tally *)context)->n++;
    return LW_OK;
}

static uint64_t walk(int n_link, lw_mechanism_steps steps, lw_chain_visit *visit)
{
    tally t = { .steps = steps };
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    how.n_thread = 1;
    if (lw_chains_create(n_link, 1, 1, &chains, NULL) != LW_OK)
        return 0;
    (void)lw_chains_each(chains, &how, visit, &t);
    lw_chains_free(chains);
    return t.n;
}

static uint64_t grounds(void) { return walk(12, (lw_mechanism_steps){ .ground = true }, take_steps); }
static uint64_t kinds(void) { return walk(8, (lw_mechanism_steps){ .kinds = "rt" }, take_steps); }
static uint64_t inputs(void)
{
    return walk(10, (lw_mechanism_steps){ .ground = true, .input = LW_INPUT_ANY, .output = true }, take_steps);
}
static uint64_t assur(void)
{
    return walk(10, (lw_mechanism_steps){ .ground = true, .input = LW_INPUT_GROUND }, solve_order);
}
static uint64_t sentences(void) { return walk(12, (lw_mechanism_steps){ 0 }, say_again); }

static uint64_t coverage(void)
{
    lw_coverage c;
    return lw_coverage_count(12, 1, NULL, &c, NULL) == LW_OK ? c.n_chain : 0;
}

static uint64_t multiple(void)
{
    tally t = { 0 };
    (void)lw_multiple_each(10, 1, 1, count_multiple, &t, NULL);
    return t.n;
}

static uint64_t higher(void)
{
    tally t = { 0 };
    (void)lw_higher_each(9, 1, 3, 1, count_higher, &t, NULL);
    return t.n;
}

int main(void)
{
    static const struct { const char *what; uint64_t (*run)(void); } row[] = {
        { "ground links of 12-link chains", grounds },
        { "labellings r, t of 8-link chains", kinds },
        { "ground, any input, output of 10-link chains", inputs },
        { "Assur groups of 10-link mechanisms", assur },
        { "sentences of 12-link chains, said and read", sentences },
        { "derivations of 12-link chains", coverage },
        { "10-link chains with multiple joints", multiple },
        { "9-link chains with 3 joints of two freedoms", higher },
    };
    printf("# mechanisms: one thread, best of three\n%-46s %10s %10s %12s\n", "what", "number", "seconds", "a second");
    for (size_t i = 0; i < sizeof row/sizeof *row; i++) {
        double best = 1e9;
        uint64_t n = 0;
        for (int trial = 0; trial < 3; trial++) {
            double start = lw_clock_cpu();
            n = row[i].run();
            double took = lw_clock_cpu() - start;
            best = took < best ? took : best;
        }
        printf("%-46s %10llu %10.3f %12.0f\n", row[i].what, (unsigned long long)n, best, (double)n/best);
        fflush(stdout);
    }
    return 0;
}
