/* linkwright robot - a model in space as a robot: Jacobian, workspace, maps of the condition number and of the lowest
 * eigenfrequency. */
#include "cli/robot/robot.h"

#include <stddef.h>
#include "cli/program/json.h"

#define PLACE(member) offsetof(cli_robot_settings, member)

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

/* ---- jacobian -------------------------------------------------------------------------------------------- */

static void json_pose(const cli_robot *j, FILE *f, const lw_robot_pose *p)
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
        lw_spatial_measure_name(j->m, cli_robot_drive_of(j, i), name, sizeof name);
        cli_json_object(&w, NULL);
        cli_json_text(&w, "name", name);
        cli_json_real(&w, "value", p->drive[i]);
        cli_json_text(&w, "unit", cli_robot_turns(j, i) ? "rad" : "m");
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
static void print_pose(const cli_robot *j, FILE *f, const lw_robot_pose *p)
{
    static const char *const row[] = { "vx", "vy", "vz", "wx", "wy", "wz" };
    char name[80];
    double size = j->r.space.unit;
    fprintf(f, "tool '%s' at (%.9g, %.9g, %.9g) %s\n", j->m->tracer[j->r.tool].name,
            cli_robot_clean(p->place.x, size)/j->metre, cli_robot_clean(p->place.y, size)/j->metre, cli_robot_clean(p->place.z, size)/j->metre, j->unit);
    lw_vec3 turn = lw_v3_scale(lw_quaternion_vector(lw_quaternion_times(p->turn, lw_quaternion_inverse(j->drawn))), 180/LW_PI);
    if (lw_v3_norm(turn) > 1e-9)
        fprintf(f, "turned by (%.9g, %.9g, %.9g) deg from its posture in the file\n", cli_robot_clean(turn.x, 100), cli_robot_clean(turn.y, 100),
                cli_robot_clean(turn.z, 100));
    for (int i = 0; i < j->r.n_drive; i++) {
        lw_spatial_measure_name(j->m, cli_robot_drive_of(j, i), name, sizeof name);
        bool turns = cli_robot_turns(j, i);
        fprintf(f, "drive %-24s %.10g %s\n", name, cli_robot_clean(p->drive[i], turns ? 1 : size)/(turns ? LW_PI/180 : j->metre),
                turns ? "deg" : j->unit);
    }
    fprintf(f, "Jacobian: velocity of the tool [m/s] and its turn [rad/s] by the rates of the drives [rad/s] or [m/s]\n");
    for (int k = 0; k < 6; k++) {
        fprintf(f, "  %s", row[k]);
        for (int i = 0; i < j->r.n_drive; i++)
            fprintf(f, " %15.9g", cli_robot_clean(p->jacobian[k][i], fmax(100*p->singular[0], 1)));
        fputc('\n', f);
    }
    fprintf(f, "singular values%s", j->r.only_turns ? " of the turn, since the tool's point is at rest:" : "");
    for (int i = 0; i < p->rank; i++) {
        fprintf(f, "%s %.9g in ", i ? ";" : "", p->singular[i]);
        cli_robot_print_direction(f, lw_m3_column(&p->axes, i));
    }
    fprintf(f, "\ncondition %.9g, isotropy %.6g, manipulability %.6g\n", p->condition, 1/p->condition, p->manipulability);
    int turning = 0;
    for (int i = 0; i < j->r.n_drive; i++)
        turning += cli_robot_turns(j, i);
    if (turning > 0 && turning < j->r.n_drive)
        fputs("drives turn and slide: singular values and condition depend on the unit of length, here the metre\n", f);
    if (isinf(p->condition)) {
        fprintf(f, j->r.only_turns ? "here the tool cannot turn about" : "here the tool's point cannot move in");
        for (int i = 0, n = 0; i < p->rank; i++)
            if (p->singular[i] <= 0) {
                fprintf(f, n++ ? "; " : " ");
                cli_robot_print_direction(f, lw_m3_column(&p->axes, i));
            }
        fprintf(f, p->freedoms < j->r.freedoms ? ": a singular posture, place and turn of the tool have %d of %d freedoms\n"
                : ": place and turn of the tool together have all %d of %d freedoms, the drives turn it instead\n", p->freedoms, j->r.freedoms);
    }
    if (p->mass[0] > 0) {
        fputs(j->r.only_turns ? "inertia that a moment on the tool turns [kg m^2]" : "mass that a force on the tool moves [kg]", f);
        for (int i = 0; i < p->rank; i++) {
            fprintf(f, "%s %.6g in ", i ? ";" : "", p->mass[i]);
            cli_robot_print_direction(f, lw_m3_column(&p->mass_axes, i));
        }
        fputc('\n', f);
    }
}

static int run_jacobian(const cli_call *call)
{
    cli_robot j;
    lw_robot_pose p;
    lw_output o;
    int code = cli_robot_begin(call, &j);
    if (code == CLI_DONE && (lw_robot_measure(&j.r, &p, &j.e) != LW_OK || cli_open(call, &o, &j.e) != LW_OK))
        code = cli_fail(call, &j.e);
    if (code == CLI_DONE) {
        (call->common.json ? json_pose : print_pose)(&j, o.f, &p);
        code = cli_close(call, &o, CLI_DONE);
    }
    cli_robot_end(&j);
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
      1, 1, cli_robot_budget, CLI_LINKAGE, "text" },
    { "workspace", "MODEL.json",
      "Moves the tool from where it is outwards in the level plane, in each of --rays directions, and prints how far it gets\n"
      "and what stops it: the links, a stop or a cone of a joint, a posture in which the drives lose the tool, or\n"
      "--max-condition. The area is that of the polygon of these ends; its error is estimated by that of every second end. "
      "--volume moves it in all directions of space.\n",
      1, 1, cli_robot_workspace, CLI_LINKAGE, NULL },
    { "reachability", "MODEL.json",
      "Tilts the tool where it is, in each of --rays directions, until something stops it, and prints how far it gets (180 deg: all\n"
      "round). The reachability index is the share of all directions that its axis reaches, z of the tool's \"frame\"; of a\n"
      "robot in a plane, the share of all angles. An index of 1 means that the place is in the dexterous workspace.\n",
      1, 1, cli_robot_reachability, CLI_LINKAGE, NULL },
    { "map", "MODEL.json",
      "Prints condition number, singular values and manipulability over a grid in the level plane of the tool, at the places\n"
      "that it reaches on a straight way. --eigenfrequency adds the lowest eigenfrequency of its elastic links while the drives are\n"
      "held, without gravity and loads.\n",
      1, 1, cli_robot_map, CLI_LINKAGE, NULL },
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
    .settings_size = sizeof(cli_robot_settings),
    .actions = actions
};
