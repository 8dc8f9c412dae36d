/* cli/robot/robot.c - the robot in the posture that the options ask for, and straight ways from there. */
#include "cli/robot/robot.h"

#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "cli/program/model.h"

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

lw_status cli_robot_read_numbers(const cli_robot *j, const char *option, const char *unit, const char *text, lw_vec3 *p, lw_error *e)
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
static lw_status move_drives(cli_robot *j, lw_error *e)
{
    double v[LW_ROBOT_DRIVES];
    if (!read_list(j->s->drives, j->r.n_drive, v))
        return lw_error_set(e, LW_E_ARG, "--drives-at takes %d number%s, one for each drive, not '%.60s'", j->r.n_drive, lw_plural(j->r.n_drive), j->s->drives);
    for (int i = 0; i < j->r.n_drive; i++)
        v[i] *= cli_robot_turns(j, i) ? LW_PI/180 : j->metre;
    return lw_robot_drive(&j->r, v, e);
}

/* --tool-at and --tool-turn: inverse kinematics. */
static lw_status move_tool(cli_robot *j, lw_error *e)
{
    lw_robot_pose p;
    lw_vec3 place, turn;
    double angle;
    lw_status st = lw_robot_measure(&j->r, &p, e);
    if (st != LW_OK)
        return st;
    place = lw_v3_scale(p.place, 1/j->metre);
    if (j->s->at && (st = cli_robot_read_numbers(j, "--tool-at", j->unit, j->s->at, &place, e)) != LW_OK)
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
    else if ((st = cli_robot_read_numbers(j, "--tool-turn", "deg", j->s->turn, &turn, e)) != LW_OK)
        return st;
    lw_quaternion to = lw_quaternion_times(lw_quaternion_of_vector(lw_v3_scale(turn, LW_PI/180)), j->drawn);
    return lw_robot_move(&j->r, place, &to, e);
}

/* The reach of directions is that about the centre of a spherical wrist, where the tool's point lies beside it. */
static lw_status take_centre(cli_robot *j)
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

int cli_robot_begin(const cli_call *call, cli_robot *j)
{
    struct lw_model *planar = NULL;
    *j = (cli_robot){ .call = call, .s = call->settings };
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

void cli_robot_end(cli_robot *j)
{
    lw_robot_free(&j->r);
    lw_space_adjusted_free(&j->adjusted);
    cli_free_spatial(j->given);
    free(j->q);
}

lw_vec3 cli_robot_direction(const cli_robot *j, double angle)
{
    return lw_v3_add(lw_v3_scale(j->right, cos(angle)), lw_v3_scale(j->ahead, sin(angle)));
}

/* Can the drives not move the tool?  It counts as moved if it goes farther than 1e-5 of the robot's size: on a sphere of this size it seems to
 * follow its tangent so far, within the accuracy of a way.  From a singular posture the
 * drives move it in some directions only, unless the tool's own place is the input. */
bool cli_robot_gets_nowhere(const cli_robot *j, const lw_robot_pose *p, double far)
{
    return far < 1e-5*j->r.space.unit || (isinf(p->condition) && !j->r.by_tool.memory);
}

int cli_robot_cannot_move(cli_robot *j, const lw_robot_pose *p)
{
    char exceeded[80];
    snprintf(exceeded, sizeof exceeded, ": the condition number %.6g there exceeds --max-condition", p->condition);
    lw_error_set(&j->e, LW_OPEN, "the drives cannot move the tool from (%.9g, %.9g, %.9g) %s in the level plane%s; begin from "
                 "another posture", p->place.x/j->metre + 0.0, p->place.y/j->metre + 0.0, p->place.z/j->metre + 0.0, j->unit,
                 j->r.condition_limit > 0 && p->condition > j->r.condition_limit ? exceeded : j->r.only_turns ? ": they only turn it"
                 : j->r.rank == 2 && lw_v3_norm(j->r.normal) == 0 ? ": it moves on a surface that is not level"
                 : isinf(p->condition) ? ": the posture is singular, or the robot lacks this freedom (robot jacobian shows where the tool can go)" : "");
    return cli_fail(j->call, &j->e);
}

int cli_robot_begin_ways(const cli_call *call, cli_robot *j, lw_robot_pose *p, size_t more)
{
    int code = cli_robot_begin(call, j);
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

void cli_robot_go_back(cli_robot *j)
{
    memcpy(j->r.follow.q, j->q, (size_t)j->r.space.n_q*sizeof *j->q);
    memcpy(j->r.follow.z.near, j->near, (size_t)j->r.follow.z.n_near*sizeof *j->near);
}

lw_status cli_robot_follow_ray(cli_robot *j, double angle, double *far)
{
    cli_robot_go_back(j);
    return lw_robot_reach(&j->r, cli_robot_direction(j, angle), 4*j->r.space.unit, far, &j->e);
}

void cli_robot_print_direction(FILE *f, lw_vec3 a)
{
    fprintf(f, "(%.6f, %.6f, %.6f)", cli_robot_clean(a.x, 1e6), cli_robot_clean(a.y, 1e6), cli_robot_clean(a.z, 1e6));
}
