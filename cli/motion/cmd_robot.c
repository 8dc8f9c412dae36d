/* linkwright robot - a model in space as a robot: Jacobian, workspace, maps of the condition number and of the lowest
 * eigenfrequency. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/vec3.h"
#include "catalogues/pages/draw.h"
#include "cli/motion/spatial.h"
#include "cli/motion/trace.h"
#include "cli/program/json.h"
#include "cli/program/model.h"
#include "cli/program/output.h"
#include "cli/program/progress.h"
#include "mbs/analysis/budget.h"
#include "mbs/analysis/held.h"
#include "mbs/space/space_adjust.h"
#include "mbs/space/star_volume.h"

typedef struct settings {
    const char *tool, *at, *turn, *drives, *plot, *force;
    double      max_condition, gap, play, slide_play;
    int         rays, grid;
    bool        links_only, frequency, budget, volume;
} settings;

#define PLACE(member) offsetof(settings, member)

static const cli_option options[] = {
    { "tool", 0, CLI_TEXT, PLACE(tool), "NAME", NULL, "tracer that is the tool; without it the first", 0, 0, NULL, NULL },
    { "tool-at", 0, CLI_TEXT, PLACE(at), "X,Y,Z", NULL,
      "move the tool there first, in the unit of the file; without it the place of the file", 0, 0, NULL, NULL },
    { "tool-turn", 0, CLI_TEXT, PLACE(turn), "RX,RY,RZ", NULL,
      "turn the tool on the way: angle times axis of the turn from its posture in the file [deg], in the plane one angle", 0, 0, NULL, NULL },
    { "drives-at", 0, CLI_TEXT, PLACE(drives), "V1,V2,...", NULL,
      "move the drives there first [deg, or the unit of the file], as `jacobian` prints them; without it their values in the file", 0, 0, NULL, NULL },
    { "max-condition", 0, CLI_REAL, PLACE(max_condition), "C", NULL,
      "workspace, map: only postures whose condition number is at most C", 1, 1e9, NULL, NULL },
    { "links-only", 0, CLI_FLAG, PLACE(links_only), NULL, NULL,
      "workspace, map: what the links alone can reach: stops and cones of joints do not count, nor do postures in which the "
      "drives lose the tool", 0, 0, NULL, NULL },
    { "rays", 0, CLI_INT, PLACE(rays), "N", "72", "workspace, reachability: number of directions, in the level plane or about the tool's axis", 3, 100000, NULL,
      NULL },
    { "volume", 0, CLI_FLAG, PLACE(volume), NULL, NULL,
      "workspace: move the tool in all directions of space, not in the level plane, and give the volume; --rays is the number of first directions "
      "around (32), and more are added where the edge bends", 0, 0, NULL, NULL },
    { "places", 0, CLI_INT, PLACE(grid), "N", "25", "map: number of places across the workspace", 2, 1000, NULL, NULL },
    { "eigenfrequency", 0, CLI_FLAG, PLACE(frequency), NULL, NULL,
      "map: the lowest eigenfrequency of a robot with elastic links, its drives held, too", 0, 0, NULL, NULL },
    { "joint-gap", 0, CLI_REAL, PLACE(gap), "G", "0",
      "budget, map: radial clearance of ball joints and pins that have none in the file, in its unit", 0, 1e9, NULL, NULL },
    { "gear-play", 0, CLI_REAL, PLACE(play), "DEG", "0", "budget, map: play of drives that turn, from end to end [deg]", 0, 360, NULL, NULL },
    { "slide-play", 0, CLI_REAL, PLACE(slide_play), "P", "0",
      "budget, map: play of drives that slide, from end to end, in the unit of the file", 0, 1e9, NULL, NULL },
    { "tool-force", 0, CLI_TEXT, PLACE(force), "FX,FY,FZ", NULL,
      "budget, map: force on the tool [N], which bends elastic links besides their weight", 0, 0, NULL, NULL },
    { "errors", 0, CLI_FLAG, PLACE(budget), NULL, NULL, "map: the error budget, too: worst case, rms and greatest contributor", 0, 0,
      NULL, NULL },
    { "plot", 'p', CLI_PLOT, PLACE(plot), "FILE", NULL,
      "workspace: draw its edge; map: draw the condition numbers, or frequencies (.svg, .pdf, .png)", 0, 0, NULL, NULL },
    { .name = NULL }
};

typedef struct job {
    const cli_call   *call;
    const settings   *s;
    lw_spatial       *given, *m;             /* read; its joints adjusted                            */
    lw_space_adjusted adjusted;
    bool              flat;                  /* read from a planar model                             */
    lw_robot          r;
    const char       *unit;
    double            metre;
    lw_quaternion     drawn;                 /* orientation of the tool in the file                  */
    lw_vec3           up, right, ahead;      /* of the level plane: right and ahead lie in it        */
    double           *q, *near, *more;       /* the posture in which all ways begin; numbers of the action (begin_ways) */
    lw_error          e;
} job;

static lw_spatial_measure drive_of(const job *j, int i)
{
    return j->m->n_drive ? j->m->drive[i] : j->m->input[i].measure;
}

static bool turns(const job *j, int i) { return drive_of(j, i).of == LW_OF_TURN; }

/* ---- beginning ------------------------------------------------------------------------------------------- */

/* Exactly n numbers with commas between them, whose squares are finite. */
static bool read_list(const char *text, int n, double *v)
{
    for (int i = 0; i < n; i++) {
        char *end;
        v[i] = strtod(text, &end);
        if (end == text || !(fabs(v[i]) < 1e100) || *end != (i < n - 1 ? ',' : 0))
            return false;
        text = end + 1;
    }
    return true;
}

/* Three numbers, or two of a planar model. */
static lw_status read_numbers(const job *j, const char *option, const char *unit, const char *text, lw_vec3 *p, lw_error *e)
{
    double v[3] = { 0 };
    if (!read_list(text, 3, v)) {
        v[2] = 0;
        if (!j->flat || !read_list(text, 2, v))
            return lw_error_set(e, LW_E_ARG, "%s takes %s numbers, such as %s [%s], not '%.60s'", option, j->flat ? "two" : "three",
                                j->flat ? "0.2,0.1" : "0.2,0,-0.65", unit, text);
    }
    *p = lw_v3(v[0], v[1], v[2]);
    return LW_OK;
}

/* --drives-at: forward kinematics. */
static lw_status move_drives(job *j, lw_error *e)
{
    double v[LW_ROBOT_DRIVES];
    if (!read_list(j->s->drives, j->r.n_drive, v))
        return lw_error_set(e, LW_E_ARG, "--drives-at takes %d number%s, one for each drive, not '%.60s'", j->r.n_drive, lw_plural(j->r.n_drive), j->s->drives);
    for (int i = 0; i < j->r.n_drive; i++)
        v[i] *= turns(j, i) ? LW_PI/180 : j->metre;
    return lw_robot_drive(&j->r, v, e);
}

/* --tool-at and --tool-turn: inverse kinematics. */
static lw_status move_tool(job *j, lw_error *e)
{
    lw_robot_pose p;
    lw_vec3 place, turn;
    double angle;
    lw_status st = lw_robot_measure(&j->r, &p, e);
    if (st != LW_OK)
        return st;
    place = lw_v3_scale(p.place, 1/j->metre);
    if (j->s->at && (st = read_numbers(j, "--tool-at", j->unit, j->s->at, &place, e)) != LW_OK)
        return st;
    place = lw_v3_scale(place, j->metre);
    if (!j->s->turn)
        return lw_robot_move(&j->r, place, NULL, e);
    if (!j->r.turns)
        return lw_error_set(e, LW_E_ARG, "--tool-turn: the drives of this robot cannot turn the tool and keep its place");
    if (j->flat && !read_list(j->s->turn, 1, &angle))
        return lw_error_set(e, LW_E_ARG, "--tool-turn takes one number in the plane, such as 20 [deg], not '%.60s'", j->s->turn);
    if (j->flat)
        turn = lw_v3_scale(j->r.normal, angle);
    else if ((st = read_numbers(j, "--tool-turn", "deg", j->s->turn, &turn, e)) != LW_OK)
        return st;
    lw_quaternion to = lw_quaternion_times(lw_quaternion_of_vector(lw_v3_scale(turn, LW_PI/180)), j->drawn);
    return lw_robot_move(&j->r, place, &to, e);
}

/* The reach of directions is that about the centre of a spherical wrist, where the tool's point lies beside it. */
static lw_status take_centre(job *j)
{
    lw_vec3 centre, *at = &j->adjusted.model.tracer[j->r.tool].at, given = *at;
    lw_status st = LW_OK;
    if (!lw_robot_centre(&j->r, &centre))
        return LW_OK;
    for (int k = 0; k < 2 && st == LW_OK && !j->r.only_turns; k++) {
        *at = k ? given : centre;
        lw_robot_free(&j->r);
        st = lw_robot_make(j->m, j->s->tool, &j->r, &j->e);
    }
    if (st == LW_OK && j->r.only_turns)
        cli_note(j->call, "the drives turn the tool about a point at rest, %.6g %s from its own: directions are those about this centre",
                 lw_v3_norm(lw_v3_sub(centre, given))/j->metre, j->unit);
    return st;
}

static int begin(const cli_call *call, job *j)
{
    struct lw_model *planar = NULL;
    *j = (job){ .call = call, .s = call->settings };
    lw_status st = cli_read_any_model(call->parsed.word[1], 0, &planar, &j->given, &j->e);
    if (st == LW_OK && planar) {
        lw_error e;
        j->flat = true;
        j->given = calloc(1, sizeof *j->given);
        st = j->given ? lw_spatial_of_planar(planar, j->given, &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
        cli_free_model(planar);
        if (st != LW_OK)
            lw_error_at(&j->e, st, call->parsed.word[1], 0, 0, "%s", e.text);
    }
    if (st == LW_OK && (st = lw_space_adjust(j->given, &j->adjusted, &j->e)) == LW_NOTHING)
        st = LW_OK;
    if (st != LW_OK)
        return cli_fail(call, &j->e);
    j->m = &j->adjusted.model;
    if (j->adjusted.moved > 0)
        lw_note_adjusted(cli_notes(call), j->adjusted.moved, j->adjusted.turned);
    j->unit = j->m->units.length[0] ? j->m->units.length : "m";
    j->metre = j->m->units.metre;
    st = lw_robot_make(j->m, j->s->tool, &j->r, &j->e);
    if (st == LW_OK && !j->r.turns && strcmp(call->parsed.word[0], "reachability") == 0)
        st = take_centre(j);
    if (st == LW_OK) {
        double g = lw_v3_norm(j->m->gravity);
        if (!lw_spatial_is_planar(j->m, &j->up))
            j->up = g > 0 ? lw_v3_scale(j->m->gravity, -1/g) : lw_v3(0, 0, 1);
        j->right = fabs(j->up.x) < 0.9 ? lw_v3(1, 0, 0) : lw_v3(0, 1, 0);
        j->right = lw_v3_sub(j->right, lw_v3_scale(j->up, lw_v3_dot(j->right, j->up)));
        j->right = lw_v3_scale(j->right, 1/lw_v3_norm(j->right));
        j->ahead = lw_v3_cross(j->up, j->right);
        j->r.free = j->s->links_only;
        j->r.condition_limit = cli_given(&call->parsed, "max-condition") ? j->s->max_condition : 0;
        j->drawn = lw_robot_turn(&j->r);
        if (j->s->drives)
            st = move_drives(j, &j->e);
        if (st == LW_OK && (j->s->at || j->s->turn))
            st = move_tool(j, &j->e);
    }
    return st == LW_OK ? CLI_DONE : cli_fail(call, &j->e);
}

static void end(job *j)
{
    lw_robot_free(&j->r);
    lw_space_adjusted_free(&j->adjusted);
    cli_free_spatial(j->given);
    free(j->q);
}

/* ---- jacobian -------------------------------------------------------------------------------------------- */

static void json_pose(const job *j, FILE *f, const lw_robot_pose *p)
{
    cli_json w = cli_json_begin(f, 2);
    double row[LW_ROBOT_DRIVES];
    char name[80];
    cli_json_head(&w, j->call->line);
    cli_json_text(&w, "length_unit", "m");
    cli_json_text(&w, "tool", j->m->tracer[j->r.tool].name);
    cli_json_reals(&w, "place", (double[]){ p->place.x, p->place.y, p->place.z }, 3);
    cli_json_reals(&w, "quaternion", (double[]){ p->turn.w, p->turn.x, p->turn.y, p->turn.z }, 4);
    cli_json_array(&w, "drives");
    for (int i = 0; i < j->r.n_drive; i++) {
        lw_spatial_measure_name(j->m, drive_of(j, i), name, sizeof name);
        cli_json_object(&w, NULL);
        cli_json_text(&w, "name", name);
        cli_json_real(&w, "value", p->drive[i]);
        cli_json_text(&w, "unit", turns(j, i) ? "rad" : "m");
        cli_json_end(&w);
    }
    cli_json_end(&w);
    cli_json_array(&w, "jacobian");
    for (int k = 0; k < 6; k++) {
        memcpy(row, p->jacobian[k], sizeof row);
        cli_json_reals(&w, NULL, row, (size_t)j->r.n_drive);
    }
    cli_json_end(&w);
    cli_json_text(&w, "singular_values_of", j->r.only_turns ? "turn" : "velocity");
    cli_json_reals(&w, "singular_values", p->singular, 3);
    cli_json_real(&w, "condition", p->condition);
    cli_json_real(&w, "isotropy", 1/p->condition);
    cli_json_real(&w, "manipulability", p->manipulability);
    cli_json_int(&w, "tool_freedoms", p->freedoms);
    cli_json_reals(&w, j->r.only_turns ? "moved_inertia" : "moved_mass", p->mass, p->mass[0] > 0 ? (size_t)p->rank : 0);
    cli_json_end(&w);
}

/* A number without the rounding of others of this size. */
static double clean(double v, double size) { return fabs(v) < 1e-13*size ? 0 : v; }

static void print_direction(FILE *f, lw_vec3 a)
{
    fprintf(f, "(%.6f, %.6f, %.6f)", clean(a.x, 1e6), clean(a.y, 1e6), clean(a.z, 1e6));
}

static void print_pose(const job *j, FILE *f, const lw_robot_pose *p)
{
    static const char *const row[] = { "vx", "vy", "vz", "wx", "wy", "wz" };
    char name[80];
    double size = j->r.space.unit;
    fprintf(f, "tool '%s' at (%.9g, %.9g, %.9g) %s\n", j->m->tracer[j->r.tool].name,
            clean(p->place.x, size)/j->metre, clean(p->place.y, size)/j->metre, clean(p->place.z, size)/j->metre, j->unit);
    lw_vec3 turn = lw_v3_scale(lw_quaternion_vector(lw_quaternion_times(p->turn, lw_quaternion_inverse(j->drawn))), 180/LW_PI);
    if (lw_v3_norm(turn) > 1e-9)
        fprintf(f, "turned by (%.9g, %.9g, %.9g) deg from its posture in the file\n", clean(turn.x, 100), clean(turn.y, 100), clean(turn.z, 100));
    for (int i = 0; i < j->r.n_drive; i++) {
        lw_spatial_measure_name(j->m, drive_of(j, i), name, sizeof name);
        fprintf(f, "drive %-24s %.10g %s\n", name, clean(p->drive[i], turns(j, i) ? 1 : size)/(turns(j, i) ? LW_PI/180 : j->metre),
                turns(j, i) ? "deg" : j->unit);
    }
    fprintf(f, "Jacobian: velocity of the tool [m/s] and its turn [rad/s] by the rates of the drives [rad/s] or [m/s]\n");
    for (int k = 0; k < 6; k++) {
        fprintf(f, "  %s", row[k]);
        for (int i = 0; i < j->r.n_drive; i++)
            fprintf(f, " %15.9g", clean(p->jacobian[k][i], 100*p->singular[0]));
        fputc('\n', f);
    }
    fprintf(f, "singular values%s", j->r.only_turns ? " of the turn, since the tool's point is at rest:" : "");
    for (int i = 0; i < p->rank; i++) {
        fprintf(f, "%s %.9g in ", i ? ";" : "", p->singular[i]);
        print_direction(f, lw_m3_column(&p->axes, i));
    }
    fprintf(f, "\ncondition %.9g, isotropy %.6g, manipulability %.6g\n", p->condition, 1/p->condition, p->manipulability);
    int turning = 0;
    for (int i = 0; i < j->r.n_drive; i++)
        turning += turns(j, i);
    if (turning > 0 && turning < j->r.n_drive)
        fputs("drives turn and slide: singular values and condition depend on the unit of length, here the metre\n", f);
    if (isinf(p->condition)) {
        fprintf(f, j->r.only_turns ? "here the tool cannot turn about" : "here the tool's point cannot move in");
        for (int i = 0, n = 0; i < p->rank; i++)
            if (p->singular[i] <= 0) {
                fprintf(f, n++ ? "; " : " ");
                print_direction(f, lw_m3_column(&p->axes, i));
            }
        fprintf(f, p->freedoms < j->r.freedoms ? ": a singular posture, place and turn of the tool have %d of %d freedoms\n"
                : ": place and turn of the tool together have all %d of %d freedoms, the drives turn it instead\n", p->freedoms, j->r.freedoms);
    }
    if (p->mass[0] > 0) {
        fputs(j->r.only_turns ? "inertia that a moment on the tool turns [kg m^2]" : "mass that a force on the tool moves [kg]", f);
        for (int i = 0; i < p->rank; i++) {
            fprintf(f, "%s %.6g in ", i ? ";" : "", p->mass[i]);
            print_direction(f, lw_m3_column(&p->mass_axes, i));
        }
        fputc('\n', f);
    }
}

static int run_jacobian(const cli_call *call)
{
    job j;
    lw_robot_pose p;
    lw_output o;
    int code = begin(call, &j);
    if (code == CLI_DONE && (lw_robot_measure(&j.r, &p, &j.e) != LW_OK || cli_open(call, &o, &j.e) != LW_OK))
        code = cli_fail(call, &j.e);
    if (code == CLI_DONE) {
        (call->common.json ? json_pose : print_pose)(&j, o.f, &p);
        code = cli_close(call, &o, CLI_DONE);
    }
    end(&j);
    return code;
}

/* ---- budget ---------------------------------------------------------------------------------------------- */

static lw_status budget_options(const job *j, lw_budget_options *o, lw_error *e)
{
    const settings *s = j->s;
    *o = (lw_budget_options){ .clearance = s->gap*j->metre, .play = { s->play*LW_PI/360, s->slide_play*j->metre/2 }, .weight = true };
    lw_status st = s->force ? read_numbers(j, "--tool-force", "N", s->force, &o->load, e) : LW_OK;
    bool any = j->m->n_elastic > 0 || s->gap > 0 || s->play > 0 || s->slide_play > 0;
    for (int i = 0; i < j->m->n_joint; i++)
        any = any || j->m->joint[i].clearance.model > LW_CLEARANCE_NONE;
    return st != LW_OK || any ? st
         : lw_error_set(e, LW_E_ARG, "nothing lets the tool stray: no joint has a \"clearance\" and no link is elastic; give "
                        "--joint-gap, --gear-play or --slide-play");
}

/* "clearance of P1a" */
static const char *source_name(const lw_budget_source *s, char *text, size_t size)
{
    static const char *const of[] = { "clearance of", "play of", "bending of" };
    snprintf(text, size, "%s %s", of[s->kind], s->name);
    return text;
}

static void print_budget(const job *j, FILE *f, const lw_robot_pose *p, const lw_budget *b)
{
    char name[96];
    double u = j->metre, size = j->r.space.unit;
    fprintf(f, "tool '%s' at (%.9g, %.9g, %.9g) %s\n%-40s %12s %12s  %s\n", j->m->tracer[j->r.tool].name, clean(p->place.x, size)/u,
            clean(p->place.y, size)/u, clean(p->place.z, size)/u, j->unit, "source", "worst", "rms", "share of rms^2");
    for (int i = 0; i < b->n; i++) {
        const lw_budget_source *s = &b->source[i];
        fprintf(f, "%-40s %12.5g %12.5g  %.1f %%\n", source_name(s, name, sizeof name), s->worst/u, s->rms/u,
                b->rms > 0 ? 100*s->rms*s->rms/(b->rms*b->rms) : 0);
    }
    fprintf(f, "%-40s %12.5g %12.5g  [%s]\n", "all together", b->worst/u, b->rms/u, j->unit);
    if (!(b->worst > 0)) {
        fputs("nothing moves the tool: give the sources by --joint-gap, --gear-play, --slide-play or elastic links\n", f);
        return;
    }
    fputs("worst towards ", f);
    print_direction(f, b->direction);
    fprintf(f, "; greatest contributor: %s\n", source_name(&b->source[0], name, sizeof name));
}

static void json_budget(const job *j, FILE *f, const lw_robot_pose *p, const lw_budget *b)
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

static int run_budget(const cli_call *call)
{
    job j;
    lw_robot_pose p;
    lw_output o;
    lw_budget_options how;
    lw_budget_stiffness stiff = { 0 };
    lw_budget b = { 0 };
    int code = begin(call, &j);
    if (code == CLI_DONE && (budget_options(&j, &how, &j.e) != LW_OK || lw_robot_measure(&j.r, &p, &j.e) != LW_OK ||
                             lw_budget_stiffness_make(j.m, &how, &stiff, &j.e) != LW_OK ||
                             lw_budget_make(&j.r, &stiff, &how, &b, &j.e) != LW_OK || cli_open(call, &o, &j.e) != LW_OK))
        code = cli_fail(call, &j.e);
    if (code == CLI_DONE) {
        (call->common.json ? json_budget : print_budget)(&j, o.f, &p, &b);
        code = cli_close(call, &o, CLI_DONE);
    }
    lw_budget_free(&b);
    lw_budget_stiffness_free(&stiff);
    end(&j);
    return code;
}

/* ---- workspace ------------------------------------------------------------------------------------------- */

static lw_vec3 direction(const job *j, double angle)
{
    return lw_v3_add(lw_v3_scale(j->right, cos(angle)), lw_v3_scale(j->ahead, sin(angle)));
}

/* Can the drives not move the tool?  It counts as moved if it goes farther than 1e-5 of the robot's size: on a sphere of this size it seems to
 * follow its tangent so far, within the accuracy of a way.  From a singular posture the
 * drives move it in some directions only, unless the tool's own place is the input. */
static bool gets_nowhere(const job *j, const lw_robot_pose *p, double far)
{
    return far < 1e-5*j->r.space.unit || (isinf(p->condition) && !j->r.by_tool.memory);
}

/* Report a tool that cannot move: it has no workspace and no map. */
static int cannot_move(job *j, const lw_robot_pose *p)
{
    char exceeded[80];
    snprintf(exceeded, sizeof exceeded, ": the condition number %.6g there exceeds --max-condition", p->condition);
    lw_error_set(&j->e, LW_OPEN, "the drives cannot move the tool from (%.9g, %.9g, %.9g) %s in the level plane%s; begin from "
                 "another posture", p->place.x/j->metre + 0.0, p->place.y/j->metre + 0.0, p->place.z/j->metre + 0.0, j->unit,
                 j->r.condition_limit > 0 && p->condition > j->r.condition_limit ? exceeded : j->r.only_turns ? ": they only turn it" : j->r.rank == 2 && lw_v3_norm(j->r.normal) == 0 ? ": it moves on a surface that is not level"
                 : isinf(p->condition) ? ": the posture is singular, or the robot lacks this freedom (robot jacobian shows where the tool can go)" : "");
    return cli_fail(j->call, &j->e);
}

/* Begin an action whose ways all begin where the tool is now, with room for `more` numbers. */
static int begin_ways(const cli_call *call, job *j, lw_robot_pose *p, size_t more)
{
    int code = begin(call, j);
    if (code != CLI_DONE)
        return code;
    if (lw_robot_measure(&j->r, p, &j->e) != LW_OK)
        return cli_fail(call, &j->e);
    size_t n_q = (size_t)j->r.space.n_q, n_near = (size_t)j->r.follow.z.n_near;
    if (!(j->q = malloc((n_q + n_near + more + 1)*sizeof *j->q))) {
        lw_error_set(&j->e, LW_E_MEMORY, "out of memory");
        return cli_fail(call, &j->e);
    }
    j->near = j->q + n_q;
    j->more = j->near + n_near;
    memcpy(j->q, j->r.follow.q, n_q*sizeof *j->q);
    memcpy(j->near, j->r.follow.z.near, n_near*sizeof *j->near);
    if (j->r.condition_limit > 0 && j->r.n_drive > (j->r.turns ? j->r.freedoms : j->r.rank))
        cli_note(call, "the robot has more drives than its tool needs, so its posture at a place depends on the way there: condition numbers differ by some "
                 "percent between ways, and places near --max-condition may count or not");
    return CLI_DONE;
}

static void go_back(job *j)
{
    memcpy(j->r.follow.q, j->q, (size_t)j->r.space.n_q*sizeof *j->q);
    memcpy(j->r.follow.z.near, j->near, (size_t)j->r.follow.z.n_near*sizeof *j->near);
}

static lw_status follow_ray(job *j, double angle, double *far)
{
    go_back(j);
    return lw_robot_reach(&j->r, direction(j, angle), 4*j->r.space.unit, far, &j->e);
}

static int draw_edge(const job *j, int n, const double *x, const double *y)
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
static int begin_rays(job *j, const char *what, const char *unit_key, const char *unit, const char *units, const char *columns, ray_table *t)
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
static void put_ray(ray_table *t, const job *j, const double *row, int n, const char *none, int all)
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
static void end_rays(ray_table *t, const job *j, const char *key, double value, const char *error_key, double error, bool whole)
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

static void note_endless(const ray_table *t, const job *j, const char *what)
{
    if (t->endless)
        cli_note(j->call, "no limit was found within %.6g %s in %d of %d directions: the %s counts them as far as that; a \"stop\" of "
                 "the joints limits them", 4*j->r.space.unit/j->metre, j->unit, t->endless, t->n, what);
}

/* Tilt the tool so that its axis leans towards this azimuth; in a plane, turn it in one of the two senses. */
static lw_status tilt(job *j, double azimuth, double *far)
{
    lw_mat3 tool = lw_quaternion_matrix(lw_robot_turn(&j->r));
    lw_vec3 axis = j->flat ? lw_v3_scale(j->r.normal, cos(azimuth)) : lw_v3_add(lw_v3_scale(lw_m3_column(&tool, 1), cos(azimuth)),
                                                                              lw_v3_scale(lw_m3_column(&tool, 0), -sin(azimuth)));
    return lw_robot_tilt(&j->r, axis, LW_PI*(1 - 1e-9), far, &j->e);
}

/* Reachability index: the share of all directions of the tool's axis, or of all angles in a plane (Makkonen 1999, paper B; Kumar & Waldron
 * 1981). */
static int run_reachability(const cli_call *call)
{
    job j;
    lw_robot_pose p;
    ray_table t;
    int code = begin_ways(call, &j, &p, 0), done = 0;
    if (code == CLI_DONE && !j.r.turns) {
        lw_error_set(&j.e, LW_E_ARG, "the drives of this robot cannot turn the tool and keep its place");
        code = cli_fail(call, &j.e);
    }
    int n = j.flat ? 2 : j.s->rays;
    double sum = 0;
    if (code == CLI_DONE)
        code = begin_rays(&j, "reachability", "angle_unit", "deg", "direction tilt", "direction,tilt", &t);
    if (code != CLI_DONE) {
        end(&j);
        return code;
    }
    for (; done < n && !cli_interrupted(); done++) {
        double a = 2*LW_PI*done/n, far = 0;
        go_back(&j);
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
    end(&j);
    return code;
}

/* The volume while its rays are cast. */
typedef struct rays {
    job      *j;
    ray_table table;
    lw_vec3   place;                             /* of the tool, where all rays begin                     */
    double    most;                              /* length of the longest ray [m]                         */
} rays;

static lw_status cast_ray(void *context, lw_vec3 way, double *far)
{
    rays *x = context;
    job *j = x->j;
    if (cli_interrupted())
        return LW_STOPPED;
    go_back(j);
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
    job j;
    lw_robot_pose p;
    lw_star_volume v = { 0 };
    rays x = { .j = &j };
    int code = begin_ways(call, &j, &p, 0);
    if (code == CLI_DONE && lw_v3_norm(j.r.normal) > 0) {
        lw_error_set(&j.e, LW_E_ARG, "a robot in a plane has no volume");
        code = cli_fail(call, &j.e);
    }
    if (code == CLI_DONE)
        code = begin_rays(&j, "workspace", "length_unit", j.unit, "direction elevation deg; distance x y z", "direction,elevation,distance,x,y,z", &x.table);
    if (code != CLI_DONE) {
        end(&j);
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
    else if (whole && gets_nowhere(&j, &p, x.most))
        code = cannot_move(&j, &p);
    else if (whole) {
        note_endless(&x.table, &j, "volume");
        cli_note(call, "volume %.6g %s^3 around the tool, estimated error %.2g %%%s, at most %.6g %s from it", v.volume/unit, j.unit, 100*v.error/v.volume,
                 v.error > VOLUME_SHARE*v.volume ? " (more --rays lower it)" : "", x.most/j.metre, j.unit);
    }
    code = cli_close(call, &x.table.o, code);
    end(&j);
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

static int run_workspace(const cli_call *call)
{
    const settings *of = call->settings;
    if (of->volume && of->plot)
        return cli_usage(call, "--plot draws the edge in the level plane, which --volume leaves");
    if (of->volume)
        return run_volume(call);
    job j;
    lw_robot_pose p;
    ray_table t;
    double least = INFINITY, most = 0;
    int n = of->rays, code = begin_ways(call, &j, &p, 2*(size_t)n + 2), done = 0;
    if (code == CLI_DONE)
        code = begin_rays(&j, "workspace", "length_unit", j.unit, "direction deg; distance x y z", "direction,distance,x,y,z", &t);
    if (code != CLI_DONE) {
        end(&j);
        return code;
    }
    double *x = j.more, *y = x + n + 1;
    for (; done < n && !cli_interrupted(); done++) {
        double a = 2*LW_PI*done/n, far = 0;
        if (follow_ray(&j, a, &far) != LW_OK) {
            code = cli_fail(call, &j.e);
            break;
        }
        x[done] = far*cos(a)/j.metre;
        y[done] = far*sin(a)/j.metre;
        least = fmin(least, far), most = fmax(most, far);
        lw_vec3 at = lw_v3_scale(lw_v3_add(p.place, lw_v3_scale(direction(&j, a), far)), 1/j.metre);
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
    if (whole && gets_nowhere(&j, &p, most))
        code = cannot_move(&j, &p);
    else if (whole) {
        note_endless(&t, &j, "area");
        cli_note(call, "area %.6g %s^2 in the level plane, estimated error %.2g %%, from %.6g to %.6g %s around the tool", area, j.unit, 100*error/area,
                 least/j.metre, most/j.metre, j.unit);
        if (j.s->plot)
            code = draw_edge(&j, n + 1, x, y);
    }
    code = cli_close(call, &t.o, code);
    end(&j);
    return code;
}

/* ---- map ------------------------------------------------------------------------------------------------- */

#define BANDS 6

typedef struct map {
    bool   frequency, budget;                    /* asked for: --eigenfrequency, --errors                 */
    double *x, *y, *value;                       /* (grid * grid) places and what the plot shows of them  */
    int    n, lost;                              /* places measured; places that the tool does not reach  */
    lw_held held;
    lw_budget_options how;
    lw_budget_stiffness stiff;
    lw_robot_pose pose;                          /* of the last place, with what is asked for             */
    double hertz;
    lw_budget errors;
    double worst;                                /* greatest error of the tool [m], where, by which source */
    lw_vec3 worst_at;
    char   worst_by[96];
} map;

/* Edges of bands for frequencies: even steps of 1, 2, 2.5 or 5 times a power of ten. */
static void even_edges(const map *m, double edge[BANDS + 1])
{
    double least = INFINITY, most = 0;
    for (int i = 0; i < m->n; i++)
        least = fmin(least, m->value[i]), most = fmax(most, m->value[i]);
    double rough = fmax(most - least, 1e-3*most + 1e-9)/(BANDS - 1), ten = pow(10, floor(log10(rough)));
    double step = ten*(rough <= ten ? 1 : rough <= 2*ten ? 2 : rough <= 2.5*ten ? 2.5 : rough <= 5*ten ? 5 : 10), first = step*floor(least/step);
    for (int b = 0; b <= BANDS; b++)
        edge[b] = first + b*step;
}

/* Edges of bands for errors, which grow much towards the edge of the workspace: 1, 2, 5, 10, ... times a power of ten. */
static void rising_edges(const map *m, double edge[BANDS + 1])
{
    static const double step[] = { 1, 2, 5 };
    double least = INFINITY;
    for (int i = 0; i < m->n; i++)
        least = fmin(least, m->value[i]);
    double ten = least > 0 ? pow(10, floor(log10(least)*(1 + 1e-12))) : 1;
    int first = least >= 5*ten ? 2 : least >= 2*ten ? 1 : 0;
    for (int b = 0; b < BANDS; b++)
        edge[b] = step[(first + b)%3]*ten*pow(10, (first + b)/3);
    edge[0] = fmin(edge[0], least);
    edge[BANDS] = INFINITY;
}

/* Points by bands of the value. */
static int draw_map(const job *j, const map *m, const char *path, int code)
{
    lw_series series[BANDS];
    char name[BANDS][40], label[2][40];
    lw_error e;
    double edge[BANDS + 1] = { 1, 1.5, 2, 3, 5, 10, INFINITY };
    if (m->budget)
        rising_edges(m, edge);
    else if (m->frequency)
        even_edges(m, edge);
    double *xy = malloc(2*(size_t)m->n*sizeof *xy + 1);
    int used = 0, n_series = 0;
    if (!xy)
        return cli_fail(j->call, &(lw_error){ .status = LW_E_MEMORY, .text = "out of memory" });
    for (int b = 0; b < BANDS; b++) {
        int first = used;
        for (int i = 0; i < m->n; i++)
            if (m->value[i] >= edge[b] && m->value[i] < edge[b + 1]) {
                xy[used] = m->x[i];
                xy[m->n + used++] = m->y[i];
            }
        if (isfinite(edge[b + 1]))
            snprintf(name[b], sizeof name[b], "%g to %g%s", edge[b], edge[b + 1], m->budget || !m->frequency ? "" : " Hz");
        else
            snprintf(name[b], sizeof name[b], "above %g", edge[b]);
        if (used > first)
            series[n_series++] = (lw_series){ .name = name[b], .n = (size_t)(used - first), .x = xy + first,
                                              .y = xy + m->n + first, .style = LW_SERIES_POINTS };
    }
    snprintf(label[0], sizeof label[0], "to the right [%s]", j->unit);
    snprintf(label[1], sizeof label[1], "ahead [%s]", j->unit);
    lw_plot plot = { .title = m->budget ? "Greatest error of the tool" : m->frequency ? "Lowest eigenfrequency, drives held" : "Condition number of the Jacobian",
                     .x_label = label[0], .y_label = label[1], .n_series = n_series, .series = series, .equal = true, .width = 760, .height = 640 };
    lw_status st = lw_draw_plot(&plot, path, &e);
    free(xy);
    return st < 0 ? cli_fail(j->call, &e) : code;
}

static void map_free(map *m)
{
    lw_budget_free(&m->errors);
    lw_budget_stiffness_free(&m->stiff);
    lw_held_free(&m->held);
}

/* Whatever the places need beside the posture itself. */
static int map_begin(job *j, map *m)
{
    *m = (map){ .frequency = j->s->frequency, .budget = j->s->budget };
    bool ready = (!m->frequency || lw_held_make(j->m, &m->held, &j->e) == LW_OK) &&
                 (!m->budget || (budget_options(j, &m->how, &j->e) == LW_OK && lw_budget_stiffness_make(j->m, &m->how, &m->stiff, &j->e) == LW_OK));
    return ready ? CLI_DONE : cli_fail(j->call, &j->e);
}

/* Half the width of the grid: how far the tool gets in twelve directions, and a little more. */
static double map_reach(job *j)
{
    double reach = 0;
    for (int i = 0; i < 12 && !cli_interrupted(); i++) {
        double far = 0;
        if (follow_ray(j, 2*LW_PI*i/12, &far) == LW_OK)
            reach = fmax(reach, far);
    }
    return 1.02*reach;
}

/* Move the tool to a place and measure it there.  LW_OPEN: it is not reached, or the drives lose the tool there. */
static lw_status map_measure(job *j, map *m, lw_vec3 to)
{
    static const double near_limits = 1e-5;      /* of the size: a place so near to a limit may count as not reached */
    go_back(j);
    j->r.least = near_limits;
    lw_status st = lw_robot_move(&j->r, to, NULL, &j->e);
    if (st == LW_OK)
        st = lw_robot_measure(&j->r, &m->pose, &j->e);
    if (st == LW_OK && m->frequency && (st = lw_held_frequency(&m->held, &j->r, &m->hertz, &j->e)) == LW_OPEN)
        st = LW_E_NUMERIC;
    if (st == LW_OK && m->budget) {
        lw_budget_free(&m->errors);
        st = lw_budget_make(&j->r, &m->stiff, &m->how, &m->errors, &j->e);
    }
    return st;
}

static void map_head(const job *j, const map *m, cli_json *w, FILE *f)
{
    if (w) {
        cli_json_head(w, j->call->line);
        cli_json_text(w, "length_unit", j->unit);
        cli_json_array(w, "places");
    } else
        fprintf(f, "# units: x y z %s; singular values m/rad or m/m%s%s%s\nx,y,z,condition,greatest,least,manipulability%s%s\n", j->unit,
                m->frequency ? "; frequency Hz" : "", m->budget ? "; error_worst error_rms " : "", m->budget ? j->unit : "",
                m->frequency ? ",frequency" : "", m->budget ? ",error_worst,error_rms,contributor" : "");
}

/* A place as an object of w, or as a line if w is NULL. */
static void put_place(const job *j, const map *m, cli_json *w, FILE *f, lw_vec3 at, const char *by)
{
    const lw_robot_pose *p = &m->pose;
    double place[] = { at.x/j->metre + 0.0, at.y/j->metre + 0.0, at.z/j->metre + 0.0 };
    double value[] = { p->condition, p->singular[0], p->singular[p->rank - 1], p->manipulability };
    static const char *const key[] = { "condition", "greatest", "least", "manipulability" };
    if (w) {
        cli_json_object(w, NULL);
        cli_json_reals(w, "place", place, 3);
    } else
        fprintf(f, "%.9g,%.9g,%.9g", place[0], place[1], place[2]);
    for (int i = 0; i < 4; i++)
        w ? cli_json_real(w, key[i], value[i]) : (void)fprintf(f, ",%.9g", value[i]);
    if (m->frequency)
        w ? cli_json_real(w, "frequency", m->hertz) : (void)fprintf(f, ",%.9g", m->hertz);
    if (m->budget && w) {
        cli_json_real(w, "error_worst", m->errors.worst/j->metre);
        cli_json_real(w, "error_rms", m->errors.rms/j->metre);
        cli_json_text(w, "contributor", by);
    } else if (m->budget) {
        fprintf(f, ",%.9g,%.9g,", m->errors.worst/j->metre, m->errors.rms/j->metre);
        cli_csv_text(f, by);
    }
    w ? cli_json_end(w) : (void)fputc('\n', f);
}

/* The place of the grid at (a, b) to the right and ahead of `centre`: measured, written and kept for the plot. */
static lw_status map_visit(job *j, map *m, lw_vec3 centre, double a, double b, cli_json *w, FILE *f)
{
    char name[96];
    lw_vec3 to = lw_v3_add(centre, lw_v3_add(lw_v3_scale(j->right, a), lw_v3_scale(j->ahead, b)));
    lw_status st = map_measure(j, m, to);
    m->lost += st == LW_OPEN;
    if (st != LW_OK)
        return st == LW_OPEN ? LW_OK : st;
    const char *by = m->errors.n ? source_name(&m->errors.source[0], name, sizeof name) : "";
    put_place(j, m, w, f, to, by);
    if (m->budget && m->errors.worst > m->worst) {
        m->worst = m->errors.worst, m->worst_at = to;
        snprintf(m->worst_by, sizeof m->worst_by, "%s", by);
    }
    m->x[m->n] = a/j->metre;
    m->y[m->n] = b/j->metre;
    m->value[m->n++] = m->budget ? m->errors.worst/j->metre : m->frequency ? m->hertz : m->pose.condition;
    return LW_OK;
}

static void map_notes(const job *j, const map *m)
{
    cli_note(j->call, "%d place%s; %d of the grid %s not reached on a straight way from the tool", m->n, lw_plural(m->n), m->lost,
             m->lost == 1 ? "is" : "are");
    if (m->worst > 0)
        cli_note(j->call, "error of the tool at most %.4g %s, at (%.6g, %.6g, %.6g) %s, where the greatest contributor is the %s", m->worst/j->metre,
                 j->unit, m->worst_at.x/j->metre, m->worst_at.y/j->metre, m->worst_at.z/j->metre, j->unit, m->worst_by);
}

/* The places of the map, and its notes. */
static int write_map(job *j, map *m, const lw_robot_pose *p, FILE *f)
{
    const cli_call *call = j->call;
    int n = j->s->grid, code = CLI_DONE;
    double reach = map_reach(j);
    if (gets_nowhere(j, p, reach) && !cli_interrupted())
        code = cannot_move(j, p), n = 0;
    j->r.least = 1e-4;                           /* where ways end is not shown */
    cli_progress progress = cli_progress_begin(call, "map", "places");
    cli_json json = cli_json_begin(f, 2), *w = call->common.json ? &json : NULL;
    map_head(j, m, w, f);
    for (int i = 0; i < n*n && !cli_interrupted(); i++) {
        double a = reach*(2.0*(i % n)/(n - 1) - 1), b = reach*(2.0*(i/n)/(n - 1) - 1);
        if (map_visit(j, m, p->place, a, b, w, f) != LW_OK) {
            code = cli_fail(call, &j->e);
            break;
        }
        cli_progress_show(&progress, i, (double)n*n, NULL);
    }
    cli_progress_end(&progress);
    if (w) {
        cli_json_end(w);
        cli_json_bool(w, "complete", code == CLI_DONE && !cli_interrupted());
        cli_json_end(w);
    }
    if (n > 0)
        map_notes(j, m);
    return code;
}

static int run_map(const cli_call *call)
{
    job j;
    map m = { .n = 0 };
    lw_robot_pose p;
    lw_output o;
    size_t most = (size_t)((const settings *)call->settings)->grid;
    most *= most;
    int code = begin_ways(call, &j, &p, 3*most);
    if (code == CLI_DONE)
        code = map_begin(&j, &m);
    if (code == CLI_DONE && cli_open(call, &o, &j.e) != LW_OK)
        code = cli_fail(call, &j.e);
    if (code == CLI_DONE) {
        m.x = j.more, m.y = m.x + most, m.value = m.y + most;
        code = write_map(&j, &m, &p, o.f);
        code = cli_close(call, &o, code == CLI_DONE && m.n == 0 ? CLI_NOTHING : code);
        char partial[LW_PATH_SIZE + 16];
        const char *to = j.s->plot && m.n > 0 ? cli_picture_path(call, j.s->plot, code, partial) : NULL;
        if (to)
            code = draw_map(&j, &m, to, code);
    }
    map_free(&m);
    end(&j);
    return code;
}

/* ---- the command ----------------------------------------------------------------------------------------- */

static const cli_action actions[] = {
    { "jacobian", "MODEL.json",
      "Prints where the tool is, the values of the drives, the Jacobian, its singular values and condition number, and the\n"
      "mass that a force on the tool moves in each direction.\n",
      1, 1, run_jacobian, CLI_LINKAGE, "text" },
    { "budget", "MODEL.json",
      "Prints how far the tool can stray from where its drives should hold it: by the clearance of joints (in the file, or\n"
      "--joint-gap), the play of gears (--gear-play, --slide-play), and elastic links under their weight and --tool-force. By\n"
      "source and all together: worst case, and rms for gaps and play in any direction. `map --errors` does it over a grid.\n",
      1, 1, run_budget, CLI_LINKAGE, "text" },
    { "workspace", "MODEL.json",
      "Moves the tool from where it is outwards in the level plane, in each of --rays directions, and prints how far it gets\n"
      "and what stops it: the links, a stop or a cone of a joint, a posture in which the drives lose the tool, or\n"
      "--max-condition. The area is that of the polygon of these ends; its error is estimated by that of every second end. --volume moves it in all directions of space.\n",
      1, 1, run_workspace, CLI_LINKAGE, NULL },
    { "reachability", "MODEL.json",
      "Tilts the tool where it is, in each of --rays directions, until something stops it, and prints how far it gets (180 deg: all\n"
      "round). The reachability index is the share of all directions that its axis reaches, z of the tool's \"frame\"; of a\n"
      "robot in a plane, the share of all angles. An index of 1 means that the place is in the dexterous workspace.\n",
      1, 1, run_reachability, CLI_LINKAGE, NULL },
    { "map", "MODEL.json",
      "Prints condition number, singular values and manipulability over a grid in the level plane of the tool, at the places\n"
      "that it reaches on a straight way. --eigenfrequency adds the lowest eigenfrequency of its elastic links while the drives are\n"
      "held, without gravity and loads.\n",
      1, 1, run_map, CLI_LINKAGE, NULL },
    { .name = NULL }
};

const cli_command cli_robot_command = {
    .name = "robot",
    .words = "ACTION MODEL.json",
    .title = "a model as a robot: Jacobian, workspace, condition number, lowest frequency, error budget",
    .examples =
        "  linkwright robot jacobian examples/space/delta.json                    in the posture of the file\n"
        "  linkwright robot jacobian examples/space/delta.json --tool-at 0.2,0,-0.65   elsewhere, with the drives' values\n"
        "  linkwright robot workspace examples/space/delta.json --tool-at 0,0,-0.65 --max-condition 5 --plot edge.svg\n"
        "  linkwright robot workspace examples/space/delta.json --volume          in all directions of space\n"
        "  linkwright robot reachability examples/space/stewart.json              how far the platform tilts\n"
        "  linkwright robot map examples/space/delta.json --tool-at 0,0,-0.65 --plot map.svg\n"
        "  linkwright robot map examples/space/delta-elastic.json --eigenfrequency --plot hertz.svg   stiff and soft places\n"
        "  linkwright robot jacobian examples/space/stewart.json --json\n"
        "  linkwright robot workspace examples/3-rrr.json --plot edge.svg         planar robots, too\n"
        "  linkwright robot budget examples/space/delta-clearance.json --gear-play 0.02 --tool-force 0,0,-50   error of the tool\n"
        "  linkwright robot map examples/space/delta.json --tool-at 0,0,-0.65 --joint-gap 50e-6 --errors --plot error.svg\n",
    .about =
        "MODEL is a planar or a spatial model (docs/notation.md). Its drives are \"drives\", or its inputs, and leave no freedom; its\n"
        "tool is a tracer. A robot with six drives or more, in the plane three, keeps the tool's orientation when it moves; so does\n"
        "one with four or five whose drives can shift the tool in all directions and turn it besides (SCARA). The level plane is\n"
        "across gravity, or across z without gravity; of a planar robot it is the plane of its motion.\n",
    .options = options,
    .settings_size = sizeof(settings),
    .actions = actions
};
