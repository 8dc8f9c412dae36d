#include "optimise/report/results.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool first_with_its_links(const lw_fit_results *r, const lw_fit *fit, int i)
{
    for (int k = 0; k < r->n; k++)
        if (lw_candidate_links(&fit->candidate[r->candidate[k]]) == lw_candidate_links(&fit->candidate[i]))
            return false;
    return true;
}

lw_status lw_fit_results_make(const lw_target *t, const lw_fit_spec *s, const lw_fit *fit, int most,
                              const unsigned *may_fail, lw_fit_results *out, lw_error *e)
{
    size_t n = (size_t)fit->n + 1;
    *out = (lw_fit_results){ .candidate = calloc(n, sizeof *out->candidate), .report = calloc(n, sizeof *out->report),
                             .left_out = calloc(n, sizeof *out->left_out) };
    lw_status st = out->candidate && out->report && out->left_out
                 ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for %d results", fit->n);
    for (int i = 0; i < fit->n && st == LW_OK; i++) {
        lw_fit_report *r = &out->report[out->n];
        if ((st = lw_fit_report_make(t, s, &fit->candidate[i], r, e)) != LW_OK)
            break;
        if (r->verified || (may_fail && may_fail[i] && r->meets)) {
            if (out->n < most || first_with_its_links(out, fit, i))
                out->candidate[out->n++] = i;
            continue;
        }
        lw_left_out *l = &out->left_out[out->n_left_out++];
        l->candidate = i;
        snprintf(l->fault, sizeof l->fault, "%s", r->fault);
    }
    if (st != LW_OK)
        lw_fit_results_free(out);
    return st;
}

void lw_fit_results_free(lw_fit_results *r)
{
    free(r->candidate);
    free(r->report);
    free(r->left_out);
    memset(r, 0, sizeof *r);
}
