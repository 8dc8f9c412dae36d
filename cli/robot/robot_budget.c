/* cli/robot/robot_budget.c - how far the tool can stray from where its drives should hold it. */
#include "cli/robot/robot.h"

#include "cli/program/json.h"

lw_status cli_robot_budget_options(const cli_robot *j, lw_budget_options *o, lw_error *e)
{
    const cli_robot_settings *s = j->s;
    *o = (lw_budget_options){ .clearance = s->gap*j->metre, .play = { s->play*LW_PI/360, s->slide_play*j->metre/2 }, .weight = true };
    lw_status st = s->force ? cli_robot_read_numbers(j, "--tool-force", "N", s->force, &o->load, e) : LW_OK;
    bool any = j->m->n_elastic > 0 || s->gap > 0 || s->play > 0 || s->slide_play > 0;
    for (int i = 0; i < j->m->n_joint; i++)
        any = any || j->m->joint[i].clearance.model > LW_CLEARANCE_NONE;
    return st != LW_OK || any ? st
         : lw_error_set(e, LW_E_ARG, "nothing lets the tool stray: no joint has a \"clearance\" and no link is elastic; give "
                        "--joint-gap, --gear-play or --slide-play");
}

const char *cli_robot_source_name(const lw_budget_source *s, char *text, size_t size)
{
    static const char *const of[] = { "clearance of", "play of", "bending of" };
    snprintf(text, size, "%s %s", of[s->kind], s->name);
    return text;
}

static void print_budget(const cli_robot *j, FILE *f, const lw_robot_pose *p, const lw_budget *b)
{
    char name[96];
    double u = j->metre, size = j->r.space.unit;
    fprintf(f, "tool '%s' at (%.9g, %.9g, %.9g) %s\n%-40s %12s %12s  %s\n", j->m->tracer[j->r.tool].name, cli_robot_clean(p->place.x, size)/u,
            cli_robot_clean(p->place.y, size)/u, cli_robot_clean(p->place.z, size)/u, j->unit, "source", "worst", "rms", "share of rms^2");
    for (int i = 0; i < b->n; i++) {
        const lw_budget_source *s = &b->source[i];
        fprintf(f, "%-40s %12.5g %12.5g  %.1f %%\n", cli_robot_source_name(s, name, sizeof name), s->worst/u, s->rms/u,
                b->rms > 0 ? 100*s->rms*s->rms/(b->rms*b->rms) : 0);
    }
    fprintf(f, "%-40s %12.5g %12.5g  [%s]\n", "all together", b->worst/u, b->rms/u, j->unit);
    if (!(b->worst > 0)) {
        fputs("nothing moves the tool: give the sources by --joint-gap, --gear-play, --slide-play or elastic links\n", f);
        return;
    }
    fputs("worst towards ", f);
    cli_robot_print_direction(f, b->direction);
    fprintf(f, "; greatest contributor: %s\n", cli_robot_source_name(&b->source[0], name, sizeof name));
}

static void json_budget(const cli_robot *j, FILE *f, const lw_robot_pose *p, const lw_budget *b)
{
    static const char *const kind[] = { "clearance", "play", "elastic" };
    cli_json w = cli_json_begin(f, 2);
    cli_json_head(&w, j->call->line);
    cli_json_text(&w, "length_unit", "m");
    cli_json_reals(&w, "place", (double[]){ p->place.x, p->place.y, p->place.z }, 3);
    cli_json_array(&w, "sources");
    for (int i = 0; i < b->n; i++) {
        cli_json_object(&w, NULL);
        cli_json_text(&w, "kind", kind[b->source[i].kind]);
        cli_json_text(&w, "name", b->source[i].name);
        cli_json_real(&w, "worst", b->source[i].worst);
        cli_json_real(&w, "rms", b->source[i].rms);
        cli_json_end(&w);
    }
    cli_json_end(&w);
    cli_json_real(&w, "worst", b->worst);
    cli_json_real(&w, "rms", b->rms);
    cli_json_reals(&w, "direction", (double[]){ b->direction.x, b->direction.y, b->direction.z }, 3);
    cli_json_reals(&w, "bent", (double[]){ b->bent.x, b->bent.y, b->bent.z }, 3);
    cli_json_end(&w);
}

int cli_robot_budget(const cli_call *call)
{
    cli_robot j;
    lw_robot_pose p;
    lw_output o;
    lw_budget_options how;
    lw_budget_stiffness stiff = { 0 };
    lw_budget b = { 0 };
    int code = cli_robot_begin(call, &j);
    if (code == CLI_DONE && (cli_robot_budget_options(&j, &how, &j.e) != LW_OK || lw_robot_measure(&j.r, &p, &j.e) != LW_OK ||
                             lw_budget_stiffness_make(j.m, &how, &stiff, &j.e) != LW_OK ||
                             lw_budget_make(&j.r, &stiff, &how, &b, &j.e) != LW_OK || cli_open(call, &o, &j.e) != LW_OK))
        code = cli_fail(call, &j.e);
    if (code == CLI_DONE) {
        (call->common.json ? json_budget : print_budget)(&j, o.f, &p, &b);
        code = cli_close(call, &o, CLI_DONE);
    }
    lw_budget_free(&b);
    lw_budget_stiffness_free(&stiff);
    cli_robot_end(&j);
    return code;
}
