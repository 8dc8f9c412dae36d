/* linkwright chains - list every kinematic chain with P links and F degrees of freedom once. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/file.h"
#include "base/number.h"
#include "base/parallel.h"
#include "base/suggest.h"
#include "cli/program/json.h"
#include "cli/program/mpi_jobs.h"
#include "cli/program/output.h"
#include "cli/program/progress.h"
#include "cli/program/resume.h"
#include "cli/program/topology.h"
#include "enumerate/canon.h"
#include "enumerate/chains.h"
#include "enumerate/estimate.h"
#include "enumerate/fractionated.h"
#include "enumerate/kept.h"
#include "enumerate/labelled.h"
#include "grammar/topology/graph6.h"

typedef struct settings {
    int         links, dof, format, by;
    bool        count, planar, non_planar, fractionated, resume, mpi;
    const char *part, *filter, *keep, *structures;
} settings;

static const cli_option options[] = {
    { "links", 'l', CLI_INT, offsetof(settings, links), "P", NULL, "number of links", 3, LW_LINK_MAX, NULL, NULL },
    { "dof", 'd', CLI_INT, offsetof(settings, dof), "F", "1",
      "degree of freedom; 0 gives rigid chains (Baranov trusses)", 0, LW_DOF_MAX, NULL, NULL },
    { "count", 'c', CLI_FLAG, offsetof(settings, count), NULL, NULL, "print only the number of chains", 0, 0, NULL, NULL },
    { "by", 0, CLI_CHOICE, offsetof(settings, by), "total|assortment", "total",
      "one number, or one for each assortment (numbers of binary, ternary, ... links)", 0, 0, "count", NULL },
    { "format", 'f', CLI_CHOICE, offsetof(settings, format),
      "graph6|lam|sentence|franke|edges|json|dot|graphml", "graph6", "how a chain is written", 0, 0, NULL, "count" },
    { "fractionated", 0, CLI_FLAG, offsetof(settings, fractionated), NULL, NULL,
      "also list chains that separate into two at a link or a joint, after the others", 0, 0, NULL, NULL },
    { "planar", 0, CLI_FLAG, offsetof(settings, planar), NULL, NULL, "only chains with a planar graph", 0, 0, NULL, "non-planar" },
    { "non-planar", 0, CLI_FLAG, offsetof(settings, non_planar), NULL, NULL, "only chains with a non-planar graph", 0, 0, NULL, "filter" },
    { "filter", 0, CLI_TEXT, offsetof(settings, filter), "NAME", NULL,
      "only certain chains: planar, non-planar, asymmetric, or no-dyad (no two binary links in a row); every, "
      "distinct: all, but --count lists them one by one (distinct: and compares them), as a second count; generating: "
      "all, but --count makes only those with symmetries and takes the rest from generating functions",
      0, 0, NULL, "planar" },
    { "part", 0, CLI_TEXT, offsetof(settings, part), "R/M", NULL,
      "compute part R of M (R = 1 .. M); the parts have no chain in common and together are complete", 0, 0, NULL, NULL },
    { "resume", 0, CLI_FLAG, offsetof(settings, resume), NULL, NULL, "continue the listing in -o FILE that was interrupted", 0, 0, NULL, "count" },
    { "keep", 0, CLI_INPUT, offsetof(settings, keep), "FILE", NULL,
      "count in parts, keep the numbers of each part in FILE, and leave out the parts that FILE holds already", 0, 0, "count", NULL },
    { "structures", 0, CLI_STORE, offsetof(settings, structures), "FILE", NULL,
      "read the structures from FILE; if there is no such file, write it", 0, 0, NULL, NULL },
    { "mpi", 0, CLI_FLAG, offsetof(settings, mpi), NULL, NULL,
      "share the work among all processes that mpirun started; process 0 writes", 0, 0, NULL, "part" },
    { .name = NULL }
};

/* Data of one run. */
typedef struct task {
    const cli_call         *call;
    const settings         *s;
    const lw_notation      *notation;
    lw_chains              *chains;
    lw_chain_walk           how;
    lw_output               out;
    uint64_t                n_listed, skip_fractionated;
    double                  start, expected;              /* wall time; expected number of chains */
    cli_progress            progress;
    uint64_t                n_fractionated, n_bridged, at; /* `at` is the index over all parts     */
    cli_resume              before;                       /* an interrupted listing that is continued */
    bool                    compared;                     /* its last line was compared            */
    lw_chain_table          table;
    lw_kept                *kept;                         /* of --keep                             */
    lw_error               *e;
    int                     n_loop;
    size_t                  n_task, first;                /* under mpirun; tasks before `first` are done */
    bool                    served;                       /* the other processes have been served  */
} task;

/* Is the excess over the labelled chains counted, which generating functions give? */
static bool generating(const task *t) { return t->how.filter && strcmp(t->how.filter->name, "generating") == 0; }

static bool go_on(void *context)
{
    const task *t = context;
    double limit = t->call->common.time;
    return !cli_interrupted() && (limit <= 0 || lw_clock_wall() - t->start < limit);
}

static bool tick(void *context, double done)
{
    task *t = context;
    cli_progress_show(&t->progress, done*t->expected, t->expected, NULL);
    return go_on(t);
}

static bool tick_structures(void *context, int loops, size_t found)
{
    task *t = context;
    (void)loops;
    cli_progress_show(&t->progress, (double)found, 0, NULL);
    return go_on(t);
}

static int unknown_filter(const cli_call *call, const char *name)
{
    int n = 0;
    while (lw_filters[n].name)
        n++;
    const char *near = LW_SUGGEST(name, lw_filters, n, name);
    return cli_usage(call, "there is no filter '%s'%s%s%s", name, near ? "; did you mean '" : "", near ? near : "", near ? "'?" : "");
}

/* Read the settings that are more than a number. CLI_DONE: they are valid. */
static int read_settings(task *t)
{
    const settings *s = t->s;
    const char *filter = s->planar ? "planar" : s->non_planar ? "non-planar" : s->filter;
    t->how = lw_chain_walk_default();
    t->how.n_thread = t->call->common.jobs;
    t->how.tick = tick;
    t->how.tick_context = t;
    t->notation = t->call->common.json ? lw_notation_find("json") : &lw_notations[s->format];
    if (!cli_given(&t->call->parsed, "links"))
        return cli_usage(t->call, "how many links? give --links P");
    int code = s->part ? cli_read_part(t->call, s->part, &t->how.part, &t->how.n_part) : CLI_DONE;
    if (code != CLI_DONE)
        return code;
    if (filter && !(t->how.filter = lw_filter_find(filter)))
        return unknown_filter(t->call, filter);
    if (s->count && generating(t) && s->part && !s->keep)
        return cli_usage(t->call, "--filter generating counts nothing from a part alone; give --keep FILE");
    if (s->mpi && (code = cli_mpi_check(t->call)) != CLI_DONE)
        return code;
    if (s->resume && (!t->call->common.output || strcmp(t->call->common.output, "-") == 0))
        return cli_usage(t->call, "--resume needs -o FILE, the listing to continue");
    if (s->resume && t->notation->lines)
        return cli_usage(t->call, "--resume works with notations of one line a chain, not with %s", t->notation->name);
    return CLI_DONE;
}

/* Parts of a kept count that this run adds up: those in the file, and all. */
static int wanted_parts(const task *t, int *n_there)
{
    const lw_kept_head *h = t->kept ? lw_kept_head_of(t->kept) : NULL;
    *n_there = h ? lw_kept_count(t->kept, t->how.part, t->how.n_part) : 0;
    return h && h->n_part > t->how.part ? (h->n_part - t->how.part + t->how.n_part - 1)/t->how.n_part : h ? 0 : 1;
}

static bool kept_complete(const task *t)
{
    int n_there, n = wanted_parts(t, &n_there);
    return n_there == n;
}

/* Seconds of one core to write one chain; the rows of lw_notations.  Measured with 14 links (graph6: with 16) and an -O3
 * build: processor time of the listing less that of --count --filter every. */
static const double write_seconds[] = { 0.08e-6, 11e-6, 14e-6, 2.6e-6, 2.5e-6, 3e-6, 3.2e-6, 7.7e-6 };

/* Seconds of one core for the chains, after the structures. */
static double work_seconds(const task *t, const lw_estimate *e)
{
    const lw_filter *f = t->how.filter;
    if (t->s->count && (!f || f->structure))
        return generating(t) ? 0.3*e->count_seconds : e->count_seconds;
    double test = !f || f->structure ? 0 : strcmp(f->name, "asymmetric") == 0 ? 5e-6
                : strcmp(f->name, "distinct") == 0 ? 0.45e-6 : 0.05e-6;
    return e->list_seconds + e->chains*(test + (t->s->count ? 0 : write_seconds[t->notation - lw_notations]));
}

/* Report size and expected time before a large run starts. LW_E_MEMORY: it cannot fit. */
static lw_status say_how_long(task *t, lw_error *error)
{
    lw_estimate e;
    lw_numbers n;
    lw_status status = lw_numbers_for_links(t->s->links, t->s->dof, 0, &n, error);
    if (status != LW_OK || n.n_loop < 6 || kept_complete(t))
        return status;
    int n_there, n_wanted = wanted_parts(t, &n_there);
    status = lw_chains_estimate_while(n.n_link, n.dof, go_on, t, &e, error);
    if (status != LW_OK)
        return status == LW_STOPPED ? LW_OK : status;            /* the work itself stops too, and says so */
    int cores = t->how.n_thread < 1 ? lw_core_count() : t->how.n_thread;
    double work = work_seconds(t, &e)*(n_wanted - n_there)/n_wanted/t->how.n_part;
    bool stored = t->s->structures && access(t->s->structures, R_OK) == 0;
    if (stored)
        e.bytes = 16*e.structures;
    double seconds = ((stored ? 0 : e.structure_seconds) + work)/cores;
    t->expected = e.chains/t->how.n_part;
    if (seconds > 5)
        cli_note(t->call, "about %.2g structures and %.2g chains, %.2g s on %d core%s, %.2g MB", e.structures,
                 t->expected, seconds, cores, lw_plural(cores), e.bytes/1e6);
    if (e.bytes > cli_memory(t->call))
        return lw_error_set(error, LW_E_MEMORY, "the structures with %d loops need about %.2g GB", n.n_loop, e.bytes/1e9);
    return LW_OK;
}

/* ---- counting ------------------------------------------------------------------------------------- */

/* Is this fractionated chain in our part of the work, and does it pass the filter? */
static lw_status ask_wanted(task *t, const lw_chain *c, bool *wanted)
{
    *wanted = t->at++ % (uint64_t)t->how.n_part == (uint64_t)t->how.part;
    return *wanted && t->how.filter ? t->how.filter->chain(c, wanted) : LW_OK;
}

static lw_status count_fractionated(void *context, const lw_chain *c, int n_bridge)
{
    task *t = context;
    bool wanted;
    lw_status asked = ask_wanted(t, c, &wanted);
    if (asked != LW_OK || !wanted)
        return asked;
    t->n_fractionated++;
    t->n_bridged += n_bridge > 0;
    return t->n_fractionated % 256 || tick(t, 1) ? LW_OK : LW_STOPPED;
}

static void write_json(task *t, const lw_chain_table *table)
{
    int n_loop = t->n_loop;
    cli_json j = cli_json_begin(t->out.f, 0);
    cli_json_object(&j, NULL);
    cli_json_int(&j, "links", t->s->links);
    cli_json_int(&j, "dof", t->s->dof);
    if (t->kept) {
        cli_json_int(&j, "parts", lw_kept_head_of(t->kept)->n_part);
        cli_json_int(&j, "parts_counted", lw_kept_count(t->kept, t->how.part, t->how.n_part));
        cli_json_seed(&j, "structures", lw_kept_head_of(t->kept)->n_structure);
    }
    cli_json_seed(&j, "chains", table->total.n_chain);
    if (!generating(t))
        cli_json_seed(&j, "ground_links", table->total.n_ground);
    if (t->s->fractionated) {
        cli_json_seed(&j, "fractionated", t->n_fractionated);
        cli_json_seed(&j, "with_bridge", t->n_bridged);
    }
    if (t->s->by) {
        cli_json_array(&j, "assortments");
        for (size_t k = 0; k < table->n_row; k++) {
            cli_json_object(&j, NULL);
            cli_json_array(&j, "links_with_2_3_joints");
            for (int i = 2; i <= n_loop + 1; i++)
                cli_json_int(&j, NULL, table->row[k].links.n_with[i]);
            cli_json_end(&j);
            cli_json_seed(&j, "chains", table->row[k].n.n_chain);
            if (!generating(t))
                cli_json_seed(&j, "ground_links", table->row[k].n.n_ground);
            cli_json_end(&j);
        }
        cli_json_end(&j);
    }
    cli_json_end(&j);
}

static void write_table(task *t, const lw_chain_table *table)
{
    int n_loop = t->n_loop;
    char head[16];
    fputc('#', t->out.f);
    for (int i = 2; i <= n_loop + 1; i++) {
        snprintf(head, sizeof head, "P%d", i);
        fprintf(t->out.f, i == 2 ? "%2s" : "%4s", head);
    }
    fprintf(t->out.f, generating(t) ? "%16s\n" : "%16s%20s\n", "chains", "ground links");
    for (size_t k = 0; k < table->n_row; k++) {
        for (int i = 2; i <= n_loop + 1; i++)
            fprintf(t->out.f, i == 2 ? "%3d" : "%4d", table->row[k].links.n_with[i]);
        fprintf(t->out.f, generating(t) ? "%16llu\n" : "%16llu%20llu\n", (unsigned long long)table->row[k].n.n_chain,
                (unsigned long long)table->row[k].n.n_ground);
    }
}

static void write_counts(task *t, const lw_chain_table *table)
{
    unsigned long long n = table->total.n_chain, m = t->n_fractionated, bridged = t->n_bridged;
    if (t->call->common.json) {
        write_json(t, table);
        return;
    }
    if (t->s->by)
        write_table(t, table);
    if (t->s->fractionated)
        fprintf(t->out.f, "%llu not fractionated\n%llu fractionated, %llu of them with a bridge joint\n%llu in all\n",
                n,
                m, bridged, n + m);
    else
        fprintf(t->out.f, "%llu\n", n);
}

/* Under mpirun a task is a part of the work; its answer is the numbers in the rows of the table. */
static lw_status work_count(void *context, size_t k, lw_bytes *answer)
{
    task *t = context;
    lw_chain_walk how = t->how;
    lw_chain_table table = { .n_row = 0 };
    how.part = (int)k;
    how.n_part = (int)t->n_task;
    how.n_thread = 1;
    how.tick = NULL;
    lw_status status = lw_chains_count(t->chains, &how, &table);
    for (size_t i = 0; i < table.n_row; i++)
        lw_bytes_add(answer, &table.row[i].n, sizeof table.row[i].n);
    lw_chain_table_free(&table);
    return status;
}

static lw_status add_row(lw_chain_table *table, size_t i, const lw_tally *n)
{
    lw_status status = lw_tally_add(&table->row[i].n, n);
    return status == LW_OK ? lw_tally_add(&table->total, n) : status;
}

static void clear_rows(lw_chain_table *table)
{
    for (size_t i = 0; i < table->n_row; i++)
        table->row[i].n = (lw_tally){ 0, 0, 0 };
    table->total = (lw_tally){ 0, 0, 0 };
}

static lw_status take_count(void *context, size_t k, const char *answer, size_t size)
{
    task *t = context;
    lw_status status = LW_OK;
    if (t->kept)
        clear_rows(&t->table);
    for (size_t i = 0; i < size/sizeof(lw_tally) && status == LW_OK; i++) {
        lw_tally n;
        memcpy(&n, answer + i*sizeof n, sizeof n);
        status = add_row(&t->table, i, &n);
    }
    if (status == LW_OK && t->kept)
        status = lw_kept_add(t->kept, (int)k, &t->table, t->e);
    return status != LW_OK ? status : tick(t, (double)(k + 1)/(double)t->n_task) ? LW_OK : LW_STOPPED;
}

static bool is_kept(void *context, size_t k)
{
    task *t = context;
    return t->kept && lw_kept_has(t->kept, (int)k);
}

/* A kept count has its own parts, any other a thousand. */
static lw_status remote_count(task *t)
{
    lw_chain_walk nothing = t->how;
    t->n_task = t->s->keep ? (size_t)lw_kept_parts(t->chains) : 1000;
    if (t->kept && (size_t)lw_kept_head_of(t->kept)->n_part != t->n_task)
        return lw_error_set(t->e, LW_E_NOTATION, "%s has %d parts, where --mpi counts %zu; count without --mpi",
                            t->s->keep, lw_kept_head_of(t->kept)->n_part, t->n_task);
    nothing.part = 999999;                       /* only to get the rows of the table; counted again below */
    nothing.n_part = 1000000;
    lw_status status = lw_chains_count(t->chains, &nothing, &t->table);
    if (status == LW_OK)
        clear_rows(&t->table);
    cli_mpi_work w = { t->n_task, work_count, take_count, t, is_kept, 0 };
    t->served = true;
    lw_status run = cli_mpi_run(&w);
    return status == LW_OK ? run : status;
}

/* Report which parts a kept sum is made of. */
static void say_kept(task *t)
{
    const lw_kept_head *h = lw_kept_head_of(t->kept);
    int n, all = wanted_parts(t, &n);
    if (n < all)
        cli_note(t->call, "%s holds %d of %d parts; the same command counts the others", t->s->keep, n, all);
    else if (t->how.n_part == 1)
        cli_note(t->call, "complete: %s holds each of the %d parts once, with all %llu structures", t->s->keep, n,
                 (unsigned long long)h->n_structure);
    else
        cli_note(t->call, "%s holds each of the %d parts %d, %d, ... of %d", t->s->keep, n, t->how.part + 1,
                 t->how.part + 1 + t->how.n_part, h->n_part);
}

static lw_status count_kept(task *t)
{
    lw_status status = t->chains ? lw_kept_begin(t->kept, t->chains, t->e) : LW_OK;
    if (status == LW_OK && !kept_complete(t))
        status = t->s->mpi ? remote_count(t) : lw_kept_run(t->kept, t->chains, &t->how, t->e);
    if (status < 0)
        return status;
    lw_chain_table_free(&t->table);
    lw_status sum = lw_kept_sum(t->kept, t->how.part, t->how.n_part, &t->table);
    say_kept(t);
    return sum == LW_OK ? status : sum;
}

static lw_status count_all(task *t)
{
    lw_status status = t->kept ? count_kept(t) : t->s->mpi ? remote_count(t)
                     : lw_chains_count(t->chains, &t->how, &t->table);
    if (status == LW_OK && t->s->fractionated)
        status = lw_fractionated_each(t->s->links, t->s->dof, count_fractionated, t, NULL);
    cli_progress_end(&t->progress);
    if (generating(t) && (t->how.n_part > 1 || status == LW_STOPPED || (t->kept && !kept_complete(t))))
        return status;                                        /* only all structures give a number */
    lw_numbers numbers;
    if (status == LW_OK && generating(t) && lw_numbers_for_links(t->s->links, t->s->dof, 0, &numbers, t->e) == LW_OK)
        status = lw_labelled_complete(&numbers, &t->table, t->e);
    if (status == LW_OK || status == LW_STOPPED) {
        if (status == LW_STOPPED && !t->kept)
            cli_note(t->call, "stopped: the numbers count the chains found so far");
        write_counts(t, &t->table);
    }
    return status;
}

/* ---- listing -------------------------------------------------------------------------------------- */

/* Write a chain and its line end; graph6, the format of long lists, is written directly. */
static lw_status print_chain(const task *t, const lw_chain *c, char *text, size_t most, size_t *length)
{
    lw_mechanism m;
    lw_status s = LW_OK;
    *length = 0;
    if (t->notation == lw_notations)
        *length = lw_graph6_print(c, text, most);
    else if ((s = lw_mechanism_from_chain(c, &m)) == LW_OK)
        s = t->notation->print(&m, text, most, length);
    if (s == LW_OK)
        text[(*length)++] = '\n';
    return s;
}

static lw_status print_item(void *context, const lw_chain_item *item, char *text, size_t most, size_t *length)
{
    return print_chain(context, item->chain, text, most, length);
}

/* Write whole chains. The first text after a continuation begins with the last chain already listed. */
static lw_status write_text(void *context, const char *text, size_t size)
{
    task *t = context;
    size_t known = t->compared ? 0 : t->before.size;
    t->n_listed += size > 0;
    if (size == 0)
        return LW_OK;
    if (size < known || (known > 0 && memcmp(text, t->before.last, known) != 0))
        return LW_E_KIND;
    t->compared = true;
    text += known;
    size -= known;
    return fwrite(text, 1, size, t->out.f) == size ? LW_OK
           : lw_file_failed(t->e, "written", t->call->common.output ? t->call->common.output : "-", errno);
}

static lw_status write_fractionated(void *context, const lw_chain *c, int n_bridge)
{
    task *t = context;
    char text[LW_NOTATION_SIZE];
    (void)n_bridge;
    bool wanted;
    lw_status asked = ask_wanted(t, c, &wanted);
    if (asked != LW_OK || !wanted)
        return asked;
    if (t->skip_fractionated > 0) {
        t->skip_fractionated--;
        return LW_OK;
    }
    size_t length;
    lw_status status = print_chain(t, c, text, sizeof text, &length);
    if (status == LW_OK)
        status = write_text(t, text, length);
    return status == LW_OK && !tick(t, 1) ? LW_STOPPED : status;
}

/* Find where to continue: chains already listed are left out, except the last one, which is made again and compared. */
static lw_status find_resume(task *t, lw_error *e)
{
    t->n_listed = t->before.n_line;
    t->how.skip = t->before.n_line > 0 ? t->before.n_line - 1 : 0;
    if (!t->s->fractionated || t->how.skip == 0)
        return LW_OK;
    lw_chain_table table;
    lw_status status = lw_chains_count(t->chains, &t->how, &table);
    if (t->how.skip > table.total.n_chain)
        t->skip_fractionated = t->how.skip - table.total.n_chain;
    lw_chain_table_free(&table);
    return lw_graph_error(e, status);
}

static lw_status add_text(void *context, const char *text, size_t size)
{
    lw_bytes_add(context, text, size);
    return LW_OK;
}

/* Under mpirun a task is a structure; its answer is the text of its chains. */
typedef struct remote_print { const task *t; lw_bytes *answer; } remote_print;

static lw_status print_for_answer(void *context, const lw_chain_item *item)
{
    remote_print *p = context;
    char text[LW_NOTATION_SIZE];
    size_t length;
    lw_status status = print_chain(p->t, item->chain, text, sizeof text, &length);
    return status == LW_OK ? add_text(p->answer, text, length) : status;
}

static lw_status work_list(void *context, size_t k, lw_bytes *answer)
{
    task *t = context;
    remote_print p = { t, answer };
    lw_chain_walk how = t->how;
    how.part = (int)k;
    how.n_part = (int)t->n_task;
    how.tick = NULL;
    how.skip = 0;
    return lw_chains_each(t->chains, &how, print_for_answer, &p);
}

static lw_status take_list(void *context, size_t k, const char *answer, size_t size)
{
    task *t = context;
    if (k == t->first)
        for (; t->how.skip > 0; t->how.skip--) {     /* chains that the file has, but the last of them */
            const char *end = memchr(answer, '\n', size);
            size_t line = end ? (size_t)(end + 1 - answer) : size;
            answer += line;
            size -= line;
        }
    lw_status status = write_text(t, answer, size);
    return status == LW_OK && !tick(t, (double)(k + 1)/(double)t->n_task) ? LW_STOPPED : status;
}

/* A listing that is continued: count the chains of one structure after the other up to the last one listed. t->first
 * becomes its structure, t->how.skip the number of its chains before that one. */
static lw_status find_structure(task *t)
{
    lw_chain_walk how = t->how;
    how.skip = 0;
    how.tick = NULL;
    how.n_part = (int)t->n_task;
    for (; t->how.skip > 0 && t->first < t->n_task; t->first++) {
        lw_chain_table table;
        how.part = (int)t->first;
        lw_status status = lw_chains_count(t->chains, &how, &table);
        uint64_t n = table.total.n_chain;
        lw_chain_table_free(&table);
        if (status != LW_OK)
            return status;
        if (n > t->how.skip)
            break;
        t->how.skip -= n;
    }
    return LW_OK;
}

static bool is_listed(void *context, size_t k)
{
    return k < ((task *)context)->first;
}

static lw_status remote_list(task *t)
{
    const lw_structures *set = lw_chains_structures(t->chains);
    t->n_task = set ? lw_structures_count(set, t->n_loop) : 1;
    lw_status status = find_structure(t);
    cli_mpi_work w = { t->n_task, work_list, take_list, t, is_listed, 0 };
    t->served = status == LW_OK;
    return status == LW_OK ? cli_mpi_run(&w) : status;
}

static lw_status list_all(task *t, lw_error *e)
{
    lw_status status = find_resume(t, e);
    if (status == LW_OK)
        status = t->s->mpi ? remote_list(t)
               : lw_chains_print(t->chains, &t->how, t->notation->most + 1, print_item, write_text, t);
    if (status == LW_OK && t->s->fractionated)
        status = lw_fractionated_each(t->s->links, t->s->dof, write_fractionated, t, NULL);
    cli_progress_end(&t->progress);
    if (status == LW_E_KIND || (status == LW_OK && t->before.n_line > 0 && !t->compared))
        return lw_error_at(e, LW_E_KIND, t->call->common.output, (long)t->before.n_line, 1,
                           "another chain comes here, so this is a listing of something else; --resume needs the same options as before");
    return status;
}

/* ---- the command ---------------------------------------------------------------------------------- */

static int finish(task *t, lw_status status, const lw_error *e)
{
    if (status < 0) {
        int code = cli_fail(t->call, e);
        lw_output_abandon(&t->out);
        return code;
    }
    bool nothing = status == LW_OK && !t->s->count && t->n_listed == 0;
    return cli_close(t->call, &t->out, nothing ? CLI_NOTHING : cli_exit_code(status));
}

/* Make the structures, then list or count; done by process 0 if there are several. */
static int enumerate(task *t, lw_error *e)
{
    lw_status status = LW_OK;
    bool listing = !t->s->count && !t->notation->lines;
    if (say_how_long(t, e) != LW_OK)
        return cli_fail(t->call, e);
    if (t->s->structures || !kept_complete(t)) {
        t->progress = cli_progress_begin(t->call, "structures", "structures");
        status = lw_chains_create_while(t->s->links, t->s->dof, t->call->common.jobs, t->s->structures, tick_structures, t, &t->chains, e);
        cli_progress_end(&t->progress);
    }
    if (status != LW_OK)
        return cli_interrupted() && !cli_timed_out() ? CLI_DONE : cli_fail(t->call, e);
    t->progress = cli_progress_begin(t->call, "chains", "chains");
    if ((listing ? cli_resume_open(t->call, t->s->resume, &t->out, &t->before, e) : cli_open(t->call, &t->out, e)) != LW_OK)
        return cli_fail(t->call, e);
    status = t->s->count ? count_all(t) : list_all(t, e);
    return finish(t, lw_graph_error(e, status), e);
}

/* Work of the other processes: the same structures, then tasks from process 0. */
static void run_as_worker(task *t)
{
    if (lw_chains_create_while(t->s->links, t->s->dof, 1, t->s->structures, NULL, NULL, &t->chains, NULL) == LW_OK)
        (void)(t->s->count ? remote_count(t) : remote_list(t));
}

static int run(const cli_call *call)
{
    task t = { .call = call, .s = call->settings, .start = lw_clock_wall() };
    lw_error e = { 0 };
    lw_numbers numbers;
    t.e = &e;
    int code = read_settings(&t), rank = 0;
    if (code != CLI_DONE)
        return code;
    if (t.s->mpi)
        rank = cli_mpi_begin();
    lw_status status = lw_numbers_for_links(t.s->links, t.s->dof, 0, &numbers, &e);
    t.n_loop = status == LW_OK ? numbers.n_loop : 0;
    if (status == LW_OK && rank == 0 && t.s->keep)
        status = lw_kept_open(t.s->keep, t.s->links, t.s->dof, t.how.filter, &t.kept, &e);
    if (rank > 0)
        run_as_worker(&t);
    else
        code = status == LW_OK ? enumerate(&t, &e) : cli_fail(call, &e);
    if (t.s->mpi)
        cli_mpi_end(t.served);
    free(t.before.last);
    lw_chain_table_free(&t.table);
    lw_kept_close(t.kept);
    lw_chains_free(t.chains);
    return code;
}

const cli_command cli_chains_command = {
    .name = "chains",
    .words = "--links P",
    .title = "list all kinematic chains with P links and F degrees of freedom",
    .examples =
        "  linkwright chains --links 8                          the 16 eight-link chains as graph6\n"
        "  linkwright chains --links 12 --count --by assortment number for each assortment of links\n"
        "  linkwright chains --links 9 --dof 0 --format edges   Baranov trusses as lists of joints\n"
        "  linkwright chains --links 9 --dof 2 --fractionated   also those that separate at a link\n"
        "  linkwright chains --links 16 --part 3/100 -o 3.g6    one of a hundred jobs of a cluster\n"
        "  linkwright chains --links 16 -o all.g6 --resume      continue after an interruption\n"
        "  linkwright chains --links 18 --count --keep 18.parts --structures 9.bin   a count that survives interruptions\n"
        "  mpirun -n 64 linkwright chains --links 18 --count --mpi   on many machines\n",
    .about =
        "Every joint has one degree of freedom, and no part of a chain is rigid. Each chain is listed once. The\n"
        "order is always the same, for any number of --jobs: by structure, and within a structure by the\n"
        "distribution of binary links (docs/theory.md). --part R/M takes the structures R, R + M, R + 2M, ...\n"
        "Fractionated chains come last and are counted separately. With a --filter that must look at each chain,\n"
        "counting takes as long as listing. Before work of more than a few seconds, the expected time is printed.\n"
        "A listing in -o FILE is written to FILE.partial until it ends. After an interruption, --resume continues\n"
        "with either file; it compares the last line with the chain that belongs there.\n"
        "--keep FILE counts in parts of some thousand structures and appends the numbers of each to FILE, with a\n"
        "check sum. The same command continues after an interruption. Several processes each take --part R/M of the\n"
        "parts and a FILE of their own; --keep with the joined files (cat) proves that each part is there once, and\n"
        "prints the sum (docs/cluster.md). --structures FILE makes the structures once for all runs.\n"
        "Exit code 1: there is no such chain; 5: --time ended the work, and what was found is kept.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .most_words = 0,
    .run = run,
    .writes = "text",
};
