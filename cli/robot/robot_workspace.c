/* cli/robot/robot_workspace.c - how far the tool gets from where it is: area, volume and directions. */
#include "cli/robot/robot.h"

#include <limits.h>
#include "catalogues/pages/draw.h"
#include "cli/program/json.h"
#include "cli/program/progress.h"
#include "mbs/space/star_volume.h"

static int draw_edge(const cli_robot *j, int n, const double *x, const double *y)
{
    lw_error e;
    lw_series edge = { .name = "", .n = (size_t)n, .x = x, .y = y };
    char label[2][40];
    snprintf(label[0], sizeof label[0], "to the right [%s]", j->unit);
    snprintf(label[1], sizeof label[1], "ahead [%s]", j->unit);
    lw_plot plot = { .title = "Workspace in the level plane of the tool", .x_label = label[0], .y_label = label[1],
                     .n_series = 1, .series = &edge, .equal = true, .width = 640, .height = 640 };
    return lw_draw_plot(&plot, j->s->plot, &e) < 0 ? cli_fail(j->call, &e) : CLI_DONE;
}

/* The table of a workspace, one row a ray. */
typedef struct ray_table { lw_output o; cli_json w; cli_progress progress; int n, endless; } ray_table;

/* Open the output and write the head: the key and the name of the unit, the units of the columns, and the columns before "limit". */
static int begin_rays(cli_robot *j, const char *what, const char *unit_key, const char *unit, const char *units, const char *columns, ray_table *t)
{
    const cli_call *call = j->call;
    if (cli_open(call, &t->o, &j->e) != LW_OK)
        return cli_fail(call, &j->e);
    t->n = t->endless = 0;
    t->progress = cli_progress_begin(call, what, "rays");
    t->w = cli_json_begin(t->o.f, 2);
    if (call->common.json) {
        cli_json_head(&t->w, call->line);
        cli_json_text(&t->w, unit_key, unit);
        cli_json_array(&t->w, "edge");
    } else
        fprintf(t->o.f, "# units: %s %s\n%s,limit\n", units, unit, columns);
    return CLI_DONE;
}

/* A row of n numbers, and the limit that ended the ray; `none`: the word where there was none.  all: number of rays, 0 unknown. */
static void put_ray(ray_table *t, const cli_robot *j, const double *row, int n, const char *none, int all)
{
    const char *limit = j->r.limit;
    t->endless += !limit[0];
    cli_progress_show(&t->progress, t->n++, all, NULL);
    if (j->call->common.json) {
        cli_json_reals(&t->w, NULL, row, (size_t)n);
        return;
    }
    for (int i = 0; i < n; i++)
        fprintf(t->o.f, "%.9g,", row[i]);
    cli_csv_text(t->o.f, limit[0] ? limit : none);
    fputc('\n', t->o.f);
}

/* End the table with what was found, `key`, and its estimated error, `error_key`; NULL: none. */
static void end_rays(ray_table *t, const cli_robot *j, const char *key, double value, const char *error_key, double error, bool whole)
{
    cli_progress_end(&t->progress);
    if (!j->call->common.json)
        return;
    cli_json_end(&t->w);
    if (key)
        cli_json_real(&t->w, key, value);
    if (error_key)
        cli_json_real(&t->w, error_key, error);
    cli_json_int(&t->w, "without_limit", t->endless);
    cli_json_bool(&t->w, "complete", whole);
    cli_json_end(&t->w);
}

static void note_endless(const ray_table *t, const cli_robot *j, const char *what)
{
    if (t->endless)
        cli_note(j->call, "no limit was found within %.6g %s in %d of %d directions: the %s counts them as far as that; a \"stop\" of "
                 "the joints limits them", 4*j->r.space.unit/j->metre, j->unit, t->endless, t->n, what);
}

/* Tilt the tool so that its axis leans towards this azimuth; in a plane, turn it in one of the two senses. */
static lw_status tilt(cli_robot *j, double azimuth, double *far)
{
    lw_mat3 tool = lw_quaternion_matrix(lw_robot_turn(&j->r));
    lw_vec3 axis = j->flat ? lw_v3_scale(j->r.normal, cos(azimuth)) : lw_v3_add(lw_v3_scale(lw_m3_column(&tool, 1), cos(azimuth)),
                                                                              lw_v3_scale(lw_m3_column(&tool, 0), -sin(azimuth)));
    return lw_robot_tilt(&j->r, axis, LW_PI*(1 - 1e-9), far, &j->e);
}

/* Reachability index: the share of all directions of the tool's axis, or of all angles in a plane (Makkonen 1999, paper B; Kumar & Waldron
 * 1981). */
int cli_robot_reachability(const cli_call *call)
{
    cli_robot j;
    lw_robot_pose p;
    ray_table t;
    int code = cli_robot_begin_ways(call, &j, &p, 0), done = 0;
    if (code == CLI_DONE && !j.r.turns) {
        lw_error_set(&j.e, LW_E_ARG, "the drives of this robot cannot turn the tool and keep its place");
        code = cli_fail(call, &j.e);
    }
    int n = j.flat ? 2 : j.s->rays;
    double sum = 0;
    if (code == CLI_DONE)
        code = begin_rays(&j, "reachability", "angle_unit", "deg", "direction tilt", "direction,tilt", &t);
    if (code != CLI_DONE) {
        cli_robot_end(&j);
        return code;
    }
    for (; done < n && !cli_interrupted(); done++) {
        double a = 2*LW_PI*done/n, far = 0;
        cli_robot_go_back(&j);
        if (tilt(&j, a, &far) != LW_OK) {
            code = cli_fail(call, &j.e);
            break;
        }
        sum += (j.flat ? far/LW_PI : 0.5*(1 - cos(far)))/n;
        put_ray(&t, &j, (double[]){ a*180/LW_PI, far*180/LW_PI }, 2, "none", n);
    }
    bool whole = code == CLI_DONE && done == n;
    end_rays(&t, &j, whole ? "reachability" : NULL, sum, NULL, 0, whole);
    if (whole)
        cli_note(call, "reachability index %.6g: the tool's axis reaches this share of all directions, by tilting from where it is", sum);
    code = cli_close(call, &t.o, code);
    cli_robot_end(&j);
    return code;
}

/* The volume while its rays are cast. */
typedef struct rays {
    cli_robot *j;
    ray_table table;
    lw_vec3   place;                             /* of the tool, where all rays begin                     */
    double    most;                              /* length of the longest ray [m]                         */
} rays;

static lw_status cast_ray(void *context, lw_vec3 way, double *far)
{
    rays *x = context;
    cli_robot *j = x->j;
    if (cli_interrupted())
        return LW_STOPPED;
    cli_robot_go_back(j);
    lw_status s = lw_robot_reach(&j->r, way, 4*j->r.space.unit, far, &j->e);
    if (s != LW_OK)
        return s;
    lw_vec3 at = lw_v3_scale(lw_v3_add(x->place, lw_v3_scale(way, *far)), 1/j->metre);
    double azimuth = atan2(lw_v3_dot(j->ahead, way), lw_v3_dot(j->right, way))*180/LW_PI;
    double row[] = { azimuth < 0 ? azimuth + 360 : azimuth, asin(fmax(-1, fmin(1, lw_v3_dot(j->up, way))))*180/LW_PI, *far/j->metre, at.x + 0.0,
                     at.y + 0.0, at.z + 0.0 };
    put_ray(&x->table, j, row, 6, "none found", 0);
    x->most = fmax(x->most, *far);
    return LW_OK;
}

#define VOLUME_SHARE 0.01                        /* error of the volume that is aimed at, over the volume */

static int run_volume(const cli_call *call)
{
    cli_robot j;
    lw_robot_pose p;
    lw_star_volume v = { 0 };
    rays x = { .j = &j };
    int code = cli_robot_begin_ways(call, &j, &p, 0);
    if (code == CLI_DONE && lw_v3_norm(j.r.normal) > 0) {
        lw_error_set(&j.e, LW_E_ARG, "a robot in a plane has no volume");
        code = cli_fail(call, &j.e);
    }
    if (code == CLI_DONE)
        code = begin_rays(&j, "workspace", "length_unit", j.unit, "direction elevation deg; distance x y z", "direction,elevation,distance,x,y,z", &x.table);
    if (code != CLI_DONE) {
        cli_robot_end(&j);
        return code;
    }
    x.place = p.place;
    double around = cli_given(&call->parsed, "rays") ? j.s->rays : 32, unit = pow(j.metre, 3);
    lw_status s = lw_star_volume_find((int)around, VOLUME_SHARE, (int)fmin(4*around*around, INT_MAX), cast_ray, &x, &v);
    bool whole = s == LW_OK;
    end_rays(&x.table, &j, whole ? "volume" : NULL, v.volume/unit, whole ? "volume_error" : NULL, v.error/unit, whole);
    if (s == LW_E_MEMORY)
        lw_error_set(&j.e, s, "out of memory");
    if (!whole && s != LW_STOPPED)
        code = cli_fail(call, &j.e);
    else if (whole && cli_robot_gets_nowhere(&j, &p, x.most))
        code = cli_robot_cannot_move(&j, &p);
    else if (whole) {
        note_endless(&x.table, &j, "volume");
        cli_note(call, "volume %.6g %s^3 around the tool, estimated error %.2g %%%s, at most %.6g %s from it", v.volume/unit, j.unit, 100*v.error/v.volume,
                 v.error > VOLUME_SHARE*v.volume ? " (more --rays lower it)" : "", x.most/j.metre, j.unit);
    }
    code = cli_close(call, &x.table.o, code);
    cli_robot_end(&j);
    return code;
}

/* Area of the polygon of every step-th of n ends of rays and the last, which is the first again. */
static double polygon_area(int n, int step, const double *x, const double *y)
{
    double area = 0;
    for (int i = 0, to; i < n; i = to) {
        to = i + step < n ? i + step : n;
        area += 0.5*(x[i]*y[to] - y[i]*x[to]);
    }
    return area;
}

int cli_robot_workspace(const cli_call *call)
{
    const cli_robot_settings *of = call->settings;
    if (of->volume && of->plot)
        return cli_usage(call, "--plot draws the edge in the level plane, which --volume leaves");
    if (of->volume)
        return run_volume(call);
    cli_robot j;
    lw_robot_pose p;
    ray_table t;
    double least = INFINITY, most = 0;
    int n = of->rays, code = cli_robot_begin_ways(call, &j, &p, 2*(size_t)n + 2), done = 0;
    if (code == CLI_DONE)
        code = begin_rays(&j, "workspace", "length_unit", j.unit, "direction deg; distance x y z", "direction,distance,x,y,z", &t);
    if (code != CLI_DONE) {
        cli_robot_end(&j);
        return code;
    }
    double *x = j.more, *y = x + n + 1;
    for (; done < n && !cli_interrupted(); done++) {
        double a = 2*LW_PI*done/n, far = 0;
        if (cli_robot_follow_ray(&j, a, &far) != LW_OK) {
            code = cli_fail(call, &j.e);
            break;
        }
        x[done] = far*cos(a)/j.metre;
        y[done] = far*sin(a)/j.metre;
        least = fmin(least, far), most = fmax(most, far);
        lw_vec3 at = lw_v3_scale(lw_v3_add(p.place, lw_v3_scale(cli_robot_direction(&j, a), far)), 1/j.metre);
        put_ray(&t, &j, (double[]){ a*180/LW_PI, far/j.metre, at.x + 0.0, at.y + 0.0, at.z + 0.0 }, 5, "none found", n);
    }
    bool whole = code == CLI_DONE && done == n;
    double area = 0, error = 0;
    if (whole) {
        x[n] = x[0], y[n] = y[0];
        area = polygon_area(n, 1, x, y);
        error = fabs(area - polygon_area(n, 2, x, y))/3;
    }
    end_rays(&t, &j, whole ? "area" : NULL, area, whole ? "area_error" : NULL, error, whole);
    if (whole && cli_robot_gets_nowhere(&j, &p, most))
        code = cli_robot_cannot_move(&j, &p);
    else if (whole) {
        note_endless(&t, &j, "area");
        cli_note(call, "area %.6g %s^2 in the level plane, estimated error %.2g %%, from %.6g to %.6g %s around the tool", area, j.unit, 100*error/area,
                 least/j.metre, most/j.metre, j.unit);
        if (j.s->plot)
            code = draw_edge(&j, n + 1, x, y);
    }
    code = cli_close(call, &t.o, code);
    cli_robot_end(&j);
    return code;
}
