/* linkwright numbers - number synthesis: links, joints, loops, and which links. */
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "enumerate/synthesis.h"

typedef struct settings { int dof, loops, n2; } settings;

static const cli_option options[] = {
    { "dof", 'd', CLI_INT, offsetof(settings, dof), "F", "1", "degree of freedom", 0, LW_DOF_MAX, NULL, NULL },
    { "loops", 0, CLI_INT, offsetof(settings, loops), "L", NULL,
      "number of independent loops; without it 1 to 4", 1, LW_LOOP_MAX, NULL, NULL },
    { "n2", 0, CLI_INT, offsetof(settings, n2), "K", "0",
      "greatest number of joints with two degrees of freedom", 0, 3*LW_LOOP_MAX, NULL, NULL },
    { .name = NULL }
};

static void write_head(FILE *f, int n_loop)
{
    fputs("# L  n1  n2   P  ", f);
    for (int i = 2; i <= n_loop + 1; i++)
        fprintf(f, i < 10 ? "  P%d" : " P%d", i);
    fputc('\n', f);
}

static void write_row(FILE *f, const lw_numbers *n, const lw_assortment *a)
{
    fprintf(f, "%3d%4d%4d%4d  ", n->n_loop, n->n1, n->n2, n->n_link);
    for (int i = 2; i <= n->n_loop + 1; i++)
        fprintf(f, "%4d", a->n_with[i]);
    fputs(n->simple ? "\n" : "   two joints between the same links\n", f);
}

static void write_json(FILE *f, const lw_numbers *n, const lw_assortment *a)
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
    cli_json_end(&j);
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    int first = s->loops ? s->loops : 1, last = s->loops ? s->loops : 4, n_row = 0;
    lw_output o;
    lw_error e = { 0 };
    if (cli_open(call, &o, &e) != LW_OK)
        return cli_fail(call, &e);
    if (!call->common.json)
        write_head(o.f, last);
    for (int l = first; l <= last; l++)
        for (int n2 = 0; n2 <= s->n2; n2++) {
            lw_numbers n;
            lw_assortment a;
            if (lw_numbers_of(s->dof, l, n2, &n, &e) != LW_OK)
                continue;                            /* no assortment has this many: not an error */
            for (bool more = lw_assortment_first(&n, &a); more; more = lw_assortment_next(&n, &a), n_row++)
                (call->common.json ? write_json : write_row)(o.f, &n, &a);
        }
    if (n_row > 0)
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
        "  linkwright numbers --dof 0 --loops 3 --json     rigid chains (Baranov trusses), as JSON\n",
    .about =
        "One row for each solution of F = 3 (P - 1) - 2 n1 - n2, L = n1 + n2 - P + 1 and 2 (n1 + n2) = sum of i\n"
        "Pi. L is the number of independent loops, n1 and n2 are the numbers of joints with one and with two\n"
        "degrees of freedom, and P is the number of links, of which P2 are binary, P3 ternary and so on, up to L\n"
        "+ 1 joints. A row is marked if two links must share two joints.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .most_words = 0,
    .run = run,
    .writes = "text",
};
