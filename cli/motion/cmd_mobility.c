/* linkwright mobility - degrees of freedom of a linkage, counted by formula and found from its motion. */
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/real.h"
#include "cli/motion/spatial.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "grammar/model/model.h"
#include "mbs/analysis/freedoms.h"
#include "mbs/constraints/adjust.h"

typedef struct settings {
    double tolerance;
    int    result;
} settings;

static const cli_option options[] = {
    { "tolerance", 0, CLI_REAL, offsetof(settings, tolerance), "E", "1e-12",
      "a posture is closed if its joints fit to within E times the size of the linkage; use more than the default for "
      "files whose numbers are rounded", 0, 1e-4, NULL, NULL },
    { "result", 'r', CLI_INT, offsetof(settings, result), "N", NULL,
      "number of the result in a file that 'linkwright fit' wrote, 1 is the best; without it the best", 1, 1e9, NULL, NULL },
    { .name = NULL }
};

/* ---- table ---------------------------------------------------------------------------------------- */

/* Names of links or joints, some of which are marked: by bits of a mask, or each by its own mark. */
typedef struct names { const char *first; size_t stride; int n; } names;

static names links_of(const lw_linkage *k) { return (names){ k->link_name[0], sizeof *k->link_name, k->n_link }; }
static names joints_of(const lw_linkage *k) { return (names){ k->joint->name, sizeof *k->joint, k->n_joint }; }
static names all_links(const lw_assembly *a) { return (names){ a->link_name[0], sizeof *a->link_name, a->n_link }; }

static bool is_marked(int i, uint64_t mask, const bool *mark) { return mark ? mark[i] : mask >> i & 1; }

static void names_text(FILE *f, names all, uint64_t mask, const bool *mark)
{
    const char *between = "";
    for (int i = 0; i < all.n; i++)
        if (is_marked(i, mask, mark)) {
            fprintf(f, "%s%s", between, all.first + (size_t)i*all.stride);
            between = ", ";
        }
}

/* A line of them; none: no line. */
static void write_names(FILE *f, const char *what, names all, uint64_t mask, const bool *mark, const char *more)
{
    int n = 0;
    for (int i = 0; i < all.n; i++)
        n += is_marked(i, mask, mark);
    if (n == 0)
        return;
    fprintf(f, "%-16s", what);
    names_text(f, all, mask, mark);
    fprintf(f, "%s\n", more);
}

static void json_names(cli_json *j, const char *key, names all, uint64_t mask, const bool *mark)
{
    cli_json_array(j, key);
    for (int i = 0; i < all.n; i++)
        if (is_marked(i, mask, mark))
            cli_json_text(j, NULL, all.first + (size_t)i*all.stride);
    cli_json_end(j);
}

static const char *verdict(const lw_mobility *m)
{
    if (m->kind == LW_MOBILITY_RIGID)
        return "rigid: nothing moves, not even of first order";
    if (m->kind == LW_MOBILITY_SHAKY)
        return "shaky: it yields, but cannot move";
    if (m->generic >= 0 && m->freedom > m->generic)
        return "moves because its dimensions are special";
    if (m->along > m->freedom)
        return "moves, and a part of it is shaky all the way";
    return "moves";
}

static void write_freedoms(FILE *f, const lw_linkage *linkage, const lw_mobility *m)
{
    if (m->least_freedom < m->freedom)
        fprintf(f, "%-16s%d on another motion curve through the posture\n", "", m->least_freedom);
    int own = lw_linkage_free_inputs(linkage);
    if (own > 0)
        fprintf(f, "%-16s%d of %d freedom%s by %d input%s\n", "driven", m->driven, m->freedom, lw_plural(m->freedom), own, lw_plural(own));
    if (own < linkage->n_input)
        fprintf(f, "%-16s%d input%s to the first, which takes as many freedoms\n", "tied", linkage->n_input - own,
                lw_plural(linkage->n_input - own));
    if (m->idle > 0) {
        fprintf(f, "%-16s%d freedom%s that reach%s no %s: ", "idle", m->idle, lw_plural(m->idle),
                m->idle == 1 ? "es" : "", linkage->n_tracer > 0 ? "tracer" : "other link");
        names_text(f, links_of(linkage), m->idle_links, NULL);
        fputc('\n', f);
    }
    write_names(f, "loose", links_of(linkage), linkage->n_input > 0 ? m->loose_links : 0, NULL, "  (move while every input stands still)");
    write_names(f, "still links", links_of(linkage), m->still_links, NULL, "");
    write_names(f, "still joints", joints_of(linkage), m->still_joints, NULL, "");
}

static void write_redundant(FILE *f, const lw_linkage *linkage, const lw_mobility *m)
{
    fprintf(f, "%-16s%d\n", "redundant", m->n_redundant);
    for (int i = 0; i < m->n_redundant; i++) {
        const lw_system_row *row = &m->redundant[i].row;
        fprintf(f, "%-16s%s of %s", "", row->what, linkage->joint[row->joint].name);
        fputs(m->redundant[i].joints ? "  follows from " : "  says nothing", f);
        names_text(f, joints_of(linkage), m->redundant[i].joints, NULL);
        fputc('\n', f);
    }
}

/* adjusted: greatest change of a dimension that made an overconstrained linkage fit [m]; 0: none. */
static void write_text(FILE *f, const lw_linkage *linkage, const lw_mobility *m, double adjusted)
{
    bool moves = m->kind == LW_MOBILITY_MOVES;
    fprintf(f, "%-16s%s\n", "verdict", verdict(m));
    if (adjusted > 0)
        fprintf(f, "%-16sjoints by up to %.3g m, so that the dimensions fit; as drawn the linkage does not move\n", "adjusted", adjusted);
    fprintf(f, "%-16s%d = 3*%d - %d  (freedoms of the links less rows of the joints)\n", "count", m->count, m->n_body, m->n_row);
    fprintf(f, "%-16s%d", "freedom", m->freedom);
    if (m->generic >= 0 && m->generic != m->freedom)
        fprintf(f, "  (%d with other dimensions)", m->generic);
    fputc('\n', f);
    if (moves)
        write_freedoms(f, linkage, m);
    fprintf(f, "%-16s%d in the posture", "first order", m->instant);
    if (moves)
        fprintf(f, ", %d along the motion", m->along);
    if (moves && m->instant > m->along)
        fputs("  (a singular posture)", f);
    fputc('\n', f);
    if (m->order > 1)
        fprintf(f, "%-16syields up to order %d\n", "", m->order);
    fprintf(f, "%-16s%d of %d rows%s\n", "rank", m->rank, m->n_row, moves ? ", along the motion" : "");
    write_redundant(f, linkage, m);
    if (moves)
        fprintf(f, "%-16s%.3g (sizes and radians), joints closed to %.2g m\n", "moved", m->distance, m->residual);
    else if (!isnan(m->misfit))
        fprintf(f, "%-16sit would move if joints opened by %.3g m\n", "misfit", m->misfit);
}

/* ---- models with more parts than a linkage holds ---------------------------------------------------- */

static void write_large_text(FILE *f, const lw_assembly *a, const lw_freedoms *m)
{
    int own = lw_assembly_free_inputs(a);
    bool moving = m->kind == LW_MOBILITY_MOVES;
    fprintf(f, "%-16s%s\n", "verdict", m->kind == LW_MOBILITY_RIGID ? "rigid: nothing moves, not even of first order"
            : moving ? "moves" : "shaky: it yields, but cannot move");
    fprintf(f, "%-16s%d = 3*%d - %d  (freedoms of the links less rows of the joints)\n", "count", m->count, m->n_body, m->n_row);
    fprintf(f, "%-16s%d\n", "freedom", m->freedom);
    if (moving && own > 0)
        fprintf(f, "%-16s%d of %d freedom%s by %d input%s\n", "driven", m->driven, m->freedom, lw_plural(m->freedom), own, lw_plural(own));
    write_names(f, "loose", all_links(a), 0, m->loose, "  (move while every input stands still)");
    write_names(f, "still links", all_links(a), 0, m->still, "");
    fprintf(f, "%-16s%d in the posture%s\n", "first order", m->instant, moving && m->instant > m->freedom ? "  (a singular posture)" : "");
    fprintf(f, "%-16s%d of %d rows%s\n", "rank", m->rank, m->n_row, moving ? ", along the motion" : "");
    fprintf(f, "%-16s%d\n", "redundant", m->n_redundant);
    for (int i = 0; i < m->n_redundant; i++)
        fprintf(f, "%-16s%s of %s\n", "", m->redundant[i].what, a->joint[m->redundant[i].joint].name);
    if (moving)
        fprintf(f, "%-16s%.3g (sizes and radians), joints closed to %.2g m\n", "moved", m->distance, m->residual);
}

static void write_large_json(FILE *f, const lw_assembly *a, const lw_freedoms *m)
{
    cli_json j = cli_json_begin(f, 2);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "verdict", lw_mobility_kind_text(m->kind));
    cli_json_int(&j, "count", m->count);
    cli_json_int(&j, "freedom", m->freedom);
    cli_json_int(&j, "first_order_posture", m->instant);
    cli_json_int(&j, "coordinates", m->n_q);
    cli_json_int(&j, "rows", m->n_row);
    cli_json_int(&j, "rank", m->rank);
    cli_json_array(&j, "redundant");
    for (int i = 0; i < m->n_redundant; i++) {
        cli_json_object(&j, NULL);
        cli_json_text(&j, "joint", a->joint[m->redundant[i].joint].name);
        cli_json_text(&j, "row", m->redundant[i].what);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_int(&j, "driven", m->driven);
    json_names(&j, "loose_links", all_links(a), 0, m->loose);
    json_names(&j, "still_links", all_links(a), 0, m->still);
    cli_json_real(&j, "moved", m->distance);
    cli_json_real(&j, "residual", m->residual);
    cli_json_end(&j);
}

static int run_large(const cli_call *call, const lw_model *model, double tolerance)
{
    lw_freedoms m;
    lw_output out;
    lw_error e = { 0 };
    if (lw_freedoms_find(model, tolerance, call->common.seed, &m, &e) != LW_OK) {
        if (e.status != LW_E_MEMORY)
            snprintf(e.file, sizeof e.file, "%s", call->parsed.word[0]);
        return cli_fail(call, &e);
    }
    if (cli_open(call, &out, &e) != LW_OK)
        return lw_freedoms_free(&m), cli_fail(call, &e);
    if (call->common.json)
        write_large_json(out.f, &model->linkage, &m);
    else
        write_large_text(out.f, &model->linkage, &m);
    lw_freedoms_free(&m);
    return cli_close(call, &out, CLI_DONE);
}

/* ---- JSON ----------------------------------------------------------------------------------------- */

static void json_redundant(cli_json *j, const lw_linkage *linkage, const lw_mobility *m)
{
    cli_json_array(j, "redundant");
    for (int i = 0; i < m->n_redundant; i++) {
        const lw_system_row *row = &m->redundant[i].row;
        cli_json_object(j, NULL);
        cli_json_text(j, "joint", linkage->joint[row->joint].name);
        cli_json_text(j, "row", row->what);
        json_names(j, "follows_from", joints_of(linkage), m->redundant[i].joints, NULL);
        cli_json_end(j);
    }
    cli_json_end(j);
}

static void write_json(FILE *f, const lw_linkage *linkage, const lw_mobility *m, double adjusted)
{
    bool moves = m->kind == LW_MOBILITY_MOVES;
    cli_json j = cli_json_begin(f, 2);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "verdict", lw_mobility_kind_text(m->kind));
    cli_json_int(&j, "count", m->count);
    cli_json_int(&j, "freedom", m->freedom);
    cli_json_int(&j, "least_freedom", m->least_freedom);
    cli_json_int(&j, "freedom_other_dimensions", m->generic);
    cli_json_int(&j, "first_order_posture", m->instant);
    cli_json_int(&j, "first_order_motion", m->along);
    cli_json_int(&j, "coordinates", m->n_q);
    cli_json_int(&j, "rows", m->n_row);
    cli_json_int(&j, "rank", m->rank);
    cli_json_int(&j, "rank_posture", m->posture_rank);
    json_redundant(&j, linkage, m);
    cli_json_int(&j, "driven", m->driven);
    cli_json_int(&j, "idle", m->idle);
    json_names(&j, "idle_links", links_of(linkage), m->idle_links, NULL);
    json_names(&j, "loose_links", links_of(linkage), m->loose_links, NULL);
    json_names(&j, "still_links", links_of(linkage), m->still_links, NULL);
    json_names(&j, "still_joints", joints_of(linkage), m->still_joints, NULL);
    cli_json_real(&j, "moved", m->distance);
    cli_json_real(&j, "residual", m->residual);
    cli_json_int(&j, "order", m->order);
    cli_json_real(&j, "misfit", moves ? NAN : m->misfit);
    cli_json_real(&j, "adjusted", adjusted);
    cli_json_end(&j);
}

/* An overconstrained linkage that is drawn with rounded numbers is made to fit, as simulate and trace do. */
static lw_status adjust(lw_linkage *k, double *by, lw_error *e)
{
    lw_system s;
    *by = 0;
    lw_status st = lw_system_make(k, NULL, 0, &s, e);
    double *q = st == LW_OK ? malloc((size_t)s.n_q*sizeof *q + 1) : NULL;
    if (st == LW_OK && !q)
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK) {
        lw_system_posture(&s, q);
        st = lw_system_adjust(&s, q, by, e);
        *by *= s.unit;
    }
    if (st == LW_OK)
        lw_system_write(&s, q, k);
    free(q);
    lw_system_free(&s);
    return st == LW_NOTHING ? LW_OK : st;
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    static lw_linkage k;
    static lw_mobility m;
    lw_mobility_options o = { .tolerance = s->tolerance, .seed = call->common.seed };
    lw_output out;
    lw_error e = { 0 };
    lw_model *model;
    lw_spatial *spatial;
    if (cli_read_any_model(call->parsed.word[0], s->result, &model, &spatial, &e) != LW_OK)
        return cli_fail(call, &e);
    if (spatial) {
        static const char *const planar[] = { "result", NULL };
        int code = cli_spatial_refuse(call, planar);
        code = code == CLI_DONE ? cli_spatial_mobility(call, spatial, s->tolerance, cli_given(&call->parsed, "tolerance")) : code;
        cli_free_spatial(spatial);
        return code;
    }
    if (!model->small) {
        int code = run_large(call, model, s->tolerance);
        cli_free_model(model);
        return code;
    }
    k = *model->small;
    cli_free_model(model);
    double adjusted = 0;
    bool as_drawn = cli_given(&call->parsed, "tolerance");
    if ((!as_drawn && adjust(&k, &adjusted, &e) != LW_OK) || lw_mobility_find(&k, &o, &m, &e) != LW_OK || cli_open(call, &out, &e) != LW_OK)
        return cli_fail(call, &e);
    if (call->common.json)
        write_json(out.f, &k, &m, adjusted);
    else
        write_text(out.f, &k, &m, adjusted);
    return cli_close(call, &out, CLI_DONE);
}

const cli_command cli_mobility_command = {
    .name = "mobility",
    .words = "MODEL.json",
    .title = "degrees of freedom of a linkage, redundant constraints, idle parts; rigid or movable",
    .examples =
        "  linkwright mobility examples/jansen.json          one degree of freedom\n"
        "  linkwright mobility examples/mobility/focal.json           moves although the count says -1\n"
        "  linkwright mobility bridge.json --json            the same as JSON\n"
        "  linkwright mobility examples/space/bennett.json   a model in space\n"
        "  linkwright mobility rounded.json --tolerance 1e-6          coordinates with six digits\n",
    .about =
        "'count' is the number of Gruebler's formula. 'freedom' is found by moving the linkage: it is displaced\n"
        "along its first-order motions, and its joints are closed again. If this gives a new posture every time,\n"
        "the linkage moves; if it always returns to the same posture, it is shaky. Ranks are computed at the new\n"
        "postures, so that a special posture is distinguished from special dimensions. 'redundant'\n"
        "names constraints that follow from those before them in the file: x and y of a pin, across and turn of a\n"
        "slider. 'idle' degrees of freedom do not move any tracer (without tracers: any other link). For a\n"
        "linkage that cannot move, 'misfit' is how far its joints must open so that it moves by 1/20 of its size.\n"
        "An overconstrained linkage drawn with rounded numbers (up to 2e-3 of its size off) is adjusted first, by least\n"
        "squares, in space too, as simulate and trace do; 'adjusted' says by how much. With --tolerance it is taken as\n"
        "drawn.\n"
        "Models of more than 32 links are analysed with sparse matrices; 'idle', 'misfit' and the order of shaky ones\n"
        "are not looked for, and 'redundant' does not name the joints that imply a constraint.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .least_words = 1,
    .most_words = 1,
    .run = run,
    .writes = "text",
};
