/* linkwright fit - find linkages that move as the target asks. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "cli/fit/fit_settings.h"
#include "cli/program/model.h"
#include "cli/program/mpi_jobs.h"
#include "cli/program/progress.h"
#include "optimise/task/target_tour.h"

static const cli_option options[] = {
    { "type", 0, CLI_TEXT, offsetof(cli_fit_settings, type), "NAME,...", "fourbar",
      "types of four-link mechanism to try: fourbar, slidercrank, inverted, ..., or the letters of their joints such "
      "as RRRP (R pin, P slider); 'all' tries every type. Without it and --links, of a straight path with input angles "
      "slidercrank, too", 0, 0, NULL, NULL },
    { "links", 'l', CLI_INT, offsetof(cli_fit_settings, links), "P", NULL,
      "try all mechanisms with up to P links: 4, 6 or 8. With --joints p or g, odd numbers are possible too; "
      "with --dof 2, numbers from 5. Without it 4; and 6 "
      "if the first row of the four-bars whose crank turns fully counts as missing the target by more than 2.5 % (above; 1 % of up to 15 points), or "
      "leaves it by more than --tolerance. These have at least 3e4 evaluations (3e5 with more than 15 points, unless the first row then counts as 1 % or "
      "less), and more as long as the first row gets better or counts as more than 5 %, at most --budget. If a rocking "
      "four-bar counts as 2.5 % or less, only cranks are searched, and if a body on one pin does the task, no six links", 4, 10,
      NULL, NULL },
    { "dof", 'd', CLI_INT, offsetof(cli_fit_settings, dof), "F", "1",
      "degree of freedom, 1 to 3: the number of driven joints at the ground. 2 gives mechanisms of 5, 7 and 9 links, 3 "
      "of 8 links. The other inputs turn with the first in a fixed ratio (--input-ratios) and at an angle that is "
      "found", 0, 99, NULL, NULL },
    { "input-ratios", 0, CLI_TEXT, offsetof(cli_fit_settings, input_ratios), "R,...", LW_DEFAULT_INPUT_RATIOS,
      "with --dof 2 or 3: ratios of the speeds of two inputs, each tried both ways. Two motors, a belt, or gear wheels "
      "on the frame give such ratios", 0, 0, NULL, NULL },
    { "joints", 0, CLI_TEXT, offsetof(cli_fit_settings, joints), "KINDS", "r",
      "kinds of joints in mechanisms with more than four links: r pins, t sliders, p pins in slots, g gear pairs (with "
      "t also racks)", 0, 0, NULL, NULL },
    { "gear-ratios", 0, CLI_TEXT, offsetof(cli_fit_settings, gear_ratios), "R,...", LW_DEFAULT_GEAR_RATIOS,
      "with --joints g: ratios of the gear pairs, < 0 for external gears. A ratio is the turns of the later link "
      "divided by those of the earlier, seen from the link that carries both", 0, 0, NULL, NULL },
    { "topology", 0, CLI_TEXT, offsetof(cli_fit_settings, topology), "NAME,...", "all",
      "with more than four links, try only these: watt1, watt2, stephenson1 to stephenson3, watt, stephenson, or a "
      "chain by its number of links and its own number, as 8.5; with slots or gears by number of links, number of such "
      "joints and its own number, as 5.1.3", 0, 0, NULL, NULL },
    { "budget", 0, CLI_REAL, offsetof(cli_fit_settings, budget), "N", "1e6",
      "number of evaluations of the objective, for each number of links above four, whose input turns fully; if it need not, half as many "
      "again for other linkages. Four links always have their whole search. With default limits a larger budget, from 1e4 on, does all that a "
      "smaller one does. The "
      "same number again is for fits at other sizes and transmission angles, for mechanisms with sliders, and for those with slots or "
      "gears. With --time and without --budget the search goes on until the time ends; the exit code is 0 if it had the default", 1e3, 1e12, NULL, NULL },
    { "start-from", 0, CLI_INPUT, offsetof(cli_fit_settings, resume), "FILE", NULL,
      "also start from the linkages in this file: results that an earlier fit or 'catalogue nearest' wrote with -o or --json, "
      "or a linkage of your own", 0, 0, NULL, NULL },
    { "task", 0, CLI_CHOICE, offsetof(cli_fit_settings, task), "auto" LW_TASK_WORDS, "auto",
      "what is wanted: a point on a path, a function (output angle for each input angle), or a motion (point and angle "
      "of a body). auto: function without columns x and y, motion with a column theta, else path", 0, 0, NULL, NULL },
    { "timing", 0, CLI_CHOICE, offsetof(cli_fit_settings, timing), "auto" LW_TIMING_WORDS, "auto",
      "prescribed: each point belongs to the input angle in the target; free: only the order of the points counts; "
      "none: only the shape of the path counts, and points that jump to and fro are put in order. auto: prescribed if the target has input angles, else free",
      0, 0, NULL, NULL },
    { "angle-from", 0, CLI_CHOICE, offsetof(cli_fit_settings, datum), "first|frame|plane", "first",
      "zero of the prescribed input angles: at the first point, where the angle itself is found; the line through the "
      "fixed pivots; or the x axis", 0, 0, NULL, NULL },
    { "point-links", 0, CLI_TEXT, offsetof(cli_fit_settings, point_links), "LINK,...", "any",
      "links that carry the further points of the target (x2, ...), in their order: input, coupler, output, or any",
      0, 0, NULL, NULL },
    { "weight-path", 0, CLI_REAL, offsetof(cli_fit_settings, weight_path), "A", "1",
      "weight A of squared distances [1/unit^2]", 0, 1e300, NULL, NULL },
    { "weight-angle", 0, CLI_REAL, offsetof(cli_fit_settings, weight_angle), "B", NULL,
      "weight B of squared angles [1/rad^2]; without it by --angle-length, and 1 for a function", 0, 1e300, NULL, NULL },
    { "angle-length", 0, CLI_REAL, offsetof(cli_fit_settings, angle_length), "L", NULL,
      "an angle error of 1 rad counts as much as a distance of L; without it half the diagonal of the target", 0, 1e300,
      NULL, NULL },
    { "length-range", 0, CLI_RANGE, offsetof(cli_fit_settings, length_range), "MIN:MAX", NULL,
      "limits of the lengths between pins of a link; the tracer is at most MAX from them. Without it r1, r2, ... are 1/1000 "
      "to --max-size times the diagonal of the target", 0, 1e300, NULL, NULL },
    { "position-range", 0, CLI_RANGE, offsetof(cli_fit_settings, position_range), "MIN:MAX", NULL,
      "limits of coordinates and offsets; without it --max-size diagonals around the target", 0, 0, NULL, NULL },
    { "max-size", 0, CLI_REAL, offsetof(cli_fit_settings, max_size), "S", "6",
      "without the two ranges above: most length and coordinate, in diagonals of the target", 0.1, 1e9, NULL, NULL },
    { "length-ratio", 0, CLI_REAL, offsetof(cli_fit_settings, length_ratio), "R", "20",
      "the longest length, or arm of a point, is at most R times the shortest length", 1, 1e9, NULL, NULL },
    { "bounds", 0, CLI_TEXT, offsetof(cli_fit_settings, bounds), "NAME=MIN:MAX,...", NULL,
      "limits of single dimensions, as r1=5:50,x0=0:0; angles in radians", 0, 0, NULL, NULL },
    { "crank-only", 0, CLI_FLAG, offsetof(cli_fit_settings, crank_only), NULL, NULL,
      "the input turns fully, and in a four-bar it is the shortest link", 0, 0, NULL, NULL },
    { "full-turn", 0, CLI_FLAG, offsetof(cli_fit_settings, full_turn), NULL, NULL,
      "the input turns fully; double cranks (drag links) are allowed too", 0, 0, NULL, "crank-only" },
    { "min-transmission-angle", 0, CLI_REAL, offsetof(cli_fit_settings, min_transmission), "DEG", "20",
      "smallest transmission angle allowed during the motion [degrees]. The default gives way if no linkage has it",
      0, 89.9, NULL, NULL },
    { "class-margin", 0, CLI_REAL, offsetof(cli_fit_settings, class_margin), "M", "0.001",
      "least distance of a four-bar from a change point, in perimeters; the default only where its motion comes near "
      "the flat posture", 0, 0.5, NULL, NULL },
    { "through-limits", 0, CLI_FLAG, offsetof(cli_fit_settings, through_limits), NULL, NULL,
      "the input may pass its limits, where it turns back, and rock on a closed target; between its points the "
      "curve may stray", 0, 0, NULL, NULL },
    { "tolerance", 0, CLI_TEXT, offsetof(cli_fit_settings, tolerance), "E", NULL,
      "list the simplest linkages, then the smallest, that stray from the target by E at most, as 1mm; without a "
      "unit in that of the target. A linkage whose lengths differ by more than a factor of 8 counts as larger", 0, 0, NULL, NULL },
    { "unlimited", 0, CLI_FLAG, offsetof(cli_fit_settings, unlimited), NULL, NULL,
      "no limit holds by default: sizes up to 10 diagonals, any ratio of lengths, any transmission angle, change "
      "points, --through-limits; results are listed by their error alone, but those that leave a target of 32 points or "
      "more between its points come last", 0, 0, NULL, NULL },
    { "max-acceleration", 0, CLI_REAL, offsetof(cli_fit_settings, max_acceleration), "A", NULL,
      "greatest acceleration of the point allowed, with respect to the input [unit/rad^2]; with --task function, of "
      "the output angle", 0, 1e300, NULL, NULL },
    { "tolerances", 0, CLI_TEXT, offsetof(cli_fit_settings, tolerances), "T[,C]", NULL,
      "say how far the path of each result spreads when every length varies by +-T (three standard deviations) and pins "
      "have a radial clearance of C; with a unit, as 0.1mm, or in that of the target. The first row then weighs how far from "
      "the target 95 of 100 such linkages stay, and the row with the least spread is kept", 0, 0, NULL, NULL },
    { "exact", 0, CLI_FLAG, offsetof(cli_fit_settings, exact), NULL, NULL,
      "find linkages that pass through every precision point exactly: 2 to 5 poses, 3 to 5 pairs of a function, or 2 "
      "to 9 points. Linkages that can run through all points in order, without being taken apart, come first",
      0, 0, NULL, "links" },
    { "solver", 0, CLI_TEXT, offsetof(cli_fit_settings, solver), "NAME", "lm",
      "local solver that improves each start; 'linkwright fit --solver help' lists them", 0, 0, NULL, NULL },
    { "starts", 0, CLI_INT, offsetof(cli_fit_settings, starts), "N", "0",
      "number of starting points in each round, for each type and assembly mode; 0 lets the size of the problem decide",
      0, 3200, NULL, NULL },
    { "rounds", 0, CLI_INT, offsetof(cli_fit_settings, rounds), "N", "0",
      "greatest number of rounds; 0 lets the size of the problem decide", 0, 100000, NULL, NULL },
    { "results", 0, CLI_INT, offsetof(cli_fit_settings, results), "N", "10", "greatest number of results", 1, 64, NULL, NULL },
    { "save", 0, CLI_TEXT, offsetof(cli_fit_settings, save), "FOLDER", NULL,
      "write linkages (JSON), pictures (SVG, PNG), an animation (GIF), the wanted and reached curves and one index.html into this "
      "folder",
      0, 0, NULL, NULL },
    { "plot", 'p', CLI_PLOT, offsetof(cli_fit_settings, plot), "FILE", NULL,
      "draw what is wanted and what the best seven results reach: of a function output over input, else the paths (.svg, .pdf, "
      ".png); the table is then not printed", 0, 0, NULL, NULL },
    { "closed", 0, CLI_FLAG, offsetof(cli_fit_settings, closed), NULL, NULL,
      "the target is a closed curve, whatever its file says", 0, 0, NULL, NULL },
    { "open", 0, CLI_FLAG, offsetof(cli_fit_settings, open), NULL, NULL,
      "the target is an open curve, whatever its file says", 0, 0, NULL, "closed" },
    { "smooth", 0, CLI_TEXT, offsetof(cli_fit_settings, smooth), "DISTANCE|auto", NULL,
      "smooth the points of a noisy path: use the smoothest curve that none of them leaves by more than this distance, in "
      "the length unit of the target; auto: by as much as their noise, which is estimated. How far the curve lies from "
      "them is printed", 0, 0, NULL, NULL },
    { "stations", 0, CLI_TEXT, offsetof(cli_fit_settings, stations), "N|drawn", NULL,
      "spread N stations over the path by length and curvature, with the corners among them; 'drawn' takes the points of "
      "a drawing as they are. Without it: the rows of a table, 60 stations on each curve of a drawing",
      0, 0, NULL, NULL },
    { "length-unit", 0, CLI_TEXT, offsetof(cli_fit_settings, length_unit), "UNIT", NULL,
      "unit of the lengths in the target: m, mm, cm, in, ...; without it as the file says, else m", 0, 0, NULL, NULL },
    { "angle-unit", 0, CLI_TEXT, offsetof(cli_fit_settings, angle_unit), "rad|deg|turn", NULL,
      "unit of the angles in the target; without it as the file says, else rad", 0, 0, NULL, NULL },
    { "keep", 0, CLI_INPUT, offsetof(cli_fit_settings, keep), "FILE", NULL,
      "keep the work of each round in FILE; after an interruption the same command goes on from there", 0, 0, NULL, "exact" },
    { "mpi", 0, CLI_FLAG, offsetof(cli_fit_settings, mpi), NULL, NULL,
      "share the work of each round among all processes that mpirun started; process 0 prints", 0, 0, NULL, "exact" },
    { .name = NULL }
};

/* ---- one target --------------------------------------------------------------------------------- */

typedef struct shown {
    const cli_call *call;
    cli_progress    line;
    const char     *path;
    double          best;
    int             links, part;            /* of the search in stages; 0: another                      */
    bool            goes_on;                /* to six links, where no four-bar is near                  */
    bool            turns;                  /* rows are preferred for a crank that turns                */
} shown;

/* How many parts a search has is not known before its end, so the percents of a part do not give the time that is left. */
static void show(void *context, double done, double seconds, double best)
{
    shown *s = context;
    char note[128], found[64] = "";
    (void)seconds;
    s->best = fmin(s->best, best);
    if (isfinite(s->best))
        snprintf(found, sizeof found, "best objective %.6g", s->best);
    if (s->links == 0) {
        cli_progress_show(&s->line, 100*done, 100, *found ? found : NULL);
        return;
    }
    snprintf(note, sizeof note, "%d links, part %d: %.0f %%%s%s", s->links, s->part, 100*done, *found ? ", " : "", found);
    cli_progress_tell(&s->line, note);
}

static void begun(void *context, int links)
{
    shown *s = context;
    if (s->goes_on && links > 4 && s->links == 4) {
        cli_progress_end(&s->line);
        cli_note(s->call, "%s: no four-bar found%s is near enough and small enough, "
                 "so six links are searched, too, which takes longer; "
                 "'--links 4' leaves them out", s->path, s->turns ? " whose crank turns" : "");
        s->goes_on = false;
    }
    s->links = links;
    s->part++;
}

/* A number from the command line, or else from the task file. */
static int said(const cli_call *call, const char *option, int here, int in_task)
{
    return in_task > 0 && !cli_given(&call->parsed, option) ? in_task : here;
}

/* Can mechanisms with this degree of freedom be searched, given the other options? links 0: not given. */
static lw_status check_dof(const cli_call *call, int dof, int links, lw_error *e)
{
    const cli_fit_settings *s = call->settings;
    const cli_parsed *said = &call->parsed;
    if (dof == 0)
        return lw_error_set(e, LW_E_ARG, "--dof 0: a linkage without freedom is a truss, no point of which moves");
    if (dof > LW_PACKED_INPUT_MAX)
        return lw_error_set(e, LW_E_ARG, "--dof %d: with %d inputs at the ground a mechanism has %d links or more, and "
                            "--links goes to 10, which is F = %d", dof, dof, lw_mechanism_least_links(dof),
                            LW_PACKED_INPUT_MAX);
    if (dof == 1)
        return cli_given(said, "input-ratios") ? lw_error_set(e, LW_E_ARG, "--input-ratios has a meaning with several "
                                                              "inputs: give --dof 2") : LW_OK;
    if (links > 0 && links < lw_mechanism_least_links(dof))
        return lw_error_set(e, LW_E_ARG, "--dof %d --links %d: with %d inputs at the ground a mechanism has %d links "
                            "or more",
                            dof, links, dof, lw_mechanism_least_links(dof));
    if (cli_given(said, "type") || s->exact)
        return lw_error_set(e, LW_E_ARG, "--dof %d goes together with no --%s, which is about linkages of four links "
                            "and F = 1", dof, s->exact ? "exact" : "type");
    return LW_OK;
}

/* Choose the mechanisms that are searched for this target, and the linkages from which searches start. */
static lw_status topologies(const cli_call *call, cli_fit_set *set, lw_topology_search_options *o, lw_error *e)
{
    const cli_fit_settings *s = call->settings;
    const lw_task_file *b = &set->task_file;
    bool counted = b->links > 0 || cli_given(&call->parsed, "links");
    o->links = counted ? said(call, "links", s->links, b->links) : 0;
    o->more = !counted && !cli_given(&call->parsed, "type");
    o->freedoms = said(call, "dof", s->dof, b->dof);
    o->joints = b->joints[0] && !cli_given(&call->parsed, "joints") ? b->joints : s->joints;
    o->topologies = b->topology[0] && !cli_given(&call->parsed, "topology") ? b->topology : s->topology;
    o->gear_ratios = s->gear_ratios;
    o->input_ratios = s->input_ratios;
    lw_status st = check_dof(call, o->freedoms, o->links, e);
    if (st == LW_OK && o->links > 0 && (o->links - 1 - o->freedoms)%2 != 0 && !lw_kinds_have_two_freedoms(o->joints))
        cli_note(call, "with pins and sliders a mechanism of F = %d has an %s number of links: up to %d are searched, "
                 "not %d; '--joints r,p,g' gives slots and gear pairs too", o->freedoms,
                 o->freedoms%2 ? "even" : "odd", o->links - 1, o->links);
    if (st == LW_OK && s->resume)
        st = cli_fit_start_read(s->resume, &set->start, e);
    o->n_start = set->start.n;
    o->start = set->start.linkage;
    return st;
}

static lw_status search(const cli_call *call, cli_fit_set *set, cli_side_by_side *together, lw_error *e)
{
    const cli_fit_settings *s = call->settings;
    const lw_sharing sharing = { cli_share_loop, together };
    shown progress = { .call = call, .line = cli_progress_begin(call, "fit", "percent"), .path = set->path, .best = INFINITY,
                       .turns = lw_target_prefers_turns(&set->target) };
    lw_topology_search_options o = lw_topology_search_options_default();
    lw_status st = topologies(call, set, &o, e);
    if (st != LW_OK)
        return st;
    bool all_types = (s->links > 4 || lw_kinds_have_two_freedoms(s->joints)) && strchr(s->joints, 't')
                  && !cli_given(&call->parsed, "type");
    o.fit.spec = set->spec;
    o.fit.types = all_types ? "all" : s->type;
    o.fit.solver = lw_solver_find(s->solver);
    o.fit.seed = set->seed = call->common.seed;
    o.fit.jobs = call->common.jobs;
    o.fit.max_seconds = set->seconds;
    o.fit.starts = s->starts;
    o.fit.max_rounds = s->rounds;
    o.fit.n_result = s->results;
    o.fit.interrupt = s->mpi ? &together->stop : cli_stop_flag();
    o.fit.sharing = s->mpi || s->keep ? &sharing : NULL;
    o.fit.progress = show;
    o.fit.begun = begun;
    o.fit.context = &progress;
    progress.goes_on = o.more;
    o.fit.budget = cli_given(&call->parsed, "budget") || set->seconds <= 0 ? (long)s->budget : 0;
    if (s->exact && !cli_given(&call->parsed, "type"))
        o.fit.types = NULL;                              /* chosen by the target's number of stations */
    st = s->exact ? cli_fit_exact(call, set, &o.fit, e) : lw_topology_search_run(&set->target, &o, &set->search, e);
    if (st < 0 && together->e.status != LW_OK)
        *e = together->e;
    cli_progress_end(&progress.line);
    return st;
}

static bool is_task_file(const char *path)
{
    size_t n = strlen(path);
    return n > 5 && strcmp(path + n - 5, ".json") == 0;
}

/* The targets that a task file names are inputs as well: no output may overwrite them. A fault of the file is reported
 * when it is read for its fit. */
static int check_task_file(const cli_call *call, const char *path)
{
    lw_task_file task;
    char *text = NULL, file[LW_PATH_SIZE];
    size_t size;
    int code = CLI_DONE;
    lw_error e = { 0 };
    lw_status st = lw_file_read(path, &text, &size, &e);
    if (st == LW_OK)
        st = lw_task_file_read(text, size, path, &task, &e);
    if (st == LW_OK) {
        for (int i = -1; i < task.n_also && code == CLI_DONE; i++) {
            const char *name = i < 0 ? task.target : task.also[i].target;
            if (name[0] && lw_task_file_beside(path, name, file, NULL) == LW_OK)
                code = cli_add_input(call, file);
        }
        lw_task_file_free(&task);
    }
    free(text);
    return st == LW_E_MEMORY ? cli_fail(call, &e) : code;
}

/* Read a target, or a task file that contains or names one. */
static lw_status read_input(const char *path, const lw_target_options *o, cli_fit_set *set, lw_error *e)
{
    set->has_task_file = is_task_file(path);
    return set->has_task_file ? cli_read_task_file(path, o, &set->task_file, &set->target, e)
                          : cli_read_target(path, o, &set->target, e);
}

/* Value of --stations: a number, or "drawn". */
static lw_status read_stations(const char *text, int *stations, lw_error *e)
{
    static const cli_option number = { .name = "stations", .kind = CLI_INT, .least = 2, .most = 10000 };
    *stations = text ? -1 : 0;
    return text && strcmp(text, "drawn") != 0 ? cli_value(&number, "stations", text, stations, e) : LW_OK;
}

/* 0: not smoothed; -1: by the noise. */
static lw_status read_smooth(const char *text, double *distance, lw_error *e)
{
    static const cli_option number = { .name = "smooth", .kind = CLI_REAL, .least = 0, .most = 1e300 };
    *distance = text ? -1 : 0;
    return text && strcmp(text, "auto") != 0 ? cli_value(&number, "smooth", text, distance, e) : LW_OK;
}

static lw_status fit_one(const cli_call *call, const char *path, cli_side_by_side *together, cli_fit_set *set, lw_error *e)
{
    const cli_fit_settings *s = call->settings;
    lw_target_options o = { .closed = s->closed ? 1 : s->open ? 0 : -1, .length_unit = s->length_unit,
                            .angle_unit = s->angle_unit };
    set->path = path;
    cli_fit_name(path, set->name, sizeof set->name);
    lw_status st = read_stations(s->stations, &o.stations, e), why;
    if (st == LW_OK)
        st = read_smooth(s->smooth, &o.smooth, e);
    if (st == LW_OK)
        st = read_input(path, &o, set, e);
    if (st == LW_OK && cli_fit_timing(call, set) == LW_TIMING_NONE)
        st = lw_target_put_in_order(&set->target, e);
    if (st == LW_OK && set->target.note[0])
        cli_note(call, "%s: %s", path, set->target.note);
    if (st == LW_OK)
        st = cli_fit_make_spec(call, set, &set->spec, e);
    if (st == LW_OK && (set->has_tolerances = s->tolerances != NULL)) {
        set->spec.tolerances = (lw_tolerances){ .seed = call->common.seed };
        st = cli_fit_read_tolerances(s->tolerances, &set->target.units, &set->spec.tolerances, e);
        if (st == LW_OK && !lw_task_has_place(set->spec.task))
            st = lw_error_set(e, LW_E_ARG, "--tolerances is about the path of a point, and a function has none");
    }
    if (st != LW_OK)
        return st;
    if (!s->exact)
        cli_fit_note_simpler(call, set);
    why = search(call, set, together, e);
    if (why == LW_NOTHING && s->exact)
        lw_error_set(e, why, set->exact.complete
                     ? "no real linkage of these types within these bounds and conditions goes through all stations"
                     : "no real linkage of these types within these bounds and conditions that goes through all stations "
                       "was found, and not all linkages were looked at; give the bounds one value each (x0, y0, r1, "
                       "theta0: five points have finitely many), or wider ones");
    if (why < 0 || why == LW_NOTHING) {
        if (e->file[0] == 0) {
            snprintf(e->file, sizeof e->file, "%s", path);
            e->line = why != LW_NOTHING && set->target.n == 1 ? set->target.line[0] : 0;
        }
        return why;
    }
    if (set->is_exact)
        st = cli_fit_exact_verify(call, set, e);
    else
        cli_fit_notes(call, set);
    return st != LW_OK ? st : cli_fit_may_miss(set) ? LW_STOPPED : why;
}

static void set_free(cli_fit_set *set)
{
    lw_target_free(&set->target);
    lw_task_file_free(&set->task_file);
    lw_topology_search_free(&set->search);
    free(set->start.linkage);
    lw_exact_free(&set->exact);
}

/* ---- all of them ---------------------------------------------------------------------------------- */

static bool wants_json(const cli_call *call)
{
    return call->common.json || call->common.output;
}

static void print(const cli_call *call, const cli_fit_set *set, int n, lw_output *o)
{
    bool table = !cli_given(&call->parsed, "json") && !cli_given(&call->parsed, "plot") && !(call->common.quiet && call->common.output);
    for (int i = 0; i < n && table; i++)
        cli_fit_table(&set[i], stdout);
    for (int i = 0; i < n && wants_json(call); i++)
        cli_fit_json(&set[i], call, o->f, n > 1 ? 0 : 1);
}

static int save(const cli_call *call, const cli_fit_set *set, int n, int code)
{
    const cli_fit_settings *s = call->settings;
    lw_error e = { 0 };
    lw_drawing d;
    if (!s->plot && !s->save)
        return code;
    cli_go_on();
    if (s->plot && set->search.results.n > 0) {
        const lw_fitted f = cli_fitted(set);
        lw_status st = lw_fitted_curves(&f, &d, &e);
        if (st == LW_OK) {
            st = lw_draw_drawing(&d, s->plot, &e);
            lw_drawing_free(&d);
        }
        if (st != LW_OK)
            return cli_fail(call, &e);
    }
    if (!s->save)
        return code;
    lw_status st = LW_OK;
    for (int i = 0; i < n && st == LW_OK; i++)
        st = cli_fit_save(&set[i], s->save, true, &e);
    if (st == LW_OK)
        st = cli_fit_page(set, n, s->save, &e);
    for (int i = 0; i < n && st >= 0; i++)
        st = cli_fit_save(&set[i], s->save, false, &e);
    return st < 0 ? cli_fail(call, &e) : code;
}

static int list_solvers(void)
{
    for (const lw_solver *s = lw_solver_table; s->name; s++)
        printf("%-14s %s\n", s->name, s->source);
    return CLI_DONE;
}

static int check(const cli_call *call)
{
    const cli_fit_settings *s = call->settings;
    lw_error e = { 0 };
    if (!lw_solver_find(s->solver))
        return cli_usage(call, "there is no solver '%s'; '--solver help' lists them", s->solver);
    for (const char *at = s->joints; *at; at++)
        if (!strchr("rtpg,", *at))
            return cli_usage(call, "--joints takes r, or r with t, p and g and commas between, not '%s'", s->joints);
    lw_ratio_list ratios;
    if (lw_ratio_list_read("--gear-ratios", s->gear_ratios, &ratios, &e) != LW_OK
        || lw_ratio_list_read("--input-ratios", s->input_ratios, &ratios, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    bool of_task = cli_given(&call->parsed, "input-ratios") && !cli_given(&call->parsed, "dof");
    if (!of_task && check_dof(call, s->dof, cli_given(&call->parsed, "links") ? s->links : 0, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    if (cli_fit_check_conditions(call, &e) != LW_OK)
        return cli_usage(call, "%s", e.text);
    if (call->parsed.n_word == 0)
        return cli_usage(call, "no target; give a CSV file");
    if (s->plot && call->parsed.n_word > 1)
        return cli_usage(call, "--plot shows a single target; give them one by one, or --save FOLDER");
    int code = CLI_DONE;
    for (int i = 0; i < call->parsed.n_word && code == CLI_DONE; i++)
        if (is_task_file(call->parsed.word[i]))
            code = check_task_file(call, call->parsed.word[i]);
    return s->save && code == CLI_DONE ? cli_fit_check_folder(call, s->save, s->results) : code;
}

/* Fit every target; report those that fail and go on. The targets share --time: each gets an equal part of what the
 * targets before it have left and pictures do not need. Returns the exit code. */
static int fit_targets(const cli_call *call, cli_side_by_side *together, cli_fit_set *set, int *done)
{
    int code = CLI_DONE, n = call->parsed.n_word, i;
    const cli_fit_settings *s = call->settings;
    double pictures = s->save || s->plot ? fmin(0.5, 0.1*call->common.time) : 0;
    double end = lw_clock_wall() + call->common.time - pictures;
    for (i = 0; i < n && !together->stop && (together->mpi || !cli_interrupted()); i++) {
        lw_error e = { 0 };
        cli_fit_set *now = &set[*done];
        now->seconds = call->common.time > 0 ? fmax(1e-3, (end - lw_clock_wall())/(n - i)) : 0;
        lw_status st = fit_one(call, call->parsed.word[i], together, now, &e);
        if (st < 0 || st == LW_NOTHING) {
            code = cli_fail(call, &e);
            if (st == LW_NOTHING && now->search.uncounted_links > 0)      /* the time ended before the search began */
                code = CLI_LIMIT;
            set_free(now);
            memset(now, 0, sizeof *now);
            continue;
        }
        code = st == LW_STOPPED ? CLI_LIMIT : now->search.results.n == 0 ? CLI_NOTHING : code;
        ++*done;
    }
    if (i < n) {
        fprintf(stderr, "linkwright fit: %d of %d targets were not begun; the first of them is %s\n", n - i, n, call->parsed.word[i]);
        code = CLI_LIMIT;
    }
    return code;
}

/* Open the output first: a search must not be lost because a folder cannot be written. */
static int fit_all(const cli_call *call, cli_side_by_side *together)
{
    lw_output o;
    lw_error e = { 0 };
    int done = 0, code;
    cli_fit_set *set = calloc((size_t)call->parsed.n_word, sizeof *set);
    if (!set) {
        lw_error_set(&e, LW_E_MEMORY, "no memory for %d targets", call->parsed.n_word);
        return cli_fail(call, &e);
    }
    if (wants_json(call) && cli_open(call, &o, &e) != LW_OK) {
        free(set);
        return cli_fail(call, &e);
    }
    code = fit_targets(call, together, set, &done);
    cli_hold();
    print(call, set, done, &o);
    if (wants_json(call) && done > 0)
        code = cli_close_marked(call, &o, code);
    else if (wants_json(call))
        lw_output_abandon(&o);
    fflush(stdout);
    if (done > 0)
        code = save(call, set, done, code);
    for (int i = 0; i < done; i++)
        set_free(&set[i]);
    free(set);
    return code;
}

/* A process that is not process 0: the same search, nothing printed or written. */
static int run_as_worker(const cli_call *call, cli_side_by_side *together)
{
    cli_call mine = *call;
    cli_fit_settings silent = *(const cli_fit_settings *)call->settings;
    mine.settings = &silent;
    mine.common.output = NULL;
    mine.common.json = false;
    mine.common.quiet = true;
    silent.save = NULL;
    if (freopen("/dev/null", "w", stdout))
        (void)fit_all(&mine, together);
    return CLI_DONE;
}

static int run(const cli_call *call)
{
    const cli_fit_settings *s = call->settings;
    cli_side_by_side together = { .mpi = s->mpi };
    uint64_t kept_run;
    lw_error e = { 0 };
    int code, rank = 0;
    if (strcmp(s->solver, "help") == 0)
        return list_solvers();
    if ((code = check(call)) != CLI_DONE || (s->mpi && (code = cli_mpi_check(call)) != CLI_DONE))
        return code;
    if ((s->mpi || s->keep) && call->common.time > 0)
        return cli_usage(call, "--time does not go with --mpi and --keep, since the answer must not depend on it; --budget limits "
                         "the work");
    if (s->mpi)
        rank = cli_mpi_begin();
    if (rank == 0 && s->keep
        && (cli_kept_run(call->line, call->parsed.n_word, call->parsed.word, &kept_run, &e) != LW_OK
            || cli_kept_open(s->keep, kept_run, &together.kept, &e) != LW_OK))
        code = cli_fail(call, &e);
    if (s->mpi && !cli_mpi_agree(code == CLI_DONE))
        code = code == CLI_DONE ? CLI_BAD_INPUT : code;
    else if (code == CLI_DONE)
        code = rank == 0 ? fit_all(call, &together) : run_as_worker(call, &together);
    cli_kept_close(together.kept);
    if (s->mpi)
        cli_mpi_end(true);
    return code;
}

const cli_command cli_fit_command = {
    .name = "fit",
    .words = "TARGET ...",
    .title = "find linkages whose point follows a path, or whose output follows a function",
    .examples =
        "  linkwright fit examples/walking-foot.csv                        the best four-bars\n"
        "  linkwright fit examples/ellipse.csv --type all -o found.json    all types with four links\n"
        "  linkwright fit path.csv --crank-only --length-range 5:50        bounded lengths\n"
        "  linkwright fit path.csv --links 5 --joints r,p,g                also slots and gear pairs\n"
        "  linkwright fit path.csv --min-transmission-angle 35 --save out  with pictures\n"
        "  linkwright fit drawing.svg#toe --stations 40                    a curve of a drawing\n"
        "  linkwright fit measured.csv --smooth 0.5                        points with noise\n"
        "  linkwright fit path.csv --links 8 --budget 1e8 --keep path.kept survives interruptions\n"
        "  mpirun -n 64 linkwright fit path.csv --links 8 --budget 1e9 --mpi --keep path.kept\n",
    .about =
        "TARGET is a CSV file. Its columns say what is wanted:\n"
        "    x,y           a point shall follow this path\n"
        "    x,y,theta     a body shall move through these positions and angles\n"
        "    angle,theta   the output shall have angle theta when the input has angle 'angle'\n"
        "A column 'angle' beside x,y gives the input angle of each point, 'weight' its weight. Columns\n"
        "x2,y2[,theta2] are further points of the same mechanism; theta2 alone is the angle of an output beside\n"
        "the path. An SVG or DXF drawing is a target too; of several curves, DRAWING.svg#NAME or #2 is one, and\n"
        "#1,3 or #all are points of one linkage. Instead of a CSV file, TASK.json holds a target with its conditions (docs/notation.md,\n"
        "\"Target\" and \"Task\"). - is standard input.\n"
        "\n"
        "The search looks for dimensions with the smallest sum, over all points, of\n"
        "    A |P - T|^2 + B (alpha - theta)^2       P, alpha: point and angle of the linkage; T, theta: of the "
        "target\n"
        "By default a result is a linkage that can be built:\n"
        "    motion        on a closed target the input turns fully; on an open one it passes no limit of the input\n"
        "    curve         it stays near the target between the points, too\n"
        "    transmission  transmission angles are 20 degrees or more; of an input that rocks, between the ends of an open target\n"
        "    size          lengths, and arms of points, are at most 6 diagonals of the target and 20 times the shortest length\n"
        "    class         a four-bar is 1e-3 perimeters from a change point, where it could move on in another way; one that\n"
        "                  rocks with transmission angles of 20 degrees or more, as a parallelogram may, can be nearer; and\n"
        "                  every pin turns, unlike in a kite that is folded so that two of its pins coincide\n"
        "Every limit is one option; giving one replaces that default only; --unlimited switches all off. The diagonal of the\n"
        "target is that of the smallest rectangle around it.\n"
        "\n"
        "No row is worse than another in all of error, size, transmission angle and number of links, unless its input alone\n"
        "turns fully. They are ordered by the column 'counts as': the error of a four-bar of the target's size, with\n"
        "transmission angles of 45 degrees, that is as good. The best of each number of links stands before the others. The\n"
        "error is the one as made: what the linkage misses the target by, and what 95 of 100 such linkages stray from it if\n"
        "every length varies by +-1/2500 of the target, or by --tolerances. Half this error counts as much as 0.45 of the size\n"
        "(beyond one diagonal of the target; beyond 1.5 as 0.65 of it), 35 degrees of transmission angle (up to 45), or 1.4\n"
        "links. An error below 1/1000 of the longest link or the target, or below what --smooth moved its points by, hardly\n"
        "counts, one above 1/50 of the target more. Of a function the ratio of the longest to the shortest length stands for\n"
        "the size, 4 for a diagonal, and its swing, at least 57 degrees, for the target; lengths vary by +-1/625 of the\n"
        "shortest.\n"
        "If a row stays within 1/10000 of the target (3/10000 between its points; an angle within 0.006 degrees), a larger\n"
        "linkage is not listed for a smaller error, except the one with the smallest. One that leaves the target by more than 5 %\n"
        "is not listed if another one stays within 2 %. --tolerance says instead how much error is as good as none.\n"
        "\n"
        "Every result is simulated a second time by independent code before it is printed. The table of results\n"
        "goes to standard output; with -o FILE the results go to FILE as JSON too, with --json they replace the\n"
        "table. The same seed gives the same results for any number of --jobs.\n",
    .options = options,
    .settings_size = sizeof(cli_fit_settings),
    .least_words = 0,
    .most_words = 1000,
    .run = run,
    .reads = CLI_TARGET | CLI_DRAWING | CLI_TASK | CLI_LINKAGE | CLI_RESULTS,
    .writes = "JSON",
};
