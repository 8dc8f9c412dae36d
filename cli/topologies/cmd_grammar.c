/* linkwright grammar - sentences, the published rules, derivations, coverage. */
#include <stdlib.h>
#include <string.h>

#include "cli/program/json.h"
#include "cli/program/topology.h"
#include "enumerate/canon.h"
#include "enumerate/derive.h"
#include "grammar/topology/growth.h"

typedef struct settings {
    int         format;
    const char *from, *at, *k, *rules;
    int         rule, word, links;
    bool        anywhere, count, keep_going;
} settings;

static const cli_option options[] = {
    CLI_FORMAT_ROW(settings, format, NULL, "parse, print, derive: "),
    { "keep-going", 'k', CLI_FLAG, offsetof(settings, keep_going), NULL, NULL,
      "parse, print, explain: after an error in the input continue with the next topology", 0, 0, NULL, NULL },
    { "sentence", 0, CLI_TEXT, offsetof(settings, from), "SENTENCE", NULL, "derive: the sentence that the rule is applied to", 0, 0, NULL, NULL },
    { "rule", 0, CLI_INT, offsetof(settings, rule), "N", NULL,
      "derive: apply one rule; rules 1 and 2 make a first sentence, rules 3 and 4 extend --sentence at --at", 1, 4, NULL, "links" },
    { "at", 0, CLI_TEXT, offsetof(settings, at), "X,Y", NULL,
      "derive: the two parts between which the new string of links is put", 0, 0, "rule", NULL },
    { "word", 'w', CLI_INT, offsetof(settings, word), "N", NULL,
      "derive: number of the word that is extended, from 1; without it the first that holds X and Y", 1, LW_WORD_MAX, "at", NULL },
    { "joints", 0, CLI_TEXT, offsetof(settings, k), "KINDS", NULL,
      "derive: with --rule the kinds of the new joints in order (rule 4: three), with --links the kinds allowed: r "
      "pin, t slider; without it r", 0, 0, NULL, NULL },
    { "links", 'l', CLI_INT, offsetof(settings, links), "P", NULL,
      "derive: all topologies with P links that the rules can make; coverage: greatest number of links", 3, LW_LINK_MAX, NULL, NULL },
    { "rules", 0, CLI_TEXT, offsetof(settings, rules), "LIST", "1,2,3,4", "derive: with --links, the rules that may be used", 0, 0, NULL, NULL },
    { "anywhere", 0, CLI_FLAG, offsetof(settings, anywhere), NULL, NULL,
      "derive: X and Y need not lie at the same region of the drawing", 0, 0, "links", NULL },
    { "count", 'c', CLI_FLAG, offsetof(settings, count), NULL, NULL, "derive: print only the number", 0, 0, "links", NULL },
    { .name = NULL }
};

/* Data of one run. */
typedef struct job {
    const cli_call    *call;
    const settings    *s;
    lw_output          out;
    const lw_notation *notation;
    cli_watch          watch;
    uint64_t           n;
    lw_error           e;
} job;

static job job_of(const cli_call *call, const char *usual)
{
    const settings *s = call->settings;
    const lw_notation *n = lw_notation_find(usual);
    if (call->common.json)
        n = lw_notation_find("json");
    else if (cli_given(&call->parsed, "format"))
        n = &lw_notations[s->format];
    return (job){ .call = call, .s = s, .notation = n, .watch = cli_watch_begin(call, "grammar", "topologies") };
}

static const char *file_word(const cli_call *call)
{
    return call->parsed.n_word > 1 ? call->parsed.word[1] : NULL;
}

/* ---- parse, print ------------------------------------------------------------------------------ */

static lw_status write_one(void *context, const lw_mechanism *m, lw_error *e)
{
    job *j = context;
    lw_status s = cli_topology_write(j->call, j->out.f, j->notation, m, e);
    return s == LW_OK && !cli_watch_goes_on(&j->watch, (double)++j->n) ? LW_STOPPED : s;
}

/* Read topologies and print each again by `visit`. */
static int each_of_input(job *j, cli_topology_visit *visit)
{
    lw_error e = { 0 };
    if (cli_open(j->call, &j->out, &e) != LW_OK)
        return cli_fail(j->call, &e);
    int code = cli_topologies_each(j->call, file_word(j->call), j->s->keep_going, visit, j);
    code = cli_watch_end(&j->watch, code == CLI_DONE && j->n == 0 ? CLI_NOTHING : code);
    return cli_close(j->call, &j->out, code);
}

static int run_parse(const cli_call *call)
{
    job j = job_of(call, "edges");
    return each_of_input(&j, write_one);
}

static int run_print(const cli_call *call)
{
    job j = job_of(call, "sentence");
    return each_of_input(&j, write_one);
}

/* ---- explain ----------------------------------------------------------------------------------- */

static void explain_json(job *j, const lw_mechanism *m, const lw_growth *g, lw_reach reach, const char *why)
{
    static const char *const word[] = { "regions", "anywhere", "mobility", "gear", "core" };
    cli_json w = cli_json_begin(j->out.f, 0);
    cli_json_object(&w, NULL);
    cli_json_text(&w, "reach", word[reach]);
    cli_json_text(&w, "why", why);
    cli_json_array(&w, "steps");
    for (int i = 0; reach <= LW_REACHED_NO_REGIONS && i < g->n_step; i++) {
        char kinds[5] = "";
        memcpy(kinds, g->step[i].kind, (size_t)lw_rule_kinds(g->step[i].rule));
        cli_json_object(&w, NULL);
        cli_json_int(&w, "rule", g->step[i].rule);
        if (i > 0) {
            cli_json_int(&w, "x", g->step[i].x);
            cli_json_int(&w, "y", g->step[i].y);
        }
        if (g->step[i].word != LW_NONE)
            cli_json_int(&w, "word", g->step[i].word + 1);
        cli_json_text(&w, "kinds", kinds);
        cli_json_end(&w);
    }
    cli_json_end(&w);
    cli_json_array(&w, "link_of_part");
    for (int i = 0; reach <= LW_REACHED_NO_REGIONS && i < m->n_link; i++)
        cli_json_int(&w, NULL, g->link_of[i] + 1);
    cli_json_end(&w);
    cli_json_end(&w);
}

static void explain_text(job *j, const lw_mechanism *m, const lw_growth *g, lw_reach reach, const char *why)
{
    char text[LW_SENTENCE_SIZE];
    lw_error e;
    lw_sentence s;
    cli_topology_write(j->call, j->out.f, lw_notation_find("edges"), m, &e);
    fprintf(j->out.f, "  %s\n", why);
    for (int i = 0; reach <= LW_REACHED_NO_REGIONS && i < g->n_step; i++) {
        lw_production_print(&g->step[i], text, sizeof text);
        fprintf(j->out.f, "  %s\n", text);
        if (reach == LW_REACHED && lw_growth_sentence(g, i + 1, &s, &e) == LW_OK) {
            lw_sentence_print(&s, text, sizeof text);
            fprintf(j->out.f, "      %s\n", text);
        }
    }
    if (reach <= LW_REACHED_NO_REGIONS) {
        fputs("  parts 1, 2, ... are links", j->out.f);
        for (int i = 0; i < m->n_link; i++)
            fprintf(j->out.f, " %d", g->link_of[i] + 1);
        fputc('\n', j->out.f);
    }
}

static lw_status explain_one(void *context, const lw_mechanism *m, lw_error *e)
{
    job *j = context;
    lw_growth g;
    lw_reach reach;
    uint32_t core = 0;
    char why[1024];
    lw_status s = lw_growth_find(m, &g, &reach, &core, e);
    if (s != LW_OK)
        return s;
    lw_reach_print(m, reach, core, why, sizeof why);
    (j->call->common.json ? explain_json : explain_text)(j, m, &g, reach, why);
    return cli_watch_goes_on(&j->watch, (double)++j->n) ? LW_OK : LW_STOPPED;
}

static int run_explain(const cli_call *call)
{
    job j = job_of(call, "edges");
    return each_of_input(&j, explain_one);
}

/* ---- derive ------------------------------------------------------------------------------------ */

/* Read a place such as "3,4". */
static bool read_place(const char *text, lw_production *p)
{
    char *end;
    long x = strtol(text, &end, 10), y = *end == ',' ? strtol(end + 1, &end, 10) : 0;
    p->x = (uint8_t)(x > 0 && x <= LW_LINK_MAX ? x : 0);
    p->y = (uint8_t)(y > 0 && y <= LW_LINK_MAX ? y : 0);
    return p->x && p->y && *end == '\0';
}

static int write_sentence(job *j, const lw_sentence *s)
{
    char text[LW_SENTENCE_SIZE];
    lw_mechanism m;
    if (cli_open(j->call, &j->out, &j->e) != LW_OK)
        return cli_fail(j->call, &j->e);
    lw_status status = LW_OK;
    if (strcmp(j->notation->name, "sentence") == 0) {      /* as the rule left it, words in its order */
        lw_sentence_print(s, text, sizeof text);
        fprintf(j->out.f, "%s\n", text);
    } else if ((status = lw_sentence_mechanism(s, &m, &j->e)) == LW_OK) {
        status = cli_topology_write(j->call, j->out.f, j->notation, &m, &j->e);
    }
    int code = status == LW_OK ? CLI_DONE : cli_fail(j->call, &j->e);
    return cli_close(j->call, &j->out, code);
}

/* The letters of --joints without commas, or `without` if it is not given. */
static const char *joint_letters(const settings *s, const char *without, char letters[16])
{
    size_t n = 0;
    if (!s->k)
        return without;
    for (const char *at = s->k; *at && n < 15; at++)
        if (*at != ',')
            letters[n++] = *at;
    letters[n] = '\0';
    return letters;
}

static int derive_by_hand(const cli_call *call)
{
    job j = job_of(call, "sentence");
    const settings *s = j.s;
    lw_production p = lw_production_of(s->rule);
    lw_sentence sentence;
    char letters[16];
    const char *kinds = joint_letters(s, NULL, letters);
    if (kinds && strlen(kinds) != (size_t)lw_rule_kinds(s->rule))
        return cli_usage(call, "rule %d has %d joints k, --joints %s gives %zu", s->rule, lw_rule_kinds(s->rule), s->k, strlen(kinds));
    if (kinds)
        memcpy(p.kind, kinds, strlen(kinds));
    if (s->rule <= 2) {
        if (s->from || s->at)
            return cli_usage(call, "rule %d makes a first sentence and takes neither --sentence nor --at", s->rule);
        return lw_rule_plant(&p, &sentence, &j.e) == LW_OK ? write_sentence(&j, &sentence) : cli_fail(call, &j.e);
    }
    if (!s->from || !s->at)
        return cli_usage(call, "rule %d extends a sentence: give --sentence SENTENCE and --at X,Y", s->rule);
    if (!read_place(s->at, &p))
        return cli_usage(call, "--at takes two part numbers, such as 3,4, not '%s'", s->at);
    p.word = s->word > 0 ? s->word - 1 : LW_NONE;
    if (lw_sentence_read(s->from, strlen(s->from), "--sentence", &sentence, &j.e) != LW_OK
        || lw_rule_apply(&sentence, &p, &sentence, &j.e) != LW_OK)
        return cli_fail(call, &j.e);
    return write_sentence(&j, &sentence);
}

static lw_status write_derived(void *context, const lw_mechanism *m)
{
    job *j = context;
    if (!cli_watch_goes_on(&j->watch, (double)++j->n))
        return LW_STOPPED;
    return j->s->count ? LW_OK : cli_topology_write(j->call, j->out.f, j->notation, m, &j->e);
}

static int derive_all(const cli_call *call)
{
    job j = job_of(call, "sentence");
    lw_derive how = lw_derive_default(j.s->links);
    char letters[16];
    how.regions = !j.s->anywhere;
    how.kinds = joint_letters(j.s, "r", letters);
    how.stop = cli_stop_flag();
    how.max_bytes = cli_memory(call);
    for (int r = 1; r <= 4; r++)
        how.rule[r] = strchr(j.s->rules, '0' + r) != NULL;
    if (strspn(j.s->rules, "1234,") != strlen(j.s->rules) || !strpbrk(j.s->rules, "1234"))
        return cli_usage(call, "--rules takes numbers 1 to 4 with commas, not '%s'", j.s->rules);
    if (cli_open(call, &j.out, &j.e) != LW_OK)
        return cli_fail(call, &j.e);
    lw_status s = lw_derive_each(&how, write_derived, &j);
    if (s == LW_E_ARG)
        lw_error_set(&j.e, s, "--joints with --links takes r, t or r,t, not '%s'", how.kinds);
    if (s == LW_E_MEMORY)
        lw_error_set(&j.e, s, "the mechanisms that are reached with %d links do not fit into memory", how.n_link);
    if (lw_graph_error(&j.e, s) < 0) {
        lw_output_abandon(&j.out);
        return cli_fail(call, &j.e);
    }
    if (j.s->count)
        fprintf(j.out.f, "%llu\n", (unsigned long long)j.n);
    return cli_close(call, &j.out, cli_watch_end(&j.watch, j.n > 0 ? CLI_DONE : CLI_NOTHING));
}

static int run_derive(const cli_call *call)
{
    const settings *s = call->settings;
    if (s->rule > 0)
        return derive_by_hand(call);
    if (s->links > 0)
        return derive_all(call);
    return cli_usage(call, "derive takes --rule N (one step by hand) or --links N (all that the rules can make)");
}

/* ---- coverage ---------------------------------------------------------------------------------- */

static void coverage_row(FILE *f, int n, const lw_coverage *c)
{
    fprintf(f, "%5d %9llu %9llu %9llu %6.2f %% %9llu %6.2f %%\n", n, (unsigned long long)c->n_chain,
            (unsigned long long)c->n_planar, (unsigned long long)c->n_reached,
            100.0*(double)c->n_reached/(double)c->n_chain, (unsigned long long)c->n_reached_by_regions,
            100.0*(double)c->n_reached_by_regions/(double)c->n_chain);
}

static void coverage_json(cli_json *w, int n, const lw_coverage *c)
{
    cli_json_object(w, NULL);
    cli_json_int(w, "links", n);
    cli_json_int(w, "chains", (long long)c->n_chain);
    cli_json_int(w, "planar", (long long)c->n_planar);
    cli_json_int(w, "reached", (long long)c->n_reached);
    cli_json_int(w, "reached_by_regions", (long long)c->n_reached_by_regions);
    cli_json_end(w);
}

static int run_coverage(const cli_call *call)
{
    job j = job_of(call, "json");
    lw_status s = LW_OK;
    if (j.s->links < 4)
        return cli_usage(call, "coverage takes --links N, an even number from 4 on");
    if (j.s->links % 2)
        return cli_usage(call, "chains of pins with F = 1 have P = 2 L + 2 links, an even number, not %d", j.s->links);
    if (cli_open(call, &j.out, &j.e) != LW_OK)
        return cli_fail(call, &j.e);
    cli_json w = cli_json_begin(j.out.f, 2);
    if (call->common.json)
        cli_json_array(&w, NULL);
    else
        fputs("links    chains    planar   reached            by regions\n", j.out.f);
    for (int n = 4; n <= j.s->links && s == LW_OK && cli_watch_goes_on(&j.watch, n); n += 2) {
        lw_coverage c;
        s = lw_coverage_count(n, call->common.jobs, cli_stop_flag(), &c, &j.e);
        if (s == LW_OK && call->common.json)
            coverage_json(&w, n, &c);
        else if (s == LW_OK)
            coverage_row(j.out.f, n, &c);
        fflush(j.out.f);
    }
    if (call->common.json)
        cli_json_end(&w);
    return cli_close(call, &j.out, cli_watch_end(&j.watch, s == LW_OK ? CLI_DONE : s == LW_STOPPED ? CLI_LIMIT
                                                        : (lw_graph_error(&j.e, s), cli_fail(call, &j.e))));
}

/* ---- the command ------------------------------------------------------------------------------- */

static const cli_action actions[] = {
    { "parse", "[FILE]", "Reads topologies in any notation and prints them as lists of joints, or as --format says.\n",
      0, 1,
      run_parse, CLI_TOPOLOGIES, NULL },
    { "print", "[FILE]", "Reads topologies in any notation and prints them as sentences, or as --format says.\n", 0, 1,
      run_print, CLI_TOPOLOGIES, NULL },
    { "explain", "[FILE]",
      "Prints a derivation of each chain, sentence by sentence, or the reason why rules 1 to 4 cannot make it. To\n"
      "find a derivation, strings of links are removed one after the other.\n", 0, 1, run_explain, CLI_TOPOLOGIES, NULL },
    { "derive", "--rule N | --links P",
      "Applies one rule to a sentence, or all rules as often as P links allow; each result is printed once.\n", 0, 0,
      run_derive, 0, NULL },
    { "coverage", "--links P",
      "Counts the chains of pins with one degree of freedom: all, those with a planar graph, and those that the\n"
      "rules can make, with and without the condition that X and Y lie at the same region.\n", 0, 0, run_coverage, 0, NULL },
    { .name = NULL }
};

const cli_command cli_grammar_command = {
    .name = "grammar",
    .words = "ACTION [FILE]",
    .title = "topologies as sentences: read, print, derive by the rules of a grammar",
    .examples =
        "  echo '((1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r))' | linkwright grammar parse --format lam\n"
        "  linkwright grammar print watt.lam                    the sentence of a matrix\n"
        "  linkwright grammar derive --sentence '((1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r))' --rule 3 --at 3,4\n"
        "  linkwright grammar derive --links 8 --rules 2,4      all that rules 2 and 4 can make\n"
        "  linkwright grammar explain chains.g6                 a derivation of each, or why there is none\n"
        "  linkwright grammar coverage --links 12               how many chains the rules can make\n",
    .about =
        "A sentence writes a topology as words, one for each loop of links (Makkonen 1999, paper F;\n"
        "docs/notation.md). Notations that are read: graph6, link adjacency matrix, sentence, Franke, list of\n"
        "joints, JSON. Errors in the input are printed with line and column. 'linkwright help grammar ACTION'\n"
        "shows one action.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .actions = actions,
    .writes = "text",
};
