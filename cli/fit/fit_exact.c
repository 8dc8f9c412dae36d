/* cli/fit/fit_exact.c - fit --exact: find linkages through precision points, and their defects. */
#include <string.h>

#include "base/number.h"
#include "cli/fit/fit.h"

static const struct { unsigned bit; const char *name; } defects[] = {
    { LW_DEFECT_CIRCUIT, "circuit" }, { LW_DEFECT_BRANCH, "branch" }, { LW_DEFECT_ORDER, "order" }
};
enum { N_DEFECT = sizeof defects/sizeof *defects };

lw_status cli_fit_exact(const cli_call *call, cli_fit_set *s, const lw_fit_options *o, lw_error *e)
{
    lw_fit_options here = *o;
    s->is_exact = true;
    if (!lw_task_table[s->spec.task].prescribed && s->target.angle)
        cli_note(call, "%s: its input angles are ignored; linkages through precision points find their own", s->path);
    if (!lw_task_table[s->spec.task].prescribed)
        s->spec.timing = LW_TIMING_FREE;
    here.spec = s->spec;
    lw_status st = lw_exact_run(&s->target, &here, &s->exact, e);
    s->search.found.fit = s->exact.fit;                    /* the set frees it from now on */
    memset(&s->exact.fit, 0, sizeof s->exact.fit);
    return st;
}

/* Verify as a fit does. A linkage with stations on two circuits cannot move through all of them; it is kept and listed
 * with this defect. */
lw_status cli_fit_exact_verify(const cli_call *call, cli_fit_set *s, lw_error *e)
{
    const lw_fit *fit = &s->search.found.fit;
    lw_fit_results *r = &s->search.results;
    const lw_results_effort effort = { .jobs = call->common.jobs, .interrupt = cli_stop_flag() };
    lw_status st = lw_fit_results_make(&s->target, &s->spec, fit, fit->n, s->exact.defect, &effort, r, e);
    if (st != LW_OK)
        return st;
    for (int i = 0; i < r->n_left_out; i++)
        cli_note(call, "%s: a %s is left out: %s", s->path, fit->candidate[r->left_out[i].candidate].family->name, r->left_out[i].fault);
    if (fit->n > 0 && s->exact.n_clean == 0)
        cli_note(call, "%s: %s runs through all stations without a defect; without --exact one is fitted as well as "
                 "can be", s->path, s->exact.complete ? "no linkage there is" : "no linkage found");
    return LW_OK;
}

bool cli_fit_may_miss(const cli_fit_set *s)
{
    return s->is_exact && !s->exact.complete && !s->exact.choice[0];
}

static const char *defect_text(unsigned defect, char text[32])
{
    text[0] = 0;
    for (int i = 0; i < N_DEFECT; i++)
        if (defect & defects[i].bit)
            snprintf(text + strlen(text), 32 - strlen(text), "%s%s", text[0] ? "," : "", defects[i].name);
    return text[0] ? text : "none";
}

void cli_fit_exact_row(const cli_fit_set *s, int i, FILE *f)
{
    char text[32];
    fprintf(f, " defects: %-13s", defect_text(s->exact.defect[s->search.results.candidate[i]], text));
}

void cli_fit_exact_summary(const cli_fit_set *s, FILE *f)
{
    const lw_exact *x = &s->exact;
    double m = s->target.units.metre;
    static const char *const kinds[] = { "RR", "PR", "RP" };
    for (int i = 0; i < x->n_guide; i++) {
        const lw_guide *g = &x->guide[i];
        fprintf(f, "guide %d  %s  fixed %s at %.12g, %.12g", i + 1, kinds[g->kind],
                g->kind == LW_GUIDE_PR ? "line" : "pin", g->centre.x/m, g->centre.y/m);
        fprintf(f, "  %s on the tool at %.12g, %.12g", g->kind == LW_GUIDE_RP ? "line" : "pin", g->point.x/m, g->point.y/m);
        if (g->kind != LW_GUIDE_RR)
            fprintf(f, "  line along %.9g, %.9g", g->along.x, g->along.y);
        fputc('\n', f);
    }
    if (x->n_general > 0) {
        bool nine = x->n_theory > LW_EXACT_FIVE_MAX;
        long missing = x->n_theory - x->n_triple;
        fprintf(f, nine ? "%ld Roberts triple%s through these points over the complex numbers, of %d at most (Wampler, "
                          "Morgan & Sommese 1992); %ld of them real (three four-bars each)\n"
                        : "%ld solution%s with these fixed pins over the complex numbers, of %d at most (Morgan & Wampler "
                          "1990); %ld of them real\n", x->n_triple, lw_plural(x->n_triple), x->n_theory, x->n_real_triple);
        if (x->complete)
            fprintf(f, "complete: as many different ones were found as there can be\n");
        else
            fprintf(f, "not known to be complete: %ld of the %d solutions at general points were known, and %ld different ones were found "
                    "here. Of the other %ld, %ld paths end at infinity or at a singular solution, and %ld were lost; real solutions may be "
                    "among them\n", x->n_general, x->n_theory, x->n_triple, missing, x->n_singular, missing - x->n_singular);
    }
    if (x->choice[0])
        fprintf(f, "%s\n", x->choice);
    fprintf(f, "%ld real linkage%s%s: %ld without defect, %ld in another order, %ld with a limit between, %ld on "
            "two circuits; %.3g s; stopped: %s\n\n", x->n_real, lw_plural(x->n_real),
            x->complete ? ", all there are" : "", x->n_clean, x->n_order, x->n_branch, x->n_circuit,
            s->search.found.fit.seconds,
            s->search.found.fit.stop == LW_STOP_F_TARGET ? "done" : cli_stop_text(s->search.found.fit.stop));
}

void cli_fit_exact_json_row(const cli_fit_set *s, int i, cli_json *j)
{
    unsigned defect = s->exact.defect[s->search.results.candidate[i]];
    cli_json_array(j, "defects");
    for (int k = 0; k < N_DEFECT; k++)
        if (defect & defects[k].bit)
            cli_json_text(j, NULL, defects[k].name);
    cli_json_end(j);
    cli_json_real(j, "quality", s->exact.quality[s->search.results.candidate[i]]);
}

static void json_guide(const cli_fit_set *s, const lw_guide *g, cli_json *j)
{
    static const char *const kinds[] = { "RR", "PR", "RP" };
    double m = s->target.units.metre;
    double centre[2] = { g->centre.x/m, g->centre.y/m }, point[2] = { g->point.x/m, g->point.y/m };
    double along[2] = { g->along.x, g->along.y };
    cli_json_object(j, NULL);
    cli_json_text(j, "kind", kinds[g->kind]);
    cli_json_reals(j, "fixed", centre, 2);
    cli_json_reals(j, "moving", point, 2);
    if (g->kind != LW_GUIDE_RR)
        cli_json_reals(j, "along", along, 2);
    cli_json_end(j);
}

void cli_fit_exact_json(const cli_fit_set *s, cli_json *j)
{
    const lw_exact *x = &s->exact;
    cli_json_object(j, "exact");
    cli_json_bool(j, "complete", x->complete);
    cli_json_text(j, "free", x->choice);
    cli_json_int(j, "linkages", x->n_real);
    cli_json_int(j, "without_defect", x->n_clean);
    cli_json_int(j, "with_order_defect", x->n_order);
    cli_json_int(j, "with_branch_defect", x->n_branch);
    cli_json_int(j, "with_circuit_defect", x->n_circuit);
    if (x->n_general > 0 && x->n_theory <= LW_EXACT_FIVE_MAX) {
        cli_json_int(j, "most_solutions", x->n_theory);
        cli_json_int(j, "complex_solutions", x->n_triple);
        cli_json_int(j, "real_solutions", x->n_real_triple);
    } else if (x->n_general > 0) {
        cli_json_int(j, "general_roberts_triples", x->n_general);
        cli_json_int(j, "roberts_triples", x->n_triple);
        cli_json_int(j, "singular_ends", x->n_singular);
        cli_json_int(j, "real_roberts_triples", x->n_real_triple);
    }
    cli_json_array(j, "guides");
    for (int i = 0; i < x->n_guide; i++)
        json_guide(s, &x->guide[i], j);
    cli_json_end(j);
    cli_json_end(j);
}
