/* cli/program/model.h - read linkages, models, targets and task files of the user. */
#ifndef CLI_PROGRAM_MODEL_H
#define CLI_PROGRAM_MODEL_H

#include "grammar/linkage/assembly.h"
#include "optimise/task/read_file.h"

/* Read a linkage with its motions, masses and loads (grammar/model/model.h) from a file ("-" is standard input). The file holds
 * one linkage as in docs/notation.md, or an object with `results` as `linkwright fit --json` prints it; result number `which`
 * (1 is the best) is taken. which 0: the first result; files without results are accepted too. Free it with cli_free_model.
 * NULL: see e. */
struct lw_model;
struct lw_model *cli_read_model(const char *path, int which, lw_error *e);
void             cli_free_model(struct lw_model *m);               /* NULL is fine */

/* The same of a planar or a spatial model (grammar/model/spatial.h): one of *planar and *spatial is set.  A planar file costs no
 * more than with cli_read_model.  spatial NULL: a spatial model is an error. */
struct lw_spatial;
lw_status cli_read_any_model(const char *path, int which, struct lw_model **planar, struct lw_spatial **spatial, lw_error *e);
lw_status cli_any_model_text(const char *text, size_t size, const char *path, int which, struct lw_model **planar,
                             struct lw_spatial **spatial, lw_error *e);
void      cli_free_spatial(struct lw_spatial *m);                  /* NULL is fine */

/* The linkage alone, from text in memory. LW_E_ARG: it has no result `which`. */
lw_status cli_linkage_text(const char *path, int which, const char *text, size_t size, lw_linkage *linkage, lw_error *e);

/* A planar linkage of any size, or a spatial model, from text in memory. */
lw_status cli_any_linkage_text(const char *path, int which, const char *text, size_t size, lw_assembly *linkage,
                               struct lw_spatial **spatial, lw_error *e);

/* Read CSV, or the curve of a drawing if the name ends in .svg or .dxf. */
lw_status cli_read_target(const char *path, const lw_target_options *o, lw_target *t, lw_error *e);

/* Read a task file and its target: its own stations, or the CSV file named in it, relative to its folder; with its
 * dwells. */
lw_status cli_read_task_file(const char *path, const lw_target_options *o, lw_task_file *b, lw_target *t, lw_error *e);

/* Read a speed: a number in the command's own unit (`plain`, in rad/s or m/s), or one with a unit: "60 rpm", "360deg/s",
 * "0.5 m/s". slides: the input is a slider. LW_E_ARG with a text that lists the units. */
lw_status cli_speed(const char *text, bool slides, double plain, double *speed, lw_error *e);

#endif
