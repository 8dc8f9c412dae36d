/* cli/motion/simulate_balance.c - print counterweights as JSON. */
#include "cli/motion/simulate.h"
#include "mbs/analysis/counterweights.h"

lw_status cli_simulate_balance(cli_simulate *c, FILE *f, lw_error *e)
{
    const lw_assembly *k = &c->model->linkage;
    lw_counterweights found;
    const lw_model *model = lw_dynamics_elastic(c->d) ? c->model : lw_dynamics_model(c->d);      /* elastic: refused */
    lw_status s = lw_counterweights_find(model, lw_dynamics_system(c->d), c->n_row, c->q, &found, e);
    if (s != LW_OK)
        return lw_counterweights_free(&found), s;
    cli_json j = cli_json_begin(f, 1);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "length_unit", k->units.length[0] ? k->units.length : "m");
    cli_json_array(&j, "counterweights");
    for (int i = 0; i < found.n; i++) {
        const lw_counterweight *w = &found.weight[i];
        cli_json_object(&j, NULL);
        cli_json_text(&j, "link", k->link_name[w->link]);
        cli_json_text(&j, "pin", k->joint[w->joint].name);
        cli_json_real(&j, "mass_times_radius", w->product);
        cli_json_real(&j, "mass", w->mass);
        cli_json_reals(&j, "at", (double[]){ w->at.x/k->units.metre, w->at.y/k->units.metre }, 2);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_real(&j, "moved_before", found.deviation_before);
    cli_json_real(&j, "moved_after", found.deviation_after);
    cli_json_bool(&j, "balanced", found.balanced);
    cli_json_end(&j);
    lw_counterweights_free(&found);
    return LW_OK;
}
