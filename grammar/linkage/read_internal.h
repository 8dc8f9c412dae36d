/* grammar/linkage/read_internal.h - parts shared by the readers of linkages and of models.  All functions return
 * LW_E_NOTATION with line and column when the text is not as described. */
#ifndef LW_GRAMMAR_LINKAGE_READ_INTERNAL_H
#define LW_GRAMMAR_LINKAGE_READ_INTERNAL_H

#include "grammar/linkage/assembly.h"
#include "grammar/text/json_internal.h"

#define COUNT(a) ((int)(sizeof (a)/sizeof *(a)))

/* A required member. */
lw_status lw_read_need(const lw_json_node *object, const char *key, lw_json_node *out, lw_error *e);

/* A list of `least` to `most` elements; SIZE_MAX: as many as memory holds. */
lw_status lw_read_list(const lw_json_node *n, size_t least, size_t most, lw_error *e);

/* The file that a required member names, NAME + ending (".mtx"), beside the file of the JSON text.  path (LW_PATH_SIZE) is where it
 * is; what: "a file of the Matrix Market".  *text is to be freed. */
lw_status lw_read_beside(const lw_json_node *object, const char *key, const char *ending, const char *what, char *path, char **text,
                         size_t *size, lw_json_node *at, lw_error *e);

/* [x, y] times unit, within LW_COORDINATE_MAX. */
lw_status lw_read_pair(const lw_json_node *n, double unit, lw_vec2 *out, lw_error *e);

/* [x, y, z] times unit, within LW_COORDINATE_MAX. */
lw_status lw_read_triple(const lw_json_node *n, double unit, lw_vec3 *out, lw_error *e);

/* [x, y, z], as a unit vector. */
lw_status lw_read_direction(const lw_json_node *n, lw_vec3 *out, lw_error *e);

/* An optional number, times unit. */
lw_status lw_read_optional(const lw_json_node *object, const char *key, double unit, double *out, bool *given, lw_error *e);

/* An optional number of an object, times `unit`, in least .. most; *out is unchanged if it is left out. */
typedef struct lw_number_key { const char *key; double unit, least, most, *out; bool *given; } lw_number_key;

#define LW_POSITIVE 1e-300, INFINITY
#define LW_NOT_NEGATIVE 0, INFINITY
#define LW_ANY -INFINITY, INFINITY

lw_status lw_read_numbers(const lw_json_node *object, const lw_number_key *want, int n, lw_error *e);

/* Place of a name among n names of LW_NAME_SIZE bytes, `stride` apart; -1: it is not there.  With json, names of a long list
 * are hashed: between calls the list may grow at its end, but it must not move or change.  NULL: they are compared one by one. */
int lw_read_find(lw_json *json, const char *name, const char *first, size_t stride, int n);

/* lw_read_find, and why it is -1: there is no "joint" of the name; did you mean ...?  why: LW_WHY_SIZE bytes. */
#define LW_WHY_SIZE 128                  /* of grammar/functions/expression.h */
int lw_read_find_or_say(lw_json *json, const char *what, const char *name, const char *first, size_t stride, int n, char *why);

/* The name of an object, or "spring 2" when it has none; what: "spring", index: from 0. */
lw_status lw_read_own_name(const lw_json_node *object, const char *what, size_t index, char name[LW_NAME_SIZE], lw_error *e);

/* The names in these lists of a root differ, in one list and between them: {"springs", "dampers"}.  Names that are left out are
 * those of lw_read_own_name. */
lw_status lw_read_names_differ(const lw_json_node *root, const char *const *keys, int n_key, lw_error *e);

/* Index of the name that a node contains; an error with a suggestion when the name is unknown. */
lw_status lw_read_look_up(const lw_json_node *n, const char *what, const char *const *names, int n_name, int *out, lw_error *e);
/* The same of an array of names `stride` bytes apart. */
lw_status lw_read_name_of(const lw_json_node *n, const char *what, const char *first, size_t stride, int n_name, int *out, lw_error *e);
lw_status lw_read_link(const lw_json_node *n, const lw_assembly *assembly, int *out, lw_error *e);
lw_status lw_read_joint(const lw_json_node *n, const lw_assembly *assembly, int *out, lw_error *e);

/* "linkwright": 1 of a root. */
lw_status lw_read_version(const lw_json_node *root, lw_error *e);

/* "units" of a root; u keeps its values where nothing is given. */
lw_status lw_read_units(const lw_json_node *root, lw_units *u, lw_error *e);

/* Find the linkage in a JSON text: the root itself, or the "linkage" of result number `which` (from 1) if the root has
 * a list of "results"; which 0 is the first result.  The last of place is the linkage; it points to those before.
 * LW_E_ARG: there is no such result, or which > 0 in a text without results. */
lw_status lw_read_result(lw_json *json, int which, lw_json_node place[4], lw_error *e);

/* An assembly from its JSON object; members of a model are skipped.  k needs lw_assembly_free also after a
 * failure. */
lw_status lw_assembly_read_root(const lw_json_node *root, lw_assembly *assembly, lw_error *e);

#endif
