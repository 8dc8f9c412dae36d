/* cli/fit/fit_notes.c - notes on the results of a fit: what is left out, what would do with less, how far the target is missed. */
#include "cli/fit/fit_settings.h"

#include <string.h>
#include "base/number.h"
#include "base/real.h"

/* If a candidate fails the second simulation, it has a defect or the program has a fault: report it. */
static void note_left_out(const cli_call *call, const cli_fit_set *set)
{
    const int n = set->search.results.n_left_out;
    if (n == 0)
        return;
    const lw_left_out *first = set->search.results.left_out;
    const lw_candidate *c = &set->search.found.fit.candidate[first->candidate];
    cli_note(call, "%s: %d linkage%s found %s not listed, because the check that every result has to pass refused %s%s (%s, objective %.6g): %s",
             set->path, n, lw_plural(n), n == 1 ? "is" : "are", n == 1 ? "it" : "them", n == 1 ? "" : "; the first", c->family->name, c->objective,
             first->fault);
}

/* Does the body keep its angle? */
static bool keeps_angle(const lw_target *t)
{
    double most = 0;
    for (size_t i = 1; t->theta && i < t->n; i++)
        most = fmax(most, fabs(remainder(t->theta[i] - t->theta[0], 2*LW_PI)));
    return t->theta && most <= LW_STRAIGHT;
}

void cli_fit_note_simpler(const cli_call *call, const cli_fit_set *set)
{
    const lw_target *t = &set->target;
    const char *unit = t->units.length[0] ? t->units.length : "units";
    lw_vec2 c, p;
    double r, from_pivot, off = lw_target_circle(t, &c, &r), m = t->units.metre;
    double grain = m*pow(10, floor(log10(LW_STRAIGHT*t->extent/m + 1e-300)));
    const bool path = set->spec.task == LW_TASK_PATH && t->n_also == 0;
    bool alone = path && set->spec.timing != LW_TIMING_PRESCRIBED;
    const bool counted = cli_given(&call->parsed, "links") || set->task_file.links > 0;
    bool pins = !cli_given(&call->parsed, "type") && !cli_given(&call->parsed, "joints") && (counted || alone);
    bool motion = set->spec.task == LW_TASK_MOTION && t->n_also == 0, straight = lw_target_straight(t) <= LW_STRAIGHT*t->extent;
    if (path && pins && t->n >= 3 && straight)
        cli_note(call, "%s: this path is straight: with '--type slidercrank' a slider moves exactly along it", set->path);
    if (motion && straight && keeps_angle(t))
        cli_note(call, "%s: the body keeps its angle and moves straight: a slide alone, such as the slider of a slider-crank, moves it so", set->path);
    bool circle = off <= LW_EXACT_ENOUGH*t->extent && r < LW_DEFAULT_MAX_SIZE*t->extent;
    if (motion && circle && keeps_angle(t))
        cli_note(call, "%s: the body keeps its angle and moves on a circle: a parallelogram, with two parallel cranks of %.6g %s, moves it so "
                 "within %.2g %s", set->path, r/m, unit, fmax(off, grain)/m, unit);
    if (lw_pin_does(t, &set->spec, &p, &from_pivot))
        cli_note(call, "%s: a body on one pin, at (%.6g, %.6g), moves so, within %.2g %s; if no pin can be there, '--links 6' also searches "
                 "linkages that turn it about that point", set->path, (grain*round(p.x/grain) + 0.0)/m, (grain*round(p.y/grain) + 0.0)/m,
                 fmax(from_pivot, grain)/m, unit);
    if (alone && circle)
        cli_note(call, "%s: a link of %.6g %s that turns about (%.6g, %.6g) draws this path alone, within %.2g %s", set->path,
                 r/m, unit, (grain*round(c.x/grain) + 0.0)/m, (grain*round(c.y/grain) + 0.0)/m, fmax(off, grain)/m, unit);
}

/* What to search next if no linkage found is near.  A closed path of equal parts is what a gear pair of that ratio makes. */
static void advise(const cli_call *call, const cli_fit_set *set, char *text, size_t size)
{
    const cli_fit_settings *s = call->settings;
    int links = 4, parts = set->spec.timing == LW_TIMING_PRESCRIBED || strchr(s->joints, 'g') ? 1
                         : lw_target_parts(&set->target, LW_NEAR*set->target.extent);
    for (int i = 0; i < set->search.found.n_stage; i++)
        links = set->search.found.stage[i].links > links ? set->search.found.stage[i].links : links;
    if (parts > 1)
        snprintf(text, size, "it has %d equal parts, which gears draw: '--links 5 --joints r,g --gear-ratios %d,-%d --timing none'", parts, parts, parts);
    else
        snprintf(text, size, "%s", links < 6 ? "'--links 6' searches linkages with six links too"
                                   : links < 8 ? "'--links 8' searches longer, and linkages with eight links too"
                                   : "a larger --budget searches longer");
}

void cli_fit_notes(const cli_call *call, const cli_fit_set *set)
{
    const lw_fit_results *found = &set->search.results;
    const lw_fit_report *r = &found->report[0];
    double least = INFINITY;
    for (int i = 0; i < found->n; i++)
        least = fmin(least, lw_fit_report_stray(&found->report[i]));
    note_left_out(call, set);
    if (set->search.found.fit.skipped[0])
        cli_note(call, "%s: skipped %s", set->path, set->search.found.fit.skipped);
    if (found->n == 0 && found->n_left_out == 0)
        cli_note(call, "%s: no linkage that meets all conditions was found in this time; give it longer, or fewer conditions", set->path);
    if (found->n > 0 && set->spec.tolerance > 0 && found->n_within == 0)
        cli_note(call, "%s: no linkage found stays within %g %s; the best strays by %.4g", set->path,
                 set->spec.tolerance/set->target.units.metre,
                 set->target.units.length[0] ? set->target.units.length : "units",
                 least/set->target.units.metre);
    else if (found->n > 0 && set->spec.tolerance > 0 && cli_timed_out())
        cli_note(call, "%s: --time ended the search: smaller or simpler linkages within --tolerance may exist", set->path);
    if (found->n > 0 && set->spec.by_default && lw_task_has_place(set->spec.task) && found->n_within == 0
        && lw_fit_report_misses(&set->target, r) > LW_NEAR*set->target.extent) {
        char advice[128];
        advise(call, set, advice, sizeof advice);
        double misses = lw_fit_report_misses(&set->target, r), m = set->target.units.metre;
        const char *unit = set->target.units.length[0] ? set->target.units.length : "units";
        int nearest = 0;
        for (int i = 1; i < found->n; i++)
            if (lw_fit_report_misses(&set->target, &found->report[i]) < lw_fit_report_misses(&set->target, &found->report[nearest]))
                nearest = i;
        double least_miss = lw_fit_report_misses(&set->target, &found->report[nearest]);
        const bool meets = r->error_max <= 1e-6*set->target.extent;
        if (meets || lw_fit_report_known_miss(&set->target, r, 0) <= LW_NEAR*set->target.extent)
            cli_note(call, "%s: the first row meets every point%s; between them it leaves a smooth line through them (straight at corners) "
                     "by %.3g %s, %.2g %% of the target's diagonal. If that matters, add points%s", set->path, meets ? "" : " nearly", misses/m,
                     unit, 100*misses/set->target.extent,
                     set->spec.task == LW_TASK_PATH && set->spec.timing == LW_TIMING_FREE && set->target.n_also == 0
                     ? ", as '--stations 40' does along straight lines from point to point" : "");
        else if (least_miss <= LW_NEAR*set->target.extent)
            cli_note(call, "%s: the first row misses the target by %.3g %s, %.2g %% of its diagonal; row %d misses it by %.3g %s", set->path,
                     misses/m, unit, 100*misses/set->target.extent, nearest + 1, least_miss/m, unit);
        else
            cli_note(call, "%s: no linkage found follows the target well: the first row misses it by %.3g %s, %.2g %% of its "
                     "diagonal; %s", set->path, misses/m, unit, 100*misses/set->target.extent, advice);
    }
    const double swing = lw_target_swing(&set->target);
    if (found->n > 0 && set->spec.by_default && !lw_task_has_place(set->spec.task) && r->angle_max > LW_NEAR*swing) {
        char advice[128];
        advise(call, set, advice, sizeof advice);
        cli_note(call, "%s: no linkage found follows the function well: the first row misses it by %.3g degrees, %.2g %% of its range; %s",
                 set->path, r->angle_max*180/LW_PI, 100*r->angle_max/swing, advice);
    }
    if (found->n > 0 && set->spec.timing == LW_TIMING_FREE && set->target.n >= 8 && r->curve_max > 3*r->error_max
        && r->curve_max > 0.05*set->target.size)
        cli_note(call, "%s: between two stations the best curve strays %.3g %s from the target; "
                 "'--timing none' scores the curve both ways", set->path,
                 r->curve_max/set->target.units.metre,
                 set->target.units.length[0] ? set->target.units.length : "units");
}
