/* cli/fit/fit_print.c - print the results of a fit as a table and as JSON. */
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/real.h"
#include "cli/fit/fit.h"

static double length(const cli_fit_set *s, double metres)
{
    return metres/s->target.units.metre;
}

lw_fitted cli_fitted(const cli_fit_set *s)
{
    return (lw_fitted){ s->name, &s->target, s->spec.task, &s->search.found.fit, &s->search.results };
}

/* Candidate of result i. */
static const lw_candidate *candidate_of(const cli_fit_set *s, int i)
{
    return &s->search.found.fit.candidate[s->search.results.candidate[i]];
}

/* ---- table ------------------------------------------------------------------------------------ */

static void print_robustness(const cli_fit_set *s, FILE *f);

/* Say at which limits a result is, and which it does not keep. */
static void limits_row(const lw_fit_report *r, FILE *f)
{
    char text[LW_ACTIVE_MAX*sizeof r->active[0]];
    lw_fit_report_active(r, text, sizeof text);
    if (text[0])
        fprintf(f, "     at its limit: %s\n", text);
    if (r->broken)
        fprintf(f, "     beyond the limits: %s\n", r->broken_text);
}

/* Width of the column of types. */
static int title_width(const cli_fit_set *s)
{
    size_t width = 16;
    for (int i = 0; i < s->search.results.n; i++) {
        size_t own = strlen(lw_family_title(candidate_of(s, i)->family));
        width = own > width ? own : width;
    }
    return (int)width;
}

/* With default limits the rows are ordered by what they count as, else by the objective. */
static bool has_order(const cli_fit_set *s)
{
    return s->spec.by_default && !s->is_exact;
}

static void table_row(const cli_fit_set *s, int i, int width, FILE *f)
{
    const lw_fit_report *r = &s->search.results.report[i];
    const lw_candidate *c = candidate_of(s, i);
    double deg = 180/LW_PI;
    char class[24] = "-";
    if (r->has_class)
        snprintf(class, sizeof class, "%s%s", r->barker.symbol, lw_fitted_near_change_point(r) ? "*" : "");
    fprintf(f, "%3d  %-*s %-6s", i + 1, width, lw_family_title(c->family), class);
    if (!lw_task_has_place(s->spec.task))
        fprintf(f, " %9.4g %9.4g @%-4zu", r->angle_mean*deg, r->angle_max*deg, r->worst + 1);
    else
        fprintf(f, " %9.3g%% %9.4g %9.4g @%-4zu", r->error_percent, length(s, r->error_mean), length(s, r->error_max), r->worst + 1);
    if (s->spec.task == LW_TASK_MOTION)
        fprintf(f, " %9.4g %9.4g", r->angle_mean*deg, r->angle_max*deg);
    if (lw_task_has_place(s->spec.task))
        fprintf(f, " %9.4g", length(s, lw_fit_report_stray(r)));
    if (has_order(s))
        fprintf(f, " %9.3g%%", 100*r->counts_as);
    else
        fprintf(f, " %10.6g", lw_fit_report_objective(c, r));
    fprintf(f, "  %4.0f..%-4.0f %-5s", r->transmission_min*deg, r->transmission_max*deg, lw_fit_report_input(r));
    if (lw_task_has_place(s->spec.task))
        fprintf(f, " %5.3g ", r->size/s->target.extent);
    else
        fputs(c->intended.sense < 0 ? " <" : " ", f);
    if (s->is_exact)
        cli_fit_exact_row(s, i, f);
    const lw_fitted fitted = cli_fitted(s);
    lw_fitted_dimensions(&fitted, i, f);
    fputc('\n', f);
    limits_row(r, f);
    cli_fit_points_row(s, i, f);
}

/* Explain the * after a class, if there is one. */
static void print_marks(const cli_fit_set *s, FILE *f)
{
    for (int i = 0; i < s->search.results.n; i++)
        if (lw_fitted_near_change_point(&s->search.results.report[i])) {
            fprintf(f, "* near a change point: it is nearer than %g perimeters, so small errors of the lengths "
                    "make the motion another one\n", LW_NEAR_CHANGE_POINT);
            return;
        }
}

/* Print the error for each number of links. */
static void print_stages(const cli_fit_set *s, FILE *f)
{
    for (int k = 0; k < s->search.n_links; k++) {
        const lw_links_summary *l = &s->search.by_links[k];
        if (l->n_stage == 0)
            continue;
        fprintf(f, "least squared error with up to %d links: ", l->links);
        if (l->best < 0)
            fputs(s->spec.by_default ? "none near the target and within the limits" : "none", f);
        else if (!lw_task_has_place(s->spec.task))
            fprintf(f, "%.4g deg in the mean", s->search.results.report[l->best].angle_mean*180/LW_PI);
        else
            fprintf(f, "%.4g %% of the path", s->search.results.report[l->best].error_percent);
        if (l->best >= 0)
            fprintf(f, " (%s)", lw_family_title(candidate_of(s, l->best)->family));
        fprintf(f, "; %ld start%s, %ld local fit%s, %.1f s\n", l->starts, lw_plural(l->starts), l->improved, lw_plural(l->improved), l->seconds);
    }
}

/* Limits of lw_fit_results.unfit_by. */
static const struct { const char *word, *option, *key; } limits[LW_LIMITS] = {
    { "transmission angle", "--min-transmission-angle", "transmission" }, { "ratio of lengths", "--length-ratio", "ratio" },
    { "size", "--max-size", "size" }, { "distance from a change point", "--class-margin", "class_margin" },
    { "motion without limits, along the target", "--through-limits", "motion" }
};

/* Say how many linkages are left out because of limits, and which. */
static void print_unfit(const cli_fit_set *s, FILE *f)
{
    const lw_fit_results *r = &s->search.results;
    const char *between = ": ";
    if (r->n_unfit == 0)
        return;
    fprintf(f, "%d linkage%s found and left out beyond the limits", r->n_unfit, lw_plural(r->n_unfit));
    for (int i = 0; i < LW_LIMITS; i++)
        if (r->unfit_by[i] > 0) {
            fprintf(f, "%s%d by %s (%s)", between, r->unfit_by[i], limits[i].word, limits[i].option);
            between = ", ";
        }
    fputc('\n', f);
}

static void print_searched(const long state[LW_FIT_STATES], FILE *f)
{
    fprintf(f, "; %ld searched, %ld of them with a linkage that closes", state[LW_FIT_LOOKED] + state[LW_FIT_CLOSED], state[LW_FIT_CLOSED]);
    if (state[LW_FIT_UNABLE] > 0)
        fprintf(f, "; %ld that cannot do this task", state[LW_FIT_UNABLE]);
    if (state[LW_FIT_UNREACHED] > 0)
        fprintf(f, "; %ld not reached before the search ended", state[LW_FIT_UNREACHED]);
    fputc('\n', f);
}

/* Print which topologies were searched and which were not, with the reason. */
static void print_topologies(const cli_fit_set *s, FILE *f)
{
    for (int k = 0; k < s->search.n_mechanisms; k++) {
        const lw_mechanism_summary *m = &s->search.mechanisms[k];
        const lw_mechanism_tally *t = &m->tally;
        const char *between = "";
        fprintf(f, "%d links%s: %ld chain%s, %ld ground choice%s, %ld with tracer link, %ld with any input", m->links,
                m->two_freedoms ? " and joints of two freedoms" : "", t->n_chain, lw_plural(t->n_chain),
                t->n_ground,
                lw_plural(t->n_ground), t->n_pair, t->n_driven);
        fprintf(f, s->search.freedoms > 1 ? "s (F = %d): " : ": ", s->search.freedoms);
        for (int i = 0; i < LW_PAIR_OUTCOMES; i++)
            if (t->outcome[i] > 0) {
                fprintf(f, "%s%ld %s", between, t->outcome[i], lw_pair_outcome_text((lw_pair_outcome)i));
                between = ", ";
            }
        if (s->search.freedoms > 1)
            fprintf(f, "; %ld with all inputs at the ground, %ld of them left out, the others by %d ratios", t->n_set,
                    t->n_set_out, s->search.n_input_ratio);
        print_searched(m->state, f);
    }
    if (s->search.uncounted_links > 0)
        fprintf(f, "mechanisms with %d links and more were not searched: counting them takes more than half of --time\n",
                s->search.uncounted_links);
}

void cli_fit_table(const cli_fit_set *s, FILE *f)
{
    const int width = title_width(s);
    const char *order = has_order(s) ? " counts as" : " objective";
    fprintf(f, "%s: %s, timing %s, %zu point%s, %s\n", s->path, lw_task_table[s->spec.task].name,
            lw_timing_names[s->spec.timing], s->target.n, lw_plural((long long)s->target.n), s->target.closed ? "closed" : "open");
    if (!lw_task_has_place(s->spec.task))
        fprintf(f, "  #  %-*s class  mean[deg]  max[deg] @point %s  transm.    input  dimensions, angles in deg\n", width, "type", order);
    else
        fprintf(f, "  #  %-*s class  of path       mean       max @point %s     stray %s  "
                "transm.    input  size  dimensions [%s, rad]\n", width, "type",
                s->spec.task == LW_TASK_MOTION ? " mean[deg]  max[deg]" : "", order,
                s->target.units.length[0] ? s->target.units.length : "unit");
    for (int i = 0; i < s->search.results.n; i++)
        table_row(s, i, width, f);
    print_marks(s, f);
    if (has_order(s) && s->search.results.n > 0)
        fprintf(f, "counts as: %s\n", lw_fitted_order(s->spec.task));
    if (s->has_tolerances)
        print_robustness(s, f);
    if (s->spec.angle_length > 0 && (s->target.theta || s->target.n_also > 0))
        fprintf(f, "an angle error of 1 rad counts as %.4g %s (--angle-length)\n", length(s, s->spec.angle_length),
                s->target.units.length[0] ? s->target.units.length : "units");
    if (!lw_task_has_place(s->spec.task))
        fprintf(f, "the input is at input0 + angle (<: it turns the other way, input0 - angle), counted from the line of the fixed pivots; "
                "the angle of the output's link plus tool0 is theta\n");
    if (s->search.found.n_stage > 1)
        print_stages(s, f);
    print_unfit(s, f);
    print_topologies(s, f);
    cli_fit_points_summary(s, f);
    if (s->is_exact)
        cli_fit_exact_summary(s, f);
    else
        fprintf(f, "%d result%s, each simulated twice; %ld start%s, %ld local fit%s, %ld evaluation%s, "
                "%.2f s; stopped: %s\n\n", s->search.results.n, lw_plural(s->search.results.n),
                s->search.found.fit.starts, lw_plural(s->search.found.fit.starts), s->search.found.fit.improved, lw_plural(s->search.found.fit.improved),
                s->search.found.fit.evals, lw_plural(s->search.found.fit.evals), s->search.found.fit.seconds,
                cli_stop_text(s->search.found.fit.stop));
}

/* ---- JSON --------------------------------------------------------------------------------------- */

static void json_class(const lw_fit_report *r, cli_json *j)
{
    cli_json_text(j, "class", r->has_class ? r->barker.symbol : NULL);
    if (!r->has_class)
        return;
    cli_json_text(j, "class_name", r->barker.name);
    cli_json_real(j, "class_margin", r->barker.margin);
    cli_json_bool(j, "near_change_point", lw_fitted_near_change_point(r));
}

static void json_cognates(const cli_fit_set *s, const lw_fit_report *r, cli_json *j)
{
    cli_json_array(j, "cognates");
    for (int i = 0; i < r->n_cognate; i++) {
        cli_json_object(j, NULL);
        for (int d = 0; d < 9; d++)
            cli_json_real(j, r->dim_name[d], lw_fitted_value(&s->target.units, r, d, r->cognate[i][d]));
        cli_json_real(j, "mode", r->cognate_mode[i]);
        cli_json_end(j);
    }
    cli_json_end(j);
}

static void json_errors(const cli_fit_set *s, const lw_fit_report *r, cli_json *j)
{
    cli_json_real(j, "error_mean", length(s, r->error_mean));
    cli_json_real(j, "error_rms", length(s, r->error_rms));
    cli_json_real(j, "error_max", length(s, r->error_max));
    cli_json_int(j, "error_worst", (long long)r->worst + 1);
    cli_json_real(j, "error_percent", r->error_percent);
    cli_json_real(j, "error_curve", length(s, r->curve_max));
    cli_json_real(j, "stray", length(s, lw_fit_report_stray(r)));
    cli_json_real(j, "stray_to_curve", length(s, r->stray.to_curve));
    cli_json_real(j, "stray_to_target", length(s, r->stray.to_target));
    cli_json_real(j, "chamfer", r->likeness.chamfer);
    cli_json_real(j, "ordered", r->likeness.ordered);
    if (lw_task_has_angle(s->spec.task)) {
        cli_json_real(j, "angle_error_mean", r->angle_mean);
        cli_json_real(j, "angle_error_max", r->angle_max);
    }
}

/* Value of one input in the user's unit: angles in radians. */
static double input_value(const cli_fit_set *s, const lw_fit_report *r, double si)
{
    return lw_joint_slides(r->linkage.joint[r->linkage.input[0].joint].kind) ? length(s, si) : si;
}

/* Print where joints reverse; inputs as in `inputs`. */
static void json_reversals(const cli_fit_set *s, const lw_fit_report *r, bool limit, cli_json *j)
{
    cli_json_array(j, limit ? "limits" : "dead_points");
    for (int i = 0; i < r->n_reversal; i++) {
        const lw_reversal *v = &r->reversal[i];
        if (v->limit != limit)
            continue;
        cli_json_object(j, NULL);
        cli_json_text(j, "joint", r->linkage.joint[v->joint].name);
        cli_json_text(j, "link", r->linkage.link_name[v->link]);
        cli_json_real(j, "input", input_value(s, r, v->input));
        cli_json_end(j);
    }
    cli_json_end(j);
}

/* Print inputs in the sense in which the linkage's joint turns. */
static void json_inputs(const cli_fit_set *s, const lw_candidate *c, const lw_fit_report *r, cli_json *j)
{
    double *v = malloc(sizeof *v*s->target.n);
    if (!v)
        cli_lost();
    for (size_t i = 0; v && i < s->target.n; i++)
        v[i] = input_value(s, r, r->input_turns_per_period*c->input[i]);
    cli_json_reals(j, "inputs", v, v ? s->target.n : 0);
    free(v);
}

/* For a motion through limits: the number of its legs, and the leg of each station, named by the assembly mode. */
static void json_modes(const cli_fit_set *s, const lw_candidate *c, const lw_fit_report *r, cli_json *j)
{
    if (!c->mode_of)
        return;
    if (r->legs > 0)
        cli_json_int(j, "legs", r->legs);
    cli_json_array(j, "modes");
    for (size_t i = 0; i < s->target.n; i++) {
        char text[LW_DYAD_MAX + 1] = "";
        for (int d = 0; d < c->n_dyad && d < LW_DYAD_MAX; d++)
            text[d] = c->mode_of[i*(size_t)c->n_dyad + (size_t)d] < 0 ? '-' : '+';
        cli_json_text(j, NULL, text);
    }
    cli_json_end(j);
}

/* Size, and the limits that the result is at or does not keep. */
static void json_limits(const cli_fit_set *s, const lw_fit_report *r, cli_json *j)
{
    cli_json_real(j, "size", length(s, r->size));
    cli_json_real(j, "as_made", s->target.extent > 0 ? length(s, r->as_made) : r->as_made);
    cli_json_real(j, "counts_as", r->counts_as);
    cli_json_real(j, "size_over_path", s->target.extent > 0 ? r->size/s->target.extent : NAN);
    cli_json_real(j, "length_least", length(s, r->length_least));
    cli_json_real(j, "length_most", length(s, r->length_most));
    cli_json_array(j, "at_limit");
    for (int i = 0; i < r->n_active; i++)
        cli_json_text(j, NULL, r->active[i]);
    cli_json_end(j);
    cli_json_text(j, "beyond_limits", r->broken ? r->broken_text : NULL);
}

static void json_motion(const cli_fit_set *s, const lw_candidate *c, const lw_fit_report *r, cli_json *j)
{
    cli_json_bool(j, "crank", r->turns);
    cli_json_text(j, "input_motion", lw_fit_report_input(r));
    if (r->input_turns_per_period > 1)
        cli_json_int(j, "laps", r->input_turns_per_period);
    if (r->circuits)
        cli_json_int(j, "circuits", r->circuits);
    cli_json_reals(j, "input_range", (double[]){ input_value(s, r, r->input_first),
                                                input_value(s, r, r->input_last) }, 2);
    json_reversals(s, r, true, j);
    json_reversals(s, r, false, j);
    cli_json_int(j, "branch", (c->mode_of ? c->mode_of[0] : c->intended.mode[0]) > 0 ? 1 : -1);
    json_modes(s, c, r, j);
    cli_json_real(j, "transmission_min", r->transmission_min);
    cli_json_real(j, "transmission_max", r->transmission_max);
    bool slide = lw_joint_slides(r->linkage.joint[r->linkage.input[0].joint].kind);
    double m = s->target.units.metre;
    cli_json_real(j, "acceleration_max", r->acceleration_max*(!lw_task_has_place(s->spec.task) ? 1 : slide ? m : 1/m));
    cli_json_real(j, "sense", s->spec.timing == LW_TIMING_NONE ? NAN : c->intended.sense);   /* null: no order */
    cli_json_real(j, "input0", r->input_turns_per_period*c->input0);
    cli_json_real(j, "tool0", c->tool0);
    json_inputs(s, c, r, j);
}

static lw_status robustness(const cli_fit_set *s, int i, lw_robustness *out, lw_error *e)
{
    lw_status st = lw_robustness_of(&s->target, candidate_of(s, i), &s->search.results.report[i], &s->spec.tolerances, out, e);
    if (st == LW_E_MEMORY)
        cli_lost();
    return st;
}

static void json_robustness(const cli_fit_set *s, int i, cli_json *j)
{
    lw_robustness r;
    lw_error e = { .text = "" };
    cli_json_object(j, "robustness");
    cli_json_real(j, "tolerance", length(s, s->spec.tolerances.length));
    cli_json_real(j, "clearance", length(s, s->spec.tolerances.clearance));
    if (robustness(s, i, &r, &e) != LW_OK) {
        cli_json_text(j, "fault", e.text);
        cli_json_end(j);
        return;
    }
    cli_json_real(j, "rms", length(s, r.rms));
    cli_json_real(j, "worst", length(s, r.worst));
    cli_json_int(j, "trials", r.trials);
    cli_json_int(j, "open", r.open);
    cli_json_real(j, "trial_rms", length(s, r.trial_rms));
    cli_json_real(j, "within", length(s, r.within));
    cli_json_object(j, "parts");
    for (int d = 0; d < r.n_part; d++)
        cli_json_real(j, r.name[d], r.part[d]);
    cli_json_end(j);
    cli_json_end(j);
}

/* How far the paths spread under --tolerances. */
static void print_robustness(const cli_fit_set *s, FILE *f)
{
    const char *unit = s->target.units.length[0] ? s->target.units.length : "unit";
    fprintf(f, "tolerance +-%.4g, clearance %.4g %s: standard deviation of the path (rms, worst posture), the same of random "
            "linkages, how near 95 %% of them stay everywhere [%s]\n", length(s, s->spec.tolerances.length),
            length(s, s->spec.tolerances.clearance), unit, unit);
    for (int i = 0; i < s->search.results.n; i++) {
        lw_robustness r;
        lw_error e = { .text = "" };
        if (robustness(s, i, &r, &e) != LW_OK) {
            fprintf(f, "%3d  %s\n", i + 1, e.text);
            continue;
        }
        fprintf(f, "%3d  %9.3g %9.3g ", i + 1, length(s, r.rms), length(s, r.worst));
        if (r.open < r.trials)
            fprintf(f, "%9.3g %9.3g", length(s, r.trial_rms), length(s, r.within));
        else
            fprintf(f, "%9s %9s", "-", "-");
        fprintf(f, "   most by %s (%.0f %%)", r.name[r.first], 100*r.part[r.first]);
        if (r.open > 0)
            fprintf(f, "; %d of %d do not close", r.open, r.trials);
        fputc('\n', f);
    }
}

static void json_result(const cli_fit_set *s, int i, cli_json *j)
{
    const lw_fit_report *r = &s->search.results.report[i];
    const lw_candidate *c = candidate_of(s, i);
    cli_json_object(j, NULL);
    cli_json_int(j, "rank", i + 1);
    cli_json_text(j, "type", lw_family_type(c->family));
    cli_json_text(j, "family", c->family->name);
    cli_json_int(j, "links", lw_candidate_links(c));
    json_class(r, j);
    if (s->is_exact)
        cli_fit_exact_json_row(s, i, j);
    cli_json_real(j, "objective", c->objective);
    json_errors(s, r, j);
    cli_fit_points_json(s, i, j);
    if (s->has_tolerances)
        json_robustness(s, i, j);
    cli_json_object(j, "dimensions");
    for (int d = 0; d < c->n_dim; d++)
        cli_json_real(j, r->dim_name[d], lw_fitted_value(&s->target.units, r, d, c->dim[d]));
    cli_json_end(j);
    json_limits(s, r, j);
    json_motion(s, c, r, j);
    json_cognates(s, r, j);
    cli_json_int(j, "evaluations", c->evals);
    cli_json_real(j, "seconds", c->seconds);
    cli_json_text(j, "stop", cli_stop_text(c->stop));
    cli_json_bool(j, "verified", r->verified);
    cli_json_real(j, "verified_objective", r->verified_objective);
    cli_json_real(j, "verified_difference", length(s, r->difference));
    char *text = lw_linkage_write(&r->linkage, 0);
    cli_json_raw(j, "linkage", text);
    free(text);
    cli_json_end(j);
}

static void json_stages(const cli_fit_set *s, cli_json *j)
{
    cli_json_array(j, "by_links");
    for (int k = 0; k < s->search.n_links; k++) {
        const lw_links_summary *l = &s->search.by_links[k];
        if (l->n_stage == 0)
            continue;
        cli_json_object(j, NULL);
        cli_json_int(j, "links", l->links);
        cli_json_int(j, "best_rank", l->best + 1);
        cli_json_real(j, "objective", l->best >= 0 ? candidate_of(s, l->best)->objective : NAN);
        cli_json_real(j, "error_percent", l->best >= 0 ? s->search.results.report[l->best].error_percent : NAN);
        cli_json_int(j, "starts", l->starts);
        cli_json_int(j, "local_fits", l->improved);
        cli_json_int(j, "grown", l->n_grown);
        if (s->target.n_also > 0)
            cli_json_int(j, "point_choices", l->n_point_choice);
        cli_json_real(j, "seconds", l->seconds);
        cli_json_end(j);
    }
    cli_json_end(j);
}

static void json_topologies(const cli_fit_set *s, cli_json *j)
{
    static const char *const key[LW_PAIR_OUTCOMES] = { "fitted", "joined_to_ground", "smaller", "no_plan", "no_gear",
                                                       "not_asked" };
    cli_json_array(j, "topologies");
    for (int k = 0; k < s->search.n_mechanisms; k++) {
        const lw_mechanism_summary *m = &s->search.mechanisms[k];
        const lw_mechanism_tally *t = &m->tally;
        long families = 0;
        for (int i = 0; i < LW_FIT_STATES; i++)
            families += m->state[i];
        cli_json_object(j, NULL);
        cli_json_int(j, "links", m->links);
        cli_json_bool(j, "two_freedoms", m->two_freedoms);
        cli_json_int(j, "chains", t->n_chain);
        cli_json_int(j, "grounds", t->n_ground);
        cli_json_int(j, "with_tracer_link", t->n_pair);
        cli_json_int(j, "with_input", t->n_driven);
        if (s->search.freedoms > 1) {
            cli_json_int(j, "freedoms", s->search.freedoms);
            cli_json_int(j, "with_inputs_at_ground", t->n_set);
            cli_json_int(j, "of_these_left_out", t->n_set_out);
        }
        for (int i = 0; i < LW_PAIR_OUTCOMES; i++)
            cli_json_int(j, key[i], t->outcome[i]);
        cli_json_int(j, "families", families);
        cli_json_int(j, "groups", t->n_group);
        cli_json_int(j, "searched", m->state[LW_FIT_LOOKED] + m->state[LW_FIT_CLOSED]);
        cli_json_int(j, "with_linkage", m->state[LW_FIT_CLOSED]);
        cli_json_int(j, "unable", m->state[LW_FIT_UNABLE]);
        cli_json_int(j, "not_reached", m->state[LW_FIT_UNREACHED]);
        cli_json_end(j);
    }
    cli_json_end(j);
}

void cli_fit_json(const cli_fit_set *s, const cli_call *call, FILE *f, int indent)
{
    cli_json j = cli_json_begin(f, indent);
    cli_json_head(&j, call->line);
    cli_json_seed(&j, "seed", s->seed);
    cli_json_object(&j, "target");
    cli_json_text(&j, "file", s->path);
    cli_json_int(&j, "points", (long long)s->target.n);
    cli_json_bool(&j, "closed", s->target.closed);
    cli_json_real(&j, "path_length", length(s, s->target.length));
    cli_json_text(&j, "length_unit", s->target.units.length);
    cli_json_end(&j);
    cli_json_text(&j, "task", lw_task_table[s->spec.task].name);
    cli_json_text(&j, "timing", lw_timing_names[s->spec.timing]);
    if (s->is_exact)
        cli_fit_exact_json(s, &j);
    cli_json_array(&j, "results");
    for (int i = 0; i < s->search.results.n; i++)
        json_result(s, i, &j);
    cli_json_end(&j);
    if (s->search.n_mechanisms > 0) {
        json_stages(s, &j);
        json_topologies(s, &j);
    }
    if (s->search.uncounted_links > 0)
        cli_json_int(&j, "uncounted_links", s->search.uncounted_links);
    cli_json_int(&j, "left_out", s->search.results.n_left_out);
    cli_json_object(&j, "beyond_limits");
    cli_json_int(&j, "linkages", s->search.results.n_unfit);
    for (int i = 0; i < LW_LIMITS; i++)
        cli_json_int(&j, limits[i].key, s->search.results.unfit_by[i]);
    cli_json_end(&j);
    cli_json_int(&j, "starts", s->search.found.fit.starts);
    cli_json_int(&j, "local_fits", s->search.found.fit.improved);
    cli_json_int(&j, "evaluations", s->search.found.fit.evals);
    cli_json_real(&j, "seconds", s->search.found.fit.seconds);
    lw_stop stop = s->search.found.fit.stop;
    cli_json_bool(&j, "complete", stop != LW_STOP_TIME && stop != LW_STOP_USER && !cli_fit_may_miss(s));
    cli_json_text(&j, "stop", cli_stop_text(stop));
    cli_json_end(&j);
}

/* ---- further points of the target ---------------------------------------------------------------- */

lw_status cli_fit_carriers(const char *text, const lw_target *t, lw_carrier carrier[LW_ALSO_MAX], lw_error *e)
{
    static const char *const word[] = { "any", "input", "coupler", "output" };
    const char *at = text;
    for (int i = 0; *at; i++) {
        size_t n = strcspn(at, ",");
        int found = 0;
        while (found < 4 && (strlen(word[found]) != n || strncmp(word[found], at, n) != 0))
            found++;
        if (found == 4)
            return lw_error_set(e, LW_E_ARG, "--point-links takes input, coupler, output or any for each further "
                                "point, not '%.*s'", (int)n, at);
        if (i >= t->n_also && strcmp(text, "any") != 0)
            return lw_error_set(e, LW_E_ARG, "--point-links names more links than the target has further points (%d)", t->n_also);
        if (i < LW_ALSO_MAX)
            carrier[i] = (lw_carrier)found;
        at += n + (at[n] == ',');
    }
    return LW_OK;
}

void cli_fit_points_summary(const cli_fit_set *s, FILE *f)
{
    for (int i = 0; i < s->search.n_links; i++) {
        const lw_links_summary *l = &s->search.by_links[i];
        if (l->n_point_choice > 0)
            fprintf(f, "%d links: %d choices of links for the points\n", l->links, l->n_point_choice);
    }
}

void cli_fit_points_row(const cli_fit_set *s, int i, FILE *f)
{
    const lw_fit_report *r = &s->search.results.report[i];
    for (int k = 0; k < r->n_also; k++) {
        const lw_also_error *a = &r->also[k];
        const lw_linkage *l = &r->linkage;
        fprintf(f, "     point %d on %-9s     ", k + 2, l->link_name[l->tracer[k + 1].link]);
        if (s->target.also[k].x)
            fprintf(f, " %9.3g%% %9.4g %9.4g @%-4zu", a->percent, length(s, a->mean), length(s, a->max), a->worst + 1);
        if (s->target.also[k].theta)
            fprintf(f, "  angle: mean %.4g, max %.4g deg", a->angle_mean*180/LW_PI, a->angle_max*180/LW_PI);
        fputc('\n', f);
    }
}

void cli_fit_points_json(const cli_fit_set *s, int i, cli_json *j)
{
    const lw_fit_report *r = &s->search.results.report[i];
    const lw_candidate *c = candidate_of(s, i);
    if (r->n_also == 0)
        return;
    cli_json_array(j, "further_points");
    for (int k = 0; k < r->n_also; k++) {
        const lw_also_error *a = &r->also[k];
        const lw_tracer *p = &r->linkage.tracer[k + 1];
        cli_json_object(j, NULL);
        cli_json_text(j, "tracer", p->name);
        cli_json_text(j, "link", r->linkage.link_name[p->link]);
        if (s->target.also[k].x) {
            cli_json_real(j, "error_mean", length(s, a->mean));
            cli_json_real(j, "error_rms", length(s, a->rms));
            cli_json_real(j, "error_max", length(s, a->max));
            cli_json_real(j, "error_percent", a->percent);
        }
        cli_json_int(j, "error_worst", (long long)a->worst + 1);
        if (s->target.also[k].theta) {
            cli_json_real(j, "angle_error_mean", a->angle_mean);
            cli_json_real(j, "angle_error_max", a->angle_max);
            cli_json_real(j, "tool", c->tool[k]);
        }
        cli_json_end(j);
    }
    cli_json_end(j);
}
