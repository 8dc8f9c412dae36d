/* linkwright numbers - number synthesis: links, joints, loops, and which links. */
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "enumerate/labelled.h"

typedef struct settings { int dof, loops, n2; bool labelled; } settings;

static const cli_option options[] = {
    { "dof", 'd', CLI_INT, offsetof(settings, dof), "F", "1", "degree of freedom", 0, LW_DOF_MAX, NULL, NULL },
    { "loops", 0, CLI_INT, offsetof(settings, loops), "L", NULL, "number of independent loops; without it 1 to 4", 1, LW_LOOP_MAX, NULL, NULL },
    { "n2", 0, CLI_INT, offsetof(settings, n2), "K", "0", "greatest number of joints with two degrees of freedom", 0, 3*LW_LOOP_MAX, NULL, NULL },
    { "labelled", 0, CLI_FLAG, offsetof(settings, labelled), NULL, NULL,
      "also print how many chains there are when the links have names 1 .. P, from generating functions", 0, 0, NULL, "n2" },
    { .name = NULL }
};

static void write_head(FILE *f, int n_loop, bool labelled)
{
    fputs("# L  n1  n2   P  ", f);
    for (int i = 2; i <= n_loop + 1; i++)
        fprintf(f, i < 10 ? "  P%d" : " P%d", i);
    fprintf(f, labelled ? "%40s\n" : "\n", "labelled chains");
}

/* labelled: digits, or NULL */
static void write_row(FILE *f, const lw_numbers *n, const lw_assortment *a, const char *labelled)
{
    fprintf(f, "%3d%4d%4d%4d  ", n->n_loop, n->n1, n->n2, n->n_link);
    for (int i = 2; i <= n->n_loop + 1; i++)
        fprintf(f, "%4d", a->n_with[i]);
    if (labelled)
        fprintf(f, "%40s", labelled);
    fputs(n->simple ? "\n" : "   two joints between the same links\n", f);
}

static void write_json(FILE *f, const lw_numbers *n, const lw_assortment *a, const char *labelled)
{
    cli_json j = cli_json_begin(f, 0);
    cli_json_object(&j, NULL);
    cli_json_int(&j, "dof", n->dof);
    cli_json_int(&j, "loops", n->n_loop);
    cli_json_int(&j, "n1", n->n1);
    cli_json_int(&j, "n2", n->n2);
    cli_json_int(&j, "links", n->n_link);
    cli_json_array(&j, "links_with_2_3_joints");
    for (int i = 2; i <= n->n_loop + 1; i++)
        cli_json_int(&j, NULL, a->n_with[i]);
    cli_json_end(&j);
    cli_json_bool(&j, "simple", n->simple);
    if (labelled)
        cli_json_text(&j, "labelled_chains", labelled);
    cli_json_end(&j);
}

/* Write the rows of n; returns how many.  LW_E_ARG, LW_E_MEMORY: the labelled chains cannot be counted. */
static lw_status write_rows(const cli_call *call, FILE *f, const lw_numbers *n, int *n_row, lw_error *e)
{
    const settings *s = call->settings;
    lw_chain_table table = { .n_row = 0 };
    char digits[LW_WHOLE_SIZE];
    lw_status status = s->labelled ? lw_labelled_chains(n, &table, e) : lw_chain_table_make(n, &table);
    for (size_t k = 0; k < table.n_row && status == LW_OK; k++, ++*n_row)
        (call->common.json ? write_json : write_row)(f, n, &table.row[k].links, s->labelled ?
                                                     lw_whole_print(table.row[k].n.n_labelled, digits) : NULL);
    lw_chain_table_free(&table);
    return status;
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    int first = s->loops ? s->loops : 1, last = s->loops ? s->loops : 4, n_row = 0;
    lw_output o;
    lw_error e = { 0 };
    if (s->labelled && s->dof < 1)
        return cli_usage(call, "--labelled counts chains that move; F must be 1 or more");
    if (cli_open(call, &o, &e) != LW_OK)
        return cli_fail(call, &e);
    if (!call->common.json)
        write_head(o.f, last, s->labelled);
    lw_status status = LW_OK;
    for (int l = first; l <= last; l++)
        for (int n2 = 0; n2 <= s->n2 && status == LW_OK; n2++) {
            lw_numbers n;
            if (lw_numbers_of(s->dof, l, n2, &n, &e) == LW_OK)      /* no assortment has this many: not an error */
                status = write_rows(call, o.f, &n, &n_row, &e);
        }
    if (n_row > 0 && status == LW_OK)
        return cli_close(call, &o, CLI_DONE);
    lw_output_abandon(&o);
    return cli_fail(call, &e);
}

const cli_command cli_numbers_command = {
    .name = "numbers",
    .words = "",
    .title = "numbers of links, joints and loops that fit a degree of freedom",
    .examples =
        "  linkwright numbers --dof 1 --loops 4            ten links: seven assortments\n"
        "  linkwright numbers --loops 2 --n2 2             with up to two joints of two degrees of freedom\n"
        "  linkwright numbers --dof 0 --loops 3 --json     rigid chains (Baranov trusses), as JSON\n"
        "  linkwright numbers --loops 9 --labelled         the labelled chains with 20 links: 2.98e29\n",
    .about =
        "One row for each solution of F = 3 (P - 1) - 2 n1 - n2, L = n1 + n2 - P + 1 and 2 (n1 + n2) = sum of i\n"
        "Pi. L is the number of independent loops, n1 and n2 are the numbers of joints with one and with two\n"
        "degrees of freedom, and P is the number of links, of which P2 are binary, P3 ternary and so on, up to L\n"
        "+ 1 joints. A row is marked if two links must share two joints.\n"
        "--labelled counts chains without making them: every chain counts P!/|symmetries| times, so it is a check of\n"
        "chains --count --labelled, and divided by P! a lower bound of the number of chains (docs/twenty-links.md).\n",
    .options = options,
    .settings_size = sizeof(settings),
    .most_words = 0,
    .run = run,
    .writes = "text",
};
