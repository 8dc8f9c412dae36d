/* linkwright drive select, radius - motors, gears and amplifiers for the drives of a model. */
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "catalogues/pages/draw.h"
#include "catalogues/store/drive_store.h"
#include "cli/motion/drive.h"
#include "cli/program/json.h"
#include "cli/program/output.h"

/* ---- parts --------------------------------------------------------------------------------------- */

static lw_status read_parts(const char *path, lw_drive_parts *p, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_status s = cli_read_file(path, "a table of parts (CSV)", &text, &size, e);
    if (s == LW_OK && size >= 15 && memcmp(text, "SQLite format 3", 15) == 0)
        s = lw_store_read_drive_parts(path, p, e);
    else if (s == LW_OK)
        s = lw_drive_parts_read(text, size, path, p, e);
    free(text);
    return s;
}

static lw_status read_all_parts(const cli_drive_settings *o, lw_drive_parts *p, lw_error *e)
{
    const char *const paths[] = { o->motors, o->gears, o->amplifiers };
    lw_status s = o->motors ? LW_OK : lw_error_set(e, LW_E_ARG, "--motors is missing: a table of motors, such as "
                                                   "examples/drives/motors.csv");
    for (int i = 0; s == LW_OK && i < 3; i++)
        if (paths[i])
            s = read_parts(paths[i], p, e);
    if (s == LW_OK && p->n_motor == 0)
        s = lw_error_at(e, LW_E_NOTATION, o->motors, 0, 0, "this file holds no motor");
    return s;
}

/* ---- output --------------------------------------------------------------------------------------- */

static const char *amplifier_name(const lw_drive_parts *p, const lw_drive_choice *c)
{
    return c->amplifier < 0 ? "-" : p->amplifier[c->amplifier].name;
}

static void percent(FILE *f, double use)
{
    if (isnan(use))
        fprintf(f, " %7s", "-");
    else
        fprintf(f, " %6.1f%%", 100*use);
}

static const char *cost_name(const lw_drive_parts *p, const lw_drive_choice *c)
{
    return p->motor[c->motor].price > 0 ? "price" : p->motor[c->motor].mass > 0 ? "mass [kg]" : "power [W]";
}

/* The limits that a choice breaks, with their use. */
static void name_fails(const lw_drive_choice *c, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < LW_DRIVE_N_LIMIT && used < size; i++)
        if (c->fails & 1u << i)
            used += (size_t)snprintf(text + used, size - used, "%s%.3g %% of the %s", used ? ", " : "", 100*c->use[i],
                                     lw_drive_limit_text(i));
}

static void print_choices(FILE *f, const lw_load *l, const lw_drive_parts *p, size_t n, const lw_drive_choice *c,
                          const bool *front,
                          size_t most)
{
    size_t good = 0;
    while (good < n && !c[good].fails)
        good++;
    fprintf(f, "drive %s: %zu of %zu choices can do the cycle\n", l->name, good, n);
    if (n == 0)
        return;
    fprintf(f, "  %-18s %-14s %-12s %10s %8s %7s %7s %7s %7s %7s %7s %9s %8s\n", "motor", "gear", "amplifier",
            l->slides ? "rad/m" : "ratio", "speed", "peak", "rms", "volt", "A peak", "A rms", "i^2 t", "inertia",
                cost_name(p, c));
    for (size_t i = 0; i < n && i < most && (good == 0 ? i < 3 : i < good); i++) {
        const lw_drive_choice *k = &c[i];
        fprintf(f, "%c %-18s %-14s %-12s %10.6g ", front[i] ? '*' : ' ', p->motor[k->motor].name, lw_drive_gear(p, k->gear)->name,
                amplifier_name(p, k), k->ratio);
        static const int shown[] = { LW_DRIVE_SPEED, LW_DRIVE_PEAK, LW_DRIVE_RMS, LW_DRIVE_VOLTAGE, LW_DRIVE_CURRENT,
                                     LW_DRIVE_CURRENT_RMS, LW_DRIVE_HEAT };
        for (int u = 0; u < 7; u++)
            percent(f, k->use[shown[u]]);
        if (isnan(k->inertia_ratio))
            fprintf(f, " %9s", "-");
        else
            fprintf(f, " %9.3g", k->inertia_ratio);
        fprintf(f, " %8.6g\n", k->cost);
        if (k->fails) {
            char text[400];
            name_fails(k, text, sizeof text);
            fprintf(f, "      fails: %s\n", text);
        }
    }
}

static void json_choices(cli_json *j, const lw_load *l, const lw_drive_parts *p, size_t n, const lw_drive_choice *c,
                         const bool *front, size_t most)
{
    size_t good = 0;
    while (good < n && !c[good].fails)
        good++;
    cli_json_object(j, NULL);
    cli_json_text(j, "drive", l->name);
    cli_json_int(j, "choices", (long long)n);
    cli_json_int(j, "possible", (long long)good);
    cli_json_array(j, "best");
    for (size_t i = 0; i < n && i < most && (good == 0 ? i < 3 : i < good); i++) {
        const lw_drive_choice *k = &c[i];
        cli_json_object(j, NULL);
        cli_json_text(j, "motor", p->motor[k->motor].name);
        cli_json_text(j, "gear", lw_drive_gear(p, k->gear)->name);
        cli_json_text(j, "amplifier", k->amplifier < 0 ? NULL : p->amplifier[k->amplifier].name);
        cli_json_real(j, "ratio", k->ratio);
        cli_json_real(j, "speed", k->speed);
        cli_json_real(j, "torque_peak", k->torque_peak);
        cli_json_real(j, "torque_rms", k->torque_rms);
        cli_json_real(j, "current_peak", k->current_peak);
        cli_json_real(j, "current_rms", k->current_rms);
        cli_json_real(j, "voltage", k->voltage);
        cli_json_real(j, "heat", k->heat);
        cli_json_real(j, "inertia_ratio", k->inertia_ratio);
        cli_json_real(j, "cost", k->cost);
        cli_json_bool(j, "pareto", front[i]);
        cli_json_object(j, "use");
        for (int u = 0; u < LW_DRIVE_N_LIMIT; u++)
            if (!isnan(k->use[u]))
                cli_json_real(j, lw_drive_limit_text(u), k->use[u]);
        cli_json_end(j);
        cli_json_array(j, "fails");
        for (int u = 0; u < LW_DRIVE_N_LIMIT; u++)
            if (k->fails & 1u << u)
                cli_json_text(j, NULL, lw_drive_limit_text(u));
        cli_json_end(j);
        cli_json_end(j);
    }
    cli_json_end(j);
    cli_json_end(j);
}

/* ---- plot --------------------------------------------------------------------------------------------- */

enum { CORNERS = 200 };

/* Torque that motor and amplifier have at a speed, first quadrant. */
static double limit_at(const lw_drive_parts *p, const lw_drive_choice *c, bool peak, double w)
{
    const lw_motor_part *m = &p->motor[c->motor];
    double torque = !peak ? m->torque : m->torque_peak > 0 ? m->torque_peak : 3*m->torque;
    if (c->amplifier >= 0) {
        const lw_amplifier_part *a = &p->amplifier[c->amplifier];
        double current = peak && a->current_peak > 0 ? a->current_peak : a->current;
        torque = fmin(torque, m->torque_constant*fmin(current, (a->voltage - m->torque_constant*w)/m->resistance));
    }
    return fmax(torque, 0);
}

/* The load as the motor sees it, and the limits; |speed|, torque positive when it drives. */
static lw_status draw_choices(int n, const lw_load *l, const lw_drive_parts *p,
                              const lw_drive_choice *const *best,
                              const char *only, const char *path, lw_error *e)
{
    lw_plot plot[LW_PANEL_MAX] = { 0 };
    lw_series series[LW_PANEL_MAX][3];
    char label[LW_PANEL_MAX][200];
    int panels = 0;
    size_t rows = l[0].n, size = 2*rows + 8*CORNERS;
    double *xy = malloc((size_t)n*size*sizeof *xy);
    if (!xy)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < n && panels < LW_PANEL_MAX; i++) {
        const lw_drive_choice *c = best[i];
        if (!c || (only && strcmp(only, l[i].name) != 0))
            continue;
        const lw_gear_part *g = lw_drive_gear(p, c->gear);
        double *x = xy + (size_t)i*size, *y = x + rows, *more = y + rows;
        double efficiency = g->efficiency > 0 ? g->efficiency : 1, inertia = p->motor[c->motor].inertia + g->inertia;
        for (size_t k = 0; k < rows; k++) {
            double torque = lw_drive_torque(&l[i], k, c->ratio, efficiency, inertia);
            x[k] = fabs(c->ratio*l[i].speed[k])*30/LW_PI;
            y[k] = l[i].speed[k] < 0 ? -torque : torque;
        }
        series[panels][0] = (lw_series){ .name = "load", .n = rows, .x = x, .y = y };
        double top = p->motor[c->motor].speed;
        if (c->amplifier >= 0)
            top = fmin(top, p->amplifier[c->amplifier].voltage/p->motor[c->motor].torque_constant);
        for (int s = 0; s < 2; s++) {                     /* out along the upper limit, back along the lower one */
            double *to = more + s*4*CORNERS, *limit = to + 2*CORNERS;
            for (int k = 0; k < 2*CORNERS; k++) {
                double w = top*(k < CORNERS ? k : 2*CORNERS - 1 - k)/(CORNERS - 1);
                to[k] = w*30/LW_PI;
                limit[k] = k < CORNERS ? limit_at(p, c, s == 0, w) : -limit_at(p, c, s == 0, 0);
            }
            series[panels][1 + s] = (lw_series){ .name = s ? "continuous limit" : "peak limit", .n = 2*CORNERS, .x
                                                 = to, .y = limit };
        }
        snprintf(label[panels], sizeof label[0], "torque [N m]");
        plot[panels] = (lw_plot){ .x_label = "speed of the motor [r/min]", .y_label = label[panels], .n_series = 3,
                                  .series = series[panels] };
        panels++;
        if (panels == 1) {
            static char title[300];
            snprintf(title, sizeof title, "%s: %s, %s, %s", l[i].name, p->motor[c->motor].name, g->name, amplifier_name(p, c));
            plot[0].title = title;
        }
    }
    plot[0].height = panels == 1 ? 560 : 420*panels;
    lw_status s = panels ? lw_draw_plots(panels, plot, path, e) : lw_error_set(e, LW_NOTHING, "there is no choice to draw");
    free(xy);
    return s;
}

/* ---- select -------------------------------------------------------------------------------------------- */

static lw_status find_drive(const lw_loads *l, const char *name, lw_error *e)
{
    for (int i = 0; i < l->n; i++)
        if (strcmp(l->load[i].name, name) == 0)
            return LW_OK;
    const char *near = LW_SUGGEST(name, l->load, l->n, name);
    return lw_error_set(e, LW_E_ARG, "--drive: the model has no drive \"%.60s\"%s%s%s", name, LW_DID_YOU_MEAN(near));
}

typedef struct selection { size_t n; lw_drive_choice *choice; bool *front; } selection;

static lw_status select_all(const cli_call *call, const lw_loads *all, const lw_drive_parts *p, selection *s, lw_error *e)
{
    const cli_drive_settings *o = call->settings;
    double most = o->inertia_ratio > 0 ? o->inertia_ratio : INFINITY;
    const lw_load *l = all->load;
    lw_status st = o->drive ? find_drive(all, o->drive, e) : LW_OK;
    for (int i = 0; st == LW_OK && i < all->n; i++)
        if (!o->drive || strcmp(o->drive, l[i].name) == 0) {
            st = lw_drive_choose(&l[i], p, most, cli_stop_flag(), &s[i].n, &s[i].choice, &s[i].front, e);
            if (st == LW_STOPPED && s[i].n > 0) {          /* what was tried is printed; the exit code tells the rest */
                cli_note(call, "drive %s: %s", l[i].name, e->text);
                return *e = (lw_error){ 0 }, LW_OK;
            }
            if (st == LW_OK && s[i].n == 0)
                st = lw_error_set(e, LW_E_ARG, "drive %s %s: no gear of the tables %s", l[i].name, l[i].slides ?
                                  "slides" : "turns",
                                  l[i].slides ? "has a \"radius\"" : "is without a \"radius\"");
        }
    return st;
}

static int print_selection(const cli_call *call, const lw_loads *all, const lw_drive_parts *p, const selection *s, FILE *f)
{
    const lw_load *l = all->load;
    const cli_drive_settings *o = call->settings;
    int code = CLI_DONE;
    cli_json j = cli_json_begin(f, 2);
    if (call->common.json) {
        cli_json_head(&j, call->line);
        cli_json_array(&j, "drives");
    }
    for (int i = 0; i < all->n; i++) {
        if (!s[i].choice)
            continue;
        if (call->common.json)
            json_choices(&j, &l[i], p, s[i].n, s[i].choice, s[i].front, (size_t)o->results);
        else
            print_choices(f, &l[i], p, s[i].n, s[i].choice, s[i].front, (size_t)o->results);
        if (s[i].choice[0].fails) {
            char text[400];
            name_fails(&s[i].choice[0], text, sizeof text);
            cli_note(call, "drive %s: no choice %scan do the cycle; the nearest is %s with %s, which needs %s", l[i].name,
                     cli_interrupted() ? "tried so far " : "",
                     p->motor[s[i].choice[0].motor].name, lw_drive_gear(p, s[i].choice[0].gear)->name, text);
            code = CLI_NOTHING;
        }
        if (s[i].choice[0].torque_steps)
            cli_note(call, "drive %s: the torque of its motor steps at %d place%s of the cycle; L dI/dt is left out of the voltage there. It steps where the "
                     "acceleration does, and where a gear with losses changes between driving and braking", l[i].name, s[i].choice[0].torque_steps,
                     lw_plural(s[i].choice[0].torque_steps));
    }
    if (call->common.json) {
        cli_json_end(&j);
        cli_json_end(&j);
    }
    return code;
}

int cli_drive_select(const cli_call *call)
{
    const cli_drive_settings *o = call->settings;
    lw_loads l = { 0 };
    lw_drive_parts p = { 0 };
    selection *s = NULL;
    const lw_drive_choice **best = NULL;
    lw_error e = { 0 };
    lw_output out;
    int code = CLI_DONE;
    if (!(o->from < o->to))
        return cli_usage(call, "--from must be less than --to");
    lw_status st = read_all_parts(o, &p, &e);
    if (st == LW_OK)
        st = cli_drive_run(call, &l, &e);
    if (st == LW_OK && (!(s = calloc((size_t)l.n, sizeof *s)) || !(best = calloc((size_t)l.n, sizeof *best))))
        st = lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK)
        st = select_all(call, &l, &p, s, &e);
    if (st == LW_OK && (st = cli_open(call, &out, &e)) == LW_OK) {
        code = print_selection(call, &l, &p, s, out.f);
        code = cli_close(call, &out, code);
        for (int i = 0; i < l.n; i++)
            best[i] = s[i].choice;
        if ((code == CLI_DONE || code == CLI_NOTHING) && o->plot)
            st = draw_choices(l.n, l.load, &p, best, o->drive, o->plot, &e);
    }
    if (st != LW_OK)
        code = st == LW_E_ARG && !e.file[0] ? cli_usage(call, "%s", e.text) : cli_fail(call, &e);
    for (int i = 0; s && i < l.n; i++) {
        free(s[i].choice);
        free(s[i].front);
    }
    free(s);
    free(best);
    lw_loads_free(&l);
    lw_drive_parts_free(&p);
    return code;
}

/* ---- radius ----------------------------------------------------------------------------------------------- */

static void print_row(FILE *f, const char *what, const lw_radius *r)
{
    fprintf(f, "  %-34s %10.4f %10.3f %9.3f %9.3f %9.3f %8.2f%% %10.4f %10.5f\n", what, 1000*r->r, r->alpha, r->speed,
            r->printed_way,
            r->printed_time, 100*r->efficiency, r->acceleration, r->time);
}

static void print_motor(FILE *f, const lw_motor_part *m, const cli_drive_settings *o)
{
    double current = m->torque/m->torque_constant, heat = m->resistance*current*current, power = m->torque*m->speed;
    double fall = m->resistance*current, emf = m->torque_constant*m->speed, best
        = m->torque/(2*sqrt(m->inertia*o->mass));
    double wanted = o->acceleration > 0 ? o->acceleration : best, t_63
        = m->resistance*m->inertia/(m->torque_constant*m->torque_constant);
    fprintf(f, "%s\n  current %.4g A; power: electrical %.2f W, mechanical %.2f W, lost in the winding %.2f W; voltage %.2f V: "
            "back EMF %.2f V, resistance %.3f V\n  time constant R J/Kt^2 %.2f ms (63 %% of the speed); J w/T as "
            "printed %.1f ms (to full speed at "
            "constant torque)\n", m->name, current, power + heat, power, heat, emf + fall, emf, fall, 1000*t_63,
            1000*m->inertia*m->speed/m->torque);
    fprintf(f, "  %-34s %10s %10s %9s %9s %9s %9s %10s %10s\n", "", "radius", "motor", "speed", "way v2/a",
            "time 2v/a", "efficiency",
            "true a", "true time");
    fprintf(f, "  %-34s %10s %10s %9s %9s %9s %9s %10s %10s\n", "", "[mm]", "[rad/s2]", "[m/s]", "[m]", "[s]", "", "[m/s2]", "[s]");
    const struct { const char *what; double r; } rows[] = {
        { "a J/T (leaves out the load)", lw_radius_printed(m, wanted) },
        { "least time, (s T/(2 w^2 m))^(1/3)", lw_radius_of_way(m, o->mass, o->way) },
        { "greatest acceleration, (J/m)^(1/2)", lw_radius_of_acceleration(m, o->mass) },
        { "least true time", lw_radius_best(m, o->mass, o->way) } };
    for (int i = 0; i < 4; i++) {
        lw_radius r = lw_radius_at(m, o->mass, o->way, wanted, rows[i].r);
        print_row(f, rows[i].what, &r);
    }
    if (o->acceleration > 0 && o->acceleration > best)
        fprintf(f, "  %g m/s^2 is impossible with this motor at any radius: its best is %.4f m/s^2 at r = %.3f mm\n",
                o->acceleration, best,
                1000*lw_radius_of_acceleration(m, o->mass));
    else if (o->acceleration > 0)
        fprintf(f, "  %g m/s^2 is possible for radii around %.3f mm, where it is %.4f m/s^2\n", o->acceleration,
                1000*lw_radius_of_acceleration(m, o->mass), best);
}

static void json_radius(cli_json *j, const char *key, const lw_radius *r)
{
    cli_json_object(j, key);
    cli_json_real(j, "radius", r->r);
    cli_json_real(j, "alpha", r->alpha);
    cli_json_real(j, "speed", r->speed);
    cli_json_real(j, "printed_way", r->printed_way);
    cli_json_real(j, "printed_time", r->printed_time);
    cli_json_real(j, "efficiency", r->efficiency);
    cli_json_real(j, "true_acceleration", r->acceleration);
    cli_json_real(j, "true_time", r->time);
    cli_json_end(j);
}

static void json_motor(cli_json *j, const lw_motor_part *m, const cli_drive_settings *o)
{
    double best = m->torque/(2*sqrt(m->inertia*o->mass)), wanted = o->acceleration > 0 ? o->acceleration : best;
    static const char *const keys[] = { "acceleration_formula", "way_formula", "greatest_acceleration", "least_time" };
    const double radii[] = { lw_radius_printed(m, wanted), lw_radius_of_way(m, o->mass, o->way),
                             lw_radius_of_acceleration(m, o->mass),
                             lw_radius_best(m, o->mass, o->way) };
    cli_json_object(j, NULL);
    cli_json_text(j, "motor", m->name);
    cli_json_real(j, "current", m->torque/m->torque_constant);
    cli_json_real(j, "best_acceleration", best);
    cli_json_bool(j, "possible", best >= wanted);
    for (int i = 0; i < 4; i++) {
        lw_radius r = lw_radius_at(m, o->mass, o->way, wanted, radii[i]);
        json_radius(j, keys[i], &r);
    }
    cli_json_end(j);
}

int cli_drive_radius(const cli_call *call)
{
    const cli_drive_settings *o = call->settings;
    lw_drive_parts p = { 0 };
    lw_error e = { 0 };
    lw_output out;
    if (!cli_given(&call->parsed, "mass") || !cli_given(&call->parsed, "way"))
        return cli_usage(call, "--mass and --way are needed");
    lw_status st = read_parts(call->parsed.word[1], &p, &e);
    if (st == LW_OK && p.n_motor == 0)
        st = lw_error_at(&e, LW_E_NOTATION, call->parsed.word[1], 0, 0, "this table holds no motor");
    if (st == LW_OK)
        st = cli_open(call, &out, &e);
    int code = st == LW_OK ? CLI_NOTHING : cli_fail(call, &e);
    if (st == LW_OK) {
        cli_json j = cli_json_begin(out.f, 2);
        if (call->common.json)
            cli_json_array(&j, NULL);
        for (int i = 0; i < p.n_motor && !cli_interrupted(); i++) {
            if (call->common.json)
                json_motor(&j, &p.motor[i], o);
            else
                print_motor(out.f, &p.motor[i], o);
            if (!(o->acceleration > p.motor[i].torque/(2*sqrt(p.motor[i].inertia*o->mass))))
                code = CLI_DONE;
        }
        if (call->common.json)
            cli_json_end(&j);
        code = cli_close(call, &out, code);
    }
    lw_drive_parts_free(&p);
    return code;
}
