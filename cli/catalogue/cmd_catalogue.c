/* linkwright catalogue - a database of mechanisms: built, checked, asked; and the published tables, recounted. */
#include <string.h>

#include "base/clock.h"
#include "base/suggest.h"
#include "cli/catalogue/catalogue.h"
#include "enumerate/synthesis.h"

#define PLACE(member) offsetof(cli_catalogue_settings, member)

static const cli_option options[] = {
    { "links", 'l', CLI_INT, PLACE(links), "P", NULL, "build: number of links; curves: 4 (default) or 6", 3, LW_LINK_MAX, NULL, NULL },
    { "dof", 'd', CLI_INT, PLACE(dof), "F", "1", "build: degree of freedom", 1, LW_DOF_MAX, NULL, NULL },
    { "joints", 0, CLI_TEXT, PLACE(joints), "KINDS", "r",
      "build: kinds that joints may have, of r and t: every labelling that is not void", 0, 0, NULL, NULL },
    { "input", 'i', CLI_CHOICE, PLACE(input), "ground|any", "ground", "build: drive joints at the ground, or any", 0, 0,
      NULL, NULL },
    { "no-pictures", 0, CLI_FLAG, PLACE(no_pictures), NULL, NULL,
      "build: leave out where the joints of a chain are drawn", 0, 0, NULL, NULL },
    { "samples", 0, CLI_INT, PLACE(samples), "N", NULL, "curves: how many are drawn", 1, 2e9, NULL, NULL },
    { "type", 0, CLI_TEXT, PLACE(types), "NAME,...", "fourbar",
      "curves: types of linkages, as of fit, apart by commas, or all", 0, 0, NULL, NULL },
    { "curves", 0, CLI_CHOICE, PLACE(curves), "both|closed|open", "both",
      "curves: whole circuits, or pieces of them, or in turn", 0, 0, NULL, NULL },
    { "shape", 0, CLI_CHOICE, PLACE(shape), "file|closed|open", "file",
      "nearest: take the target as closed or open", 0, 0, NULL, NULL },
    { "list", 0, CLI_CHOICE, PLACE(list), "any|chains|mechanisms|linkages|structures", "any",
      "query, export: what is listed; any: the first of them that has all fields asked for", 0, 0, NULL, NULL },
    { "columns", 0, CLI_TEXT, PLACE(columns), "NAME,...", NULL,
      "query: fields that are shown, apart by commas", 0, 0, NULL, NULL },
    { "sort", 0, CLI_TEXT, PLACE(sort), "FIELDS", NULL,
      "query, export: by these fields; -FIELD: falling", 0, 0, NULL, NULL },
    { "results", 0, CLI_INT, PLACE(results), "N", NULL,
      "at most so many: nearest: curves, 20 without it; query, export: rows; html: chains", 1, 2e9, NULL, NULL },
    { "format", 'f', CLI_CHOICE, PLACE(format), "table|json|csv|graph6|lam|sentence|franke|edges|dot|graphml", "table",
      "query: table, json or csv; export: notation of chains and mechanisms, all but table and csv", 0, 0, NULL, NULL },
    { "sql", 0, CLI_FLAG, PLACE(sql), NULL, NULL,
      "query: the question is a SELECT of SQL, with the tables of docs/catalogue.md", 0, 0, NULL, NULL },
    { "fields", 0, CLI_FLAG, PLACE(fields), NULL, NULL, "query: list the fields instead", 0, 0, NULL, "sql" },
    { "wait", 0, CLI_REAL, PLACE(wait), "SECONDS", "5", "how long to wait for another program that writes to the file",
      0, 1e6, NULL, NULL },
    { "commit", 0, CLI_REAL, PLACE(commit), "SECONDS", "0.5",
      "how often what is done is written down for good: so much work is lost at most when the program is killed",
      0, 1e6, NULL, NULL },
    { "time", 0, CLI_REAL, PLACE(time), "SECONDS", "60",
      "check of a table: rows that would not be through by then are left out; others, when given: stop then", 0, 1e9,
      NULL, NULL },
    { "disagreeing", 0, CLI_FLAG, PLACE(disagreeing), NULL, NULL, "check: only the rows that do not agree", 0, 0, NULL,
      NULL },
    { .name = NULL }
};

static const struct {
    const char *name;
    int         least, most;                   /* words */
    const char *words;
    int       (*run)(const cli_call *call);
} actions[] = {
    { "build", 2, 2, "build FILE --links P", cli_catalogue_build },
    { "add", 3, 3, "add FILE RESULTS.json", cli_catalogue_add },
    { "curves", 2, 2, "curves FILE --samples N", cli_catalogue_curves },
    { "nearest", 3, 3, "nearest FILE TARGET.csv", cli_catalogue_nearest },
    { "query", 2, 3, "query FILE ['QUESTION']", cli_catalogue_query },
    { "export", 2, 3, "export FILE ['QUESTION']", cli_catalogue_export },
    { "check", 1, 2, "check [FILE or TABLE.csv]", cli_catalogue_check },
    { "html", 2, 2, "html FILE -o FOLDER", cli_catalogue_html },
};

#define N_ACTION (sizeof actions/sizeof *actions)

lw_status cli_catalogue_open(const cli_call *call, bool write, lw_store **store, lw_error *e)
{
    const cli_catalogue_settings *s = call->settings;
    lw_store_options o = { .write = write, .create = write, .wait = s->wait, .command = call->line };
    return lw_store_open(call->parsed.word[1], &o, store, e);
}

cli_catalogue_watch cli_catalogue_watch_begin(const cli_call *call, const char *what, const char *unit)
{
    const cli_catalogue_settings *s = call->settings;
    return (cli_catalogue_watch){ .call = call, .progress = cli_progress_begin(call, what, unit),
                                  .start = lw_clock_wall(), .limit = cli_given(&call->parsed, "time") ? s->time : 0 };
}

bool cli_catalogue_goes_on(cli_catalogue_watch *w, double done)
{
    cli_progress_show(&w->progress, done, w->total, NULL);
    w->over = w->over || (w->limit > 0 && lw_clock_wall() - w->start >= w->limit);
    return !cli_interrupted() && !w->over;
}

int cli_catalogue_watch_end(cli_catalogue_watch *w, int code)
{
    cli_progress_end(&w->progress);
    return w->over && code == CLI_DONE ? CLI_LIMIT : code;
}

static int run(const cli_call *call)
{
    const char *word = call->parsed.word[0], *names[N_ACTION];
    for (size_t i = 0; i < N_ACTION; i++) {
        names[i] = actions[i].name;
        if (strcmp(word, names[i]) != 0)
            continue;
        if (call->parsed.n_word < actions[i].least || call->parsed.n_word > actions[i].most)
            return cli_usage(call, "%s words: linkwright catalogue %s",
                             call->parsed.n_word < actions[i].least ? "too few" : "too many", actions[i].words);
        return actions[i].run(call);
    }
    const char *near = lw_suggest(word, names, N_ACTION);
    if (near)
        return cli_usage(call, "there is no action '%s'; did you mean '%s'?", word, near);
    return cli_usage(call, "there is no action '%s'; there are build, add, curves, nearest, query, export, check and "
                           "html", word);
}

const cli_command cli_catalogue_command = {
    .name = "catalogue",
    .words = "ACTION [FILE [WORD]]",
    .title = "a database of mechanisms; published counts, counted again",
    .examples =
        "  linkwright catalogue build atlas.db --links 8        all chains, ground links, inputs of eight links\n"
        "  linkwright catalogue build atlas.db --links 6 --joints r,t\n"
        "  linkwright catalogue add atlas.db results.jsonl      what fit --json printed, or linkages\n"
        "  linkwright catalogue curves atlas.db --links 4 --samples 1000000\n"
        "  linkwright catalogue curves atlas.db --links 6 --samples 1000000\n"
        "  linkwright catalogue nearest atlas.db target.csv --results 20\n"
        "  linkwright catalogue query atlas.db 'links=8 and planar and symmetry>1' --sort grounds\n"
        "  linkwright catalogue query atlas.db 'class=GCRR and error<0.01 and error_max<2mm' --format csv\n"
        "  linkwright catalogue query atlas.db 'SELECT links, count(*) FROM chain GROUP BY links' --sql\n"
        "  linkwright catalogue export atlas.db 'links=10 and not planar' --format lam\n"
        "  linkwright catalogue check atlas.db                  against the published counts, page by page\n"
        "  linkwright catalogue html atlas.db -o atlas          web pages: open atlas/index.html\n"
        "  linkwright catalogue check                    the table that comes with the program\n"
        "  linkwright catalogue check --time 600         with patience: 18 links take some minutes\n"
        "  linkwright catalogue check mine.csv --json    another table of the same columns\n",
    .about =
        "build puts every chain with P links and F freedoms into FILE, an SQLite database (docs/catalogue.md), with\n"
        "its structure and derivation, canonical label, symmetry, planarity, notations, ground links up to symmetry,\n"
        "inputs and Assur groups. One file takes any number of builds. A build that was stopped, or killed,\n"
        "goes on where it was when the same command is given again; nothing is lost or there twice.\n"
        "add takes linkages with their errors out of the output of fit --json (one after the other), or linkages by\n"
        "themselves; - is standard input. What is there already is passed over.\n"
        "curves draws coupler curves of four-link chains, whole circuits and pieces of them, spread evenly over\n"
        "the shapes of linkages, or with --links 6 those of Watt's and Stephenson's chains with an input that turns;\n"
        "nearest finds those most like a target, whatever its place, size, turn, direction\n"
        "and mirroring, and prints the linkages laid on it.\n"
        "query asks: tests of fields with = != < <= > >= ~ (pattern) and in (a, b), ranges 4..8, and, or, not,\n"
        "parentheses; query FILE --fields lists the fields. With --sql the question is one SELECT, which can only\n"
        "read. export writes what a question finds in a notation, linkages as add reads them.\n"
        "check FILE examines a catalogue: every page and reference, every label, and all numbers that are\n"
        "published. check [TABLE.csv] counts each row of the table of published counts again, as far as it is\n"
        "feasible within --time: the number published, the number counted, whether they agree, what was\n"
        "counted, and the source. A number that is known to be wrong is a known erratum. Any other disagreement\n"
        "makes the exit code 4.\n"
        "html writes a folder of web pages that need no server: an overview with search, a page a chain with its picture,\n"
        "notations to copy and ground links, and pages of moving linkages; --links P takes only chains with P links,\n"
        "--results N the first N. More than 200 MB of pages are only made with --results.\n",
    .options = options,
    .settings_size = sizeof(cli_catalogue_settings),
    .least_words = 1,
    .most_words = 3,
    .run = run,
};
