/* cli/motion/spatial_mobility.c - degrees of freedom of a spatial model, as text or JSON. */
#include "base/number.h"
#include "cli/motion/spatial.h"
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "mbs/space/space_adjust.h"
#include "mbs/space/space_mobility.h"

/* Beside its idle spins. */
static bool moves(const lw_space_mobility *m) { return m->freedom > m->idle; }
static bool is_shaky(const lw_space_mobility *m) { return !moves(m) && (m->shaky || m->instant > m->freedom); }

static const char *verdict(const lw_space_mobility *m)
{
    return is_shaky(m) ? m->freedom > 0 ? "shaky: it yields, but only idle links move" : "shaky: it yields, but cannot move"
         : m->freedom == 0 ? "rigid: nothing moves, not even of first order"
         : !moves(m) ? "rigid: nothing moves but idle links"
         : m->freedom > m->count && m->count < 1 ? "moves although the count says it cannot: its dimensions are special"
         : "moves";
}

static const char *name_of(const lw_spatial *m, int joint)
{
    return joint < m->n_joint ? m->joint[joint].name : m->coupling[joint - m->n_joint].name;
}

static void write_text(FILE *f, const lw_space_adjusted *a, const lw_space_mobility *m)
{
    const lw_spatial *model = &a->model;
    lw_vec3 normal;
    if (a->moved > 0)
        fprintf(f, "%-16sjoints by up to %.3g m, axes by %.3g rad, so that the dimensions fit; as drawn the linkage does not move\n", "adjusted", a->moved,
                a->turned);
    fprintf(f, "%-16s%s\n", "verdict", verdict(m));
    fprintf(f, "%-16s%d = 6*%d - %d  (freedoms of the links less rows of the joints%s)\n", "count", m->count, m->n_body,
            m->n_row, model->n_coupling ? " and couplings" : "");
    fprintf(f, "%-16s%d", "freedom", m->freedom);
    if (m->idle > 0 && m->freedom > 0)
        fprintf(f, "  (%d without idle spins)", m->freedom - m->idle);
    fputc('\n', f);
    if (m->idle > 0) {
        fprintf(f, "%-16s%d spin%s between ball joints, held in every analysis: ", "idle", m->idle, lw_plural(m->idle));
        for (int i = 0; i < m->idle; i++)
            fprintf(f, "%s%s", i ? ", " : "", model->body[m->idle_link[i]].name);
        fputc('\n', f);
    }
    fprintf(f, "%-16s%d in the posture", "first order", m->instant);
    if (m->freedom > 0 && m->instant > m->freedom)
        fputs("  (a singular posture)", f);
    fputc('\n', f);
    fprintf(f, "%-16s%d of %d rows%s\n", "rank", m->rank, m->n_row, m->freedom > 0 ? ", along the motion" : "");
    fprintf(f, "%-16s%d\n", "redundant", m->n_redundant);
    for (int i = 0; i < m->n_redundant; i++)
        fprintf(f, "%-16s%s of %s\n", "", m->redundant[i].row, name_of(model, m->redundant[i].joint));
    if (lw_spatial_is_planar(model, &normal))
        fprintf(f, "%-16saxes are parallel to [%.6g, %.6g, %.6g]: the motion is planar; written with two numbers a place, it "
                "is solved faster\n", "planar", normal.x, normal.y, normal.z);
    if (m->freedom > 0)
        fprintf(f, "%-16s%.3g (sizes and radians), joints closed to %.2g m\n", "moved", m->moved, m->residual);
}

static void write_json(FILE *f, const lw_space_adjusted *a, const lw_space_mobility *m)
{
    const lw_spatial *model = &a->model;
    lw_vec3 normal;
    cli_json j = cli_json_begin(f, 2);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "verdict", moves(m) ? "moves" : is_shaky(m) ? "shaky" : "rigid");
    cli_json_int(&j, "count", m->count);
    cli_json_int(&j, "freedom", m->freedom);
    cli_json_int(&j, "first_order_posture", m->instant);
    cli_json_int(&j, "coordinates", 6*m->n_body);
    cli_json_int(&j, "rows", m->n_row);
    cli_json_int(&j, "rank", m->rank);
    cli_json_array(&j, "redundant");
    for (int i = 0; i < m->n_redundant; i++) {
        cli_json_object(&j, NULL);
        cli_json_text(&j, "joint", name_of(model, m->redundant[i].joint));
        cli_json_text(&j, "row", m->redundant[i].row);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_int(&j, "idle", m->idle);
    cli_json_array(&j, "idle_links");
    for (int i = 0; i < m->idle; i++)
        cli_json_text(&j, NULL, model->body[m->idle_link[i]].name);
    cli_json_end(&j);
    cli_json_bool(&j, "planar", lw_spatial_is_planar(model, &normal));
    cli_json_real(&j, "moved", m->moved);
    cli_json_real(&j, "residual", m->residual);
    cli_json_real(&j, "adjusted", a->moved);
    cli_json_real(&j, "adjusted_turn", a->turned);
    cli_json_end(&j);
}

/* An overconstrained linkage whose numbers are rounded is rigid as drawn, and moves with its joints a little open. */
static lw_status note_rounded(const cli_call *call, const lw_spatial *model, double tolerance, lw_error *e)
{
    static const double rounded = 1e-4, open = 1e-5;       /* a shaky linkage opens more */
    lw_space_mobility m;
    lw_status s = tolerance < rounded ? lw_space_mobility_find(model, rounded, call->common.seed, cli_stop_flag(), &m, e) : LW_NOTHING;
    if (s == LW_OK && m.freedom > 0 && m.residual < open*lw_spatial_size(model))
        cli_note(call, "with joints open by up to %.2g m it has %d freedom%s (\"--tolerance %g\"): an overconstrained linkage whose numbers are rounded? "
                 "More digits let it move", m.residual, m.freedom, lw_plural(m.freedom), rounded);
    if (s == LW_OK)
        lw_space_mobility_free(&m);
    return s == LW_NOTHING ? LW_OK : s;
}

int cli_spatial_mobility(const cli_call *call, const lw_spatial *model, double tolerance, bool as_drawn)
{
    lw_space_adjusted adjusted = { .model = *model };
    lw_space_mobility m = { 0 };
    lw_output out;
    lw_error e = { 0 };
    lw_status s = as_drawn ? LW_OK : lw_space_adjust(model, &adjusted, &e);
    if (s < 0 || (s = lw_space_mobility_find(&adjusted.model, tolerance, call->common.seed, cli_stop_flag(), &m, &e)) != LW_OK
        || (s = cli_open(call, &out, &e)) != LW_OK) {
        lw_space_adjusted_free(&adjusted), lw_space_mobility_free(&m);
        return cli_fail(call, &e);
    }
    if (call->common.json)
        write_json(out.f, &adjusted, &m);
    else
        write_text(out.f, &adjusted, &m);
    s = m.freedom == 0 ? note_rounded(call, model, tolerance, &e) : LW_OK;
    lw_space_adjusted_free(&adjusted), lw_space_mobility_free(&m);
    return cli_close(call, &out, s == LW_OK ? CLI_DONE : cli_fail(call, &e));
}
