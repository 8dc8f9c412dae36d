/* cli/fit/fit_points.c - what is said of the further points of a target: the link each lies on and its errors. */
#include <string.h>

#include "cli/fit/fit.h"

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
            return lw_error_set(e, LW_E_ARG, "--point-links names more links than the target has further points (%d)",
                                t->n_also);
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

static double length(const cli_fit_set *s, double metres)
{
    return metres/s->target.units.metre;
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
    const lw_candidate *c = cli_fit_candidate(s, i);
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
