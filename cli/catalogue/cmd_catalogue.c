/* linkwright catalogue - build, check and query a database of mechanisms; count the published tables again. */
#include "cli/catalogue/catalogue.h"
#include "enumerate/synthesis.h"

#define PLACE(member) offsetof(cli_catalogue_settings, member)

static const cli_option options[] = {
    { "links", 'l', CLI_INT, PLACE(links), "P", NULL,
      "build: number of links; curves: 4, 6 or 8, without it 4; html: only chains with P links; release: greatest number of "
      "links, without it 14",
      3, LW_LINK_MAX, NULL, NULL },
    { "dof", 'd', CLI_INT, PLACE(dof), "F", "1", "build: degree of freedom", 1, LW_DOF_MAX, NULL, NULL },
    { "joints", 0, CLI_TEXT, PLACE(joints), "KINDS", "r",
      "build: kinds of joints: r pins; r,t pins and sliders, in all combinations that have F degrees of freedom; curves: the "
      "same, with --links 6 or 8",
      0, 0, NULL, NULL },
    { "input", 'i', CLI_CHOICE, PLACE(input), "ground|any", "ground",
      "build: which joints may be driven, those at the ground or all", 0, 0, NULL, NULL },
    { "multiple-joints", 0, CLI_FLAG, PLACE(multiple), NULL, NULL,
      "build: also the chains with multiple joints (several links on one pin)", 0, 0, NULL, NULL },
    { "no-pictures", 0, CLI_FLAG, PLACE(no_pictures), NULL, NULL,
      "build: do not compute and store positions for drawing the chains", 0, 0, NULL, NULL },
    { "samples", 0, CLI_INT, PLACE(samples), "N", NULL, "curves: number of coupler curves to add", 1, 2e9, NULL, NULL },
    { "type", 0, CLI_TEXT, PLACE(types), "NAME,...", "fourbar",
      "curves: types of four-link mechanisms, named as in 'linkwright fit', or all", 0, 0, NULL, NULL },
    { "curves", 0, CLI_CHOICE, PLACE(curves), "both|closed|open", "both",
      "curves: closed curves, open parts of closed curves, or both by turns", 0, 0, NULL, NULL },
    { "part", 0, CLI_TEXT, PLACE(part), "R/M", NULL,
      "curves: draw part R of M (R = 1 .. M) of the samples; 'add' joins the parts", 0, 0, NULL, NULL },
    { "mpi", 0, CLI_FLAG, PLACE(mpi), NULL, NULL,
      "curves: share the work among all processes that mpirun started; process 0 writes", 0, 0, NULL, NULL },
    { "shape", 0, CLI_CHOICE, PLACE(shape), "file|closed|open", "file",
      "nearest: take the target as a closed or as an open curve; file: as its file says", 0, 0, NULL, NULL },
    { "full-turn", 0, CLI_FLAG, PLACE(full_turn), NULL, NULL, "nearest: only linkages whose input turns fully", 0, 0, NULL, NULL },
    { "min-transmission-angle", 0, CLI_REAL, PLACE(min_transmission), "DEG", NULL,
      "nearest: smallest transmission angle allowed while the curve is traced [degrees]", 0, 89.9, NULL, NULL },
    { "length-range", 0, CLI_RANGE, PLACE(length_range), "MIN:MAX", NULL,
      "nearest: limits of the lengths between pins of a link, in the unit of the target; the tracer is at most MAX from them", 0, 1e300, NULL, NULL },
    { "results", 0, CLI_INT, PLACE(results), "N", NULL,
      "nearest: number of curves to print, without it 20; query, export: greatest number of rows; html: greatest "
      "number of chains", 1, 2e9, NULL, NULL },
    { "list", 0, CLI_CHOICE, PLACE(list), "any|chains|mechanisms|linkages|structures", "any",
      "query, export: which list; any: the first of these lists that is not empty and has all fields of the query", 0, 0, NULL, NULL },
    { "columns", 0, CLI_TEXT, PLACE(columns), "NAME,...", NULL, "query: fields to print", 0, 0, NULL, NULL },
    { "sort", 0, CLI_TEXT, PLACE(sort), "FIELDS", NULL,
      "query, export: sort by these fields; a minus sign before a field reverses its order", 0, 0, NULL, NULL },
    { "format", 'f', CLI_CHOICE, PLACE(format), "table|json|csv|graph6|lam|sentence|franke|edges|dot|graphml", "table",
      "query: table, json or csv; export: notation of chains and mechanisms, all but table and csv", 0, 0, NULL, NULL },
    { "sql", 0, CLI_FLAG, PLACE(sql), NULL, NULL, "query: the query is an SQL SELECT on the tables of docs/catalogue.md", 0, 0, NULL, NULL },
    { "fields", 0, CLI_FLAG, PLACE(fields), NULL, NULL, "query: list the names of all fields and end", 0, 0, NULL, "sql" },
    { "wait", 0, CLI_REAL, PLACE(wait), "SECONDS", "5",
      "build, add, curves, nearest, query, export, check, html: how long to wait while another program writes to the catalogue", 0, 1e6, NULL, NULL },
    { "commit", 0, CLI_REAL, PLACE(commit), "SECONDS", "0.5",
      "build, add, curves, release: how often new rows are made permanent; if the program is killed, no more work than this is lost", 0, 1e6,
      NULL, NULL },
    { "time", 0, CLI_REAL, PLACE(time), "SECONDS", "60",
      "stop after this time and keep what was found; check of a table leaves out rows that would take longer, the "
      "other actions have no limit without this option", 0, 1e9, NULL, NULL },
    { "disagreeing", 0, CLI_FLAG, PLACE(disagreeing), NULL, NULL, "check: print only rows that do not agree", 0, 0, NULL, NULL },
    { .name = NULL }
};

static const cli_action actions[] = {
    { "build", "FILE --links P",
      "Adds every chain with P links and F degrees of freedom: its structure and derivation, canonical label,\n"
      "symmetry, planarity and notations, and its mechanisms: ground links up to symmetry, driven joints and\n"
      "Assur groups. --multiple-joints adds the chains with several links on one pin. A file can hold any number of builds. "
      "A build that was stopped or killed continues when the\n"
      "same command is given again.\n",
      1, 1, cli_catalogue_build, CLI_CATALOGUE, NULL },
    { "add", "FILE RESULTS.json or PART.db",
      "Adds linkages with their errors from the output of 'linkwright fit --json', or linkage files. Several\n"
      "results may follow one another; - is standard input. Linkages that the catalogue already holds are\n"
      "skipped. Curves of another catalogue, made with --part, are added too: the parts in order, 1, 2, 3, ...\n"
      "A table of motors, gears or amplifiers (CSV, docs/drive.md) is added for 'linkwright drive select'.\n",
      2, 2, cli_catalogue_add, CLI_CATALOGUE | CLI_LINKAGE | CLI_RESULTS, NULL },
    { "curves", "FILE --samples N",
      "Adds coupler curves of four-link mechanisms, closed ones and parts of them, spread evenly over the shapes\n"
      "of the linkages; with --links 6 or 8 curves of all mechanisms of pins, with --joints r,t of all with\n"
      "sliders too, that dyads solve and that fewer links cannot replace.\n"
      "Several machines each draw --part R/M into a file of their own, or share the work under mpirun with --mpi;\n"
      "the catalogue is the same (docs/cluster.md).\n",
      1, 1, cli_catalogue_curves, CLI_CATALOGUE, NULL },
    { "nearest", "FILE TARGET.csv",
      "Finds the coupler curves that are most like a target, at any place, size and angle, in either direction\n"
      "and mirrored, and prints their linkages, moved and scaled onto the target, nearest first. The answer is exact:\n"
      "no curve of the catalogue that meets the conditions is nearer. T is the least transmission angle; 'turns' says\n"
      "that the input turns fully. The linkage of an open curve has the range of its input that traces the target.\n",
      2, 2, cli_catalogue_nearest, CLI_CATALOGUE | CLI_TARGET | CLI_DRAWING, NULL },
    { "query", "FILE ['QUERY']",
      "Prints the rows that match a query. A query compares fields with = != < <= > >= ~ (pattern), with a list, as\n"
      "in (a, b), or with a range, as 4..8. It joins comparisons by and, or, not and parentheses.\n"
      "'query FILE --fields' lists the fields.\n",
      1, 2, cli_catalogue_query, CLI_CATALOGUE, NULL },
    { "export", "FILE ['QUERY']",
      "Writes the chains or mechanisms that match a query, one per line in a notation; linkages in the form that\n"
      "'add' reads.\n",
      1, 2, cli_catalogue_export, CLI_CATALOGUE, NULL },
    { "check", "[FILE or TABLE.csv]",
      "With a catalogue: checks every page and reference of the database, every label, and all published counts.\n"
      "Otherwise: counts each row of the table of published counts again, as far as --time allows, and prints the\n"
      "published number, the number counted, whether they agree, what was counted, and the source. A published\n"
      "number that is known to be wrong is called a known erratum. Any other disagreement makes the exit code 4.\n",
      0, 1, cli_catalogue_check, CLI_CATALOGUE, NULL },
    { "html", "FILE -o FOLDER",
      "Writes web pages that need no server: an overview with search, a page for each chain with its picture, its\n"
      "notations and its ground links, and pages of moving linkages. More than 200 MB of pages are made only with\n"
      "--results.\n",
      1, 1, cli_catalogue_html, CLI_CATALOGUE, NULL },
    { "release", "-o FOLDER",
      "Writes a data set that others can cite and check: all chains up to 14 links and 10 degrees of freedom (graph6),\n"
      "their mechanisms up to 10 links, all Assur groups up to 12 links, a catalogue, the counts, checksums, a licence\n"
      "and how to cite it. The same version of linkwright writes the same bytes. --links P: chains up to P links,\n"
      "mechanisms up to P - 4 and Assur groups up to P - 2.\n",
      0, 0, cli_catalogue_release, CLI_UNKNOWN, NULL },
    { .name = NULL }
};

const cli_command cli_catalogue_command = {
    .name = "catalogue",
    .words = "ACTION [FILE [WORD]]",
    .title = "a database of mechanisms and coupler curves; published counts, counted again",
    .examples =
        "  linkwright catalogue build atlas.db --links 8        all mechanisms with eight links\n"
        "  linkwright catalogue build atlas.db --links 6 --joints r,t --multiple-joints\n"
        "  linkwright catalogue add atlas.db results.jsonl      results of fit --json, or linkages\n"
        "  linkwright catalogue curves atlas.db --links 4 --samples 1000000\n"
        "  linkwright catalogue curves atlas.db --links 6 --joints r,t --samples 1000000\n"
        "  linkwright catalogue curves atlas.db --links 8 --joints r,t --samples 1000000\n"
        "  linkwright catalogue curves part-3.db --links 6 --samples 10000000 --part 3/20\n"
        "  linkwright catalogue nearest atlas.db target.csv --results 20\n"
        "  linkwright catalogue nearest atlas.db target.csv --full-turn --min-transmission-angle 35 --length-range 5:80\n"
        "  linkwright catalogue query atlas.db 'links=8 and planar and symmetry>1' --sort grounds\n"
        "  linkwright catalogue query atlas.db 'class=GCRR and error<0.01 and error_max<2mm' --format csv\n"
        "  linkwright catalogue query atlas.db 'SELECT links, count(*) FROM chain GROUP BY links' --sql\n"
        "  linkwright catalogue export atlas.db 'links=10 and not planar' --format lam\n"
        "  linkwright catalogue check atlas.db                  the database and its counts\n"
        "  linkwright catalogue html atlas.db -o atlas          web pages: open atlas/index.html\n"
        "  linkwright catalogue release -o dataset              chains, mechanisms, Assur groups, checksums\n"
        "  linkwright catalogue check                           the table of published counts\n"
        "  linkwright catalogue check --time 600                longer counts too: 18 links take some minutes\n"
        "  linkwright catalogue check mine.csv --json           another table with the same columns\n",
    .about =
        "A catalogue is one SQLite file (docs/catalogue.md). 'linkwright help catalogue ACTION' shows one action.\n",
    .options = options,
    .settings_size = sizeof(cli_catalogue_settings),
    .actions = actions,
};
