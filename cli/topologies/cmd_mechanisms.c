/* linkwright mechanisms - choose ground, joint kinds, inputs and output of chains in all ways that differ by more than
 * a symmetry; find Assur groups and multiple joints. */
#include <string.h>

#include "cli/program/json.h"
#include "cli/program/topology.h"
#include "enumerate/assur.h"
#include "enumerate/canon.h"
#include "enumerate/higher.h"
#include "enumerate/mechanisms.h"
#include "enumerate/multiple.h"
#include "grammar/topology/edges.h"
#include "grammar/topology/mechanism_json.h"

typedef struct settings {
    int         format, links, dof, n2, input, assur_groups;
    const char *joints;
    bool        no_ground, output, count, void_ones, assur, multiple, fractionated, keep_going, slider_direction, translating_cams;
} settings;

enum { FORMAT_JSON = 5 };                                  /* rows of lw_notations */

static const cli_option options[] = {
    CLI_FORMAT_ROW(settings, format, "json", ""),
    { "links", 'l', CLI_INT, offsetof(settings, links), "P", NULL,
      "use all chains with P links, instead of reading chains", 3, LW_LINK_MAX, NULL, NULL },
    { "dof", 'd', CLI_INT, offsetof(settings, dof), "F", "1", "degree of freedom of these chains", 1, LW_DOF_MAX, NULL, NULL },
    { "n2", 0, CLI_INT, offsetof(settings, n2), "K", "0",
      "number of joints with two degrees of freedom in these chains", 0, LW_LINK_MAX, "links", NULL },
    { "no-ground", 0, CLI_FLAG, offsetof(settings, no_ground), NULL, NULL, "do not choose a ground link", 0, 0, NULL, "output-link" },
    { "joints", 0, CLI_TEXT, offsetof(settings, joints), "KINDS", NULL,
      "kinds of joints: r pin and t slider (one degree of freedom), p pin in a slot and g gear pair (two); all "
      "combinations that have F degrees of freedom", 0, 0, NULL, NULL },
    { "slider-direction", 0, CLI_FLAG, offsetof(settings, slider_direction), NULL, NULL,
      "tell apart which link of a slider has the guide and which the block: the slider-crank has 4 inversions then, else 2", 0, 0, "joints", NULL },
    { "translating-cams", 0, CLI_FLAG, offsetof(settings, translating_cams), NULL, NULL,
      "also combinations in which two links that touch (g) never turn against each other, such as a wedge", 0, 0, "joints", NULL },
    { "input", 'i', CLI_CHOICE, offsetof(settings, input), "none|ground|any", "none",
      "choose F driven joints: from the joints at the ground, or from all", 0, 0, NULL, NULL },
    { "output-link", 0, CLI_FLAG, offsetof(settings, output), NULL, NULL, "choose an output link", 0, 0, NULL, NULL },
    { "count", 'c', CLI_FLAG, offsetof(settings, count), NULL, NULL, "print only the number after each step", 0, 0, NULL, NULL },
    { "void", 0, CLI_FLAG, offsetof(settings, void_ones), NULL, NULL,
      "list the combinations of joint kinds that are left out, with the reason", 0, 0, "joints", "count" },
    { "assur", 0, CLI_FLAG, offsetof(settings, assur), NULL, NULL,
      "list the Assur groups of each mechanism in the order in which they are solved; requires --input", 0, 0, NULL, "count" },
    { "assur-groups", 0, CLI_INT, offsetof(settings, assur_groups), "N", NULL,
      "list all Assur groups of N links instead", 2, LW_LINK_MAX-1, NULL, "links" },
    { "multiple-joints", 0, CLI_FLAG, offsetof(settings, multiple), NULL, NULL,
      "list the chains with multiple joints instead (several links on one pin)", 0, 0, "links", "joints" },
    { "fractionated", 0, CLI_FLAG, offsetof(settings, fractionated), NULL, NULL,
      "also list chains that separate into two at a link or a pin, after the others", 0, 0, "multiple-joints", NULL },
    { "keep-going", 'k', CLI_FLAG, offsetof(settings, keep_going), NULL, NULL,
      "after an error in the input continue with the next chain", 0, 0, NULL, NULL },
    { .name = NULL }
};

typedef struct job {
    const cli_call      *call;
    const settings      *s;
    lw_output            out;
    lw_mechanism_steps   steps;
    lw_mechanism_counts  counts;
    char                 kinds[8];
    cli_watch            watch;
    uint64_t             n;                /* written */
    lw_error             e;
} job;

/* Read kinds such as "r,t" into "rt". False: not a list of the four letters, each at most once. */
static bool read_kinds(const char *text, char kinds[8])
{
    int n = 0;
    for (; *text; text++)
        if (*text != ',') {
            if (!lw_joint_freedoms(*text) || memchr(kinds, *text, (size_t)n))
                return false;
            kinds[n++] = *text;
        }
    return n > 0;
}

/* ---- writing ----------------------------------------------------------------------------------- */

static lw_status write_groups(job *j, const lw_mechanism *m)
{
    lw_assur a;
    char text[1024];
    lw_status s = lw_assur_decompose(m, &a, &j->e);
    if (s == LW_OK && !j->call->common.json)
        s = cli_topology_write(j->call, j->out.f, lw_notation_find("edges"), m, &j->e);
    if (s != LW_OK)
        return s;
    if (!j->call->common.json) {
        for (int k = 0; k < a.n_group; k++) {
            lw_assur_print(m, &a.group[k], text, sizeof text);
            fprintf(j->out.f, "  %s\n", text);
        }
        return LW_OK;
    }
    cli_json w = cli_json_begin(j->out.f, 0);
    lw_mechanism_write(m, text, sizeof text);
    cli_json_object(&w, NULL);
    cli_json_raw(&w, "mechanism", text);
    cli_json_array(&w, "groups");
    for (int k = 0; k < a.n_group; k++) {
        cli_json_object(&w, NULL);
        cli_json_int(&w, "class", a.group[k].n_class);
        cli_json_int(&w, "order", a.group[k].order);
        cli_json_int(&w, "modes", a.group[k].n_mode);
        cli_json_array(&w, "links");
        for (uint32_t l = a.group[k].links; l; l &= l - 1)
            cli_json_int(&w, NULL, __builtin_ctz(l) + 1);
        cli_json_end(&w);
        cli_json_end(&w);
    }
    cli_json_end(&w);
    cli_json_end(&w);
    return LW_OK;
}

static lw_status write_one(void *context, const lw_mechanism *m)
{
    job *j = context;
    if (!cli_watch_goes_on(&j->watch, (double)++j->n))
        return LW_STOPPED;
    if (j->s->count || j->s->void_ones)
        return LW_OK;
    if (j->s->assur)
        return write_groups(j, m);
    return cli_topology_write(j->call, j->out.f, &lw_notations[j->call->common.json ? FORMAT_JSON : j->s->format], m, &j->e);
}

static lw_status write_void(void *context, const lw_mechanism *m, lw_void reason, uint64_t joints)
{
    job *j = context;
    char line[LW_EDGES_SIZE], why[1024];
    if (!j->s->void_ones)
        return LW_OK;
    lw_edges_print(m, line, sizeof line);
    lw_void_print(m, reason, joints, why, sizeof why);
    fprintf(j->out.f, "%s   # %s\n", line, why);
    return cli_watch_goes_on(&j->watch, (double)j->n) ? LW_OK : LW_STOPPED;
}

static void write_counts(job *j)
{
    const lw_mechanism_counts *c = &j->counts;
    const struct { const char *key, *text; uint64_t n; bool taken; } row[] = {
        { "chains", "chains", c->n_chain, true },
        { "ground", "with ground link", c->n_ground, j->steps.ground },
        { "labelled", "with joint kinds", c->n_labelled, j->steps.kinds != NULL },
        { "void_slider_loop", "  left out: loop of sliders only", c->n_void[LW_VOID_SLIDER_LOOP], j->steps.kinds },
        { "void_no_turn", "  left out: a joint that cannot turn", c->n_void[LW_VOID_NO_TURN], j->steps.kinds },
        { "void_dependent", "  left out: F counts wrongly", c->n_void[LW_VOID_DEPENDENT], j->steps.kinds },
        { "void_locked", "  left out: a joint never moves", c->n_void[LW_VOID_LOCKED], j->steps.kinds },
        { "driven", "with inputs", c->n_driven, j->steps.input != LW_INPUT_LEFT },
        { "output", "with output link", c->n_output, j->steps.output },
    };
    cli_json w = cli_json_begin(j->out.f, 2);
    if (j->call->common.json)
        cli_json_object(&w, NULL);
    for (size_t i = 0; i < sizeof row/sizeof *row; i++)
        if (row[i].taken && j->call->common.json)
            cli_json_int(&w, row[i].key, (long long)row[i].n);
        else if (row[i].taken)
            fprintf(j->out.f, "%-36s %12llu\n", row[i].text, (unsigned long long)row[i].n);
    if (j->call->common.json)
        cli_json_end(&w);
}

/* ---- where chains come from -------------------------------------------------------------------- */

/* Apply the steps that m has not gone through yet. */
static lw_status take_steps(job *j, const lw_mechanism *m)
{
    lw_mechanism_steps steps = j->steps;
    steps.ground = steps.ground && m->ground == LW_NONE;
    steps.output = steps.output && m->output == LW_NONE;
    steps.input = m->n_input > 0 ? LW_INPUT_LEFT : steps.input;
    lw_status s = lw_mechanisms_each(m, &steps, &j->counts, write_one, write_void, j);
    if (s == LW_E_ARG && !j->e.text[0])
        lw_error_set(&j->e, s, "these steps do not go together with this chain: inputs at the ground and outputs want "
                     "a ground link, --joints a letter for each freedom that occurs");
    return lw_graph_error(&j->e, s);
}

static lw_status from_input(void *context, const lw_mechanism *m, lw_error *e)
{
    job *j = context;
    lw_chain c;
    lw_mechanism_chain(m, &c);
    lw_status s = lw_chain_check(&c, e);
    if (s == LW_OK) {
        j->e = (lw_error){ 0 };
        s = take_steps(j, m);
        *e = j->e;
    }
    return s;
}

static lw_status from_chains(void *context, const lw_chain_item *item)
{
    lw_mechanism m;
    lw_status s = lw_mechanism_from_chain(item->chain, &m);
    return s == LW_OK ? take_steps(context, &m) : s;
}

static lw_status from_higher(void *context, const lw_chain *c)
{
    lw_mechanism m;
    lw_status s = lw_mechanism_from_chain(c, &m);
    return s == LW_OK ? take_steps(context, &m) : s;
}

/* Numbers of chains and ground links can be counted without a listing. */
static lw_status count_quickly(job *j, const lw_chains *chains, const lw_chain_walk *how)
{
    lw_chain_table table;
    lw_status s = lw_chains_count(chains, how, &table);
    j->counts.n_chain = table.total.n_chain;
    j->counts.n_ground = table.total.n_ground;
    j->n = table.total.n_chain;
    lw_chain_table_free(&table);
    return s;
}

static bool go_on(void *context)
{
    job *j = context;
    return cli_watch_goes_on(&j->watch, (double)j->n);
}

static bool walk_tick(void *context, double done)
{
    (void)done;
    return go_on(context);
}

static bool grow_tick(void *context, int loops, size_t found)
{
    (void)loops;
    (void)found;
    return go_on(context);
}

static lw_status generate(job *j)
{
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    how.n_thread = j->call->common.jobs;
    if (j->s->n2 > 0)
        return lw_higher_each_while(j->s->links, j->s->dof, j->s->n2, how.n_thread, go_on, from_higher, j, &j->e);
    how.tick = walk_tick;
    how.tick_context = j;
    lw_status s = lw_chains_create_while(j->s->links, j->s->dof, how.n_thread, NULL, grow_tick, j, &chains, &j->e);
    if (s != LW_OK)
        return s;
    if (j->s->count && !j->steps.kinds && j->steps.input == LW_INPUT_LEFT && !j->steps.output)
        s = count_quickly(j, chains, &how);
    else
        s = lw_chains_each(chains, &how, from_chains, j);
    lw_chains_free(chains);
    return s;
}

/* ---- other lists ------------------------------------------------------------------------------- */

static lw_status write_multiple(void *context, const lw_multiple *m)
{
    job *j = context;
    char text[LW_JOINT_MAX*8];
    lw_multiple_print(m, text, sizeof text);
    if (!j->s->count)
        fprintf(j->out.f, "%s\n", text);
    return cli_watch_goes_on(&j->watch, (double)++j->n) ? LW_OK : LW_STOPPED;
}

static lw_status write_group(void *context, const lw_chain *truss, int lost, const lw_assur_group *g)
{
    job *j = context;
    lw_mechanism m;
    char text[1024];
    if (!cli_watch_goes_on(&j->watch, (double)++j->n))
        return LW_STOPPED;
    if (j->s->count)
        return LW_OK;
    lw_status s = lw_mechanism_from_chain(truss, &m);
    if (s != LW_OK)
        return s;
    m.ground = lost;
    lw_edges_print(&m, text, sizeof text);
    fprintf(j->out.f, "%s   # ", text);
    lw_assur_print(&m, g, text, sizeof text);
    fprintf(j->out.f, "%s\n", text);
    return LW_OK;
}

/* ---- the command ------------------------------------------------------------------------------- */

static lw_status run_lists(job *j)
{
    if (j->s->assur_groups > 0 && j->s->count)
        return lw_assur_count(j->s->assur_groups, j->call->common.jobs, &j->n, &j->e);
    if (j->s->assur_groups > 0)
        return lw_assur_each(j->s->assur_groups, j->call->common.jobs, write_group, j, &j->e);
    if (j->s->multiple)
    {
        lw_status s = lw_multiple_each(j->s->links, j->s->dof, j->call->common.jobs, write_multiple, j, &j->e);
        return s != LW_OK || !j->s->fractionated ? s
             : lw_multiple_fractionated_each(j->s->links, j->s->dof, j->call->common.jobs, write_multiple, j, &j->e);
    }
    return generate(j);
}

static int run_job(job *j)
{
    const cli_call *call = j->call;
    bool listed = j->s->links > 0 || j->s->assur_groups > 0, other = j->s->assur_groups > 0 || j->s->multiple;
    int code = CLI_DONE;
    if (cli_open(call, &j->out, &j->e) != LW_OK)
        return cli_fail(call, &j->e);
    if (!listed) {
        code = cli_topologies_each(call, call->parsed.n_word > 0 ? call->parsed.word[0] : NULL, j->s->keep_going, from_input, j);
    } else {
        lw_status s = run_lists(j);
        if (lw_graph_error(&j->e, s) < 0) {
            lw_output_abandon(&j->out);
            return cli_watch_end(&j->watch, cli_fail(call, &j->e));
        }
    }
    if (other && j->s->count)
        fprintf(j->out.f, "%llu\n", (unsigned long long)j->n);
    else if (j->s->count)
        write_counts(j);
    bool nothing = j->n == 0 && !(j->s->void_ones || j->s->count);
    code = cli_watch_end(&j->watch, code == CLI_DONE && nothing ? CLI_NOTHING : code);
    return cli_close(call, &j->out, code);
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    job j = { .call = call, .s = s, .watch = cli_watch_begin(call, "mechanisms", "mechanisms") };
    if (s->links > 0 && call->parsed.n_word > 0)
        return cli_usage(call, "either a file of chains or --links, not both");
    if (s->input != LW_INPUT_LEFT && s->links > 0 && s->dof > LW_INPUT_MAX)
        return cli_usage(call, "a mechanism has at most %d inputs, not %d; leave out --input", LW_INPUT_MAX, s->dof);
    if (s->joints && !read_kinds(s->joints, j.kinds))
        return cli_usage(call, "--joints takes letters of r, t, p, g, each once, not '%s'", s->joints);
    j.steps = (lw_mechanism_steps){ .ground = !s->no_ground, .kinds = s->joints ? j.kinds : NULL,
                                    .input = (lw_input_choice)s->input, .output = s->output,
                                    .slider_direction = s->slider_direction, .translating_cams = s->translating_cams };
    return run_job(&j);
}

const cli_command cli_mechanisms_command = {
    .name = "mechanisms",
    .words = "[FILE]",
    .title = "mechanisms of chains: ground link, kinds of joints, inputs and output, each way once",
    .examples =
        "  linkwright mechanisms --links 12 --count             75397 ways to choose the ground link\n"
        "  linkwright mechanisms --links 6 --joints r,t --input ground --output-link\n"
        "  linkwright mechanisms --links 6 --joints r,t --void  labellings left out, and why\n"
        "  linkwright mechanisms --links 4 --n2 2 --joints r,p,g --count\n"
        "  linkwright mechanisms --input ground --assur chains.g6\n"
        "  linkwright mechanisms --assur-groups 6               all Assur groups of six links\n"
        "  linkwright mechanisms --links 8 --multiple-joints    several pins on one axis\n",
    .about =
        "Chains come from FILE or standard input in any notation (docs/notation.md), or are all chains of --links\n"
        "and --dof that do not separate. Then follow the steps ground link, kinds of joints (--joints), F inputs\n"
        "(--input) and output link (--output-link). A step that the input has already decided is skipped. Of\n"
        "choices that differ only by a symmetry of the chain, one is listed. A combination of joint kinds is left\n"
        "out if, for general dimensions, the degree of freedom is not F or a joint never moves: a loop of sliders\n"
        "only, for example; --void prints each with its reason. The output link is neither the ground nor the\n"
        "driven link itself. A chain with a rigid part is bad input (exit code 3), and its links are named.\n"
        "--assur prints class and order after Artobolevsky, and the number of assembly modes if it is known.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 0,
    .most_words = 1,
    .run = run,
    .reads = CLI_TOPOLOGIES,
    .writes = "text",
};
