/* grammar/model_internal.h - memory of a model, for its reader; internal to grammar/. */
#ifndef LW_GRAMMAR_MODEL_INTERNAL_H
#define LW_GRAMMAR_MODEL_INTERNAL_H

#include "grammar/model.h"
#include "grammar/read_internal.h"

/* Zeroed arrays for the links, joints and inputs of m->linkage.  After LW_E_MEMORY too, m needs lw_model_free. */
lw_status lw_model_reserve(lw_model *m);

/* ---- shared by the files that read models --------------------------------------------------------------- */

/* The variables that an expression may use: t; those of the whole model; of a spring's or a joint's law. */
typedef enum { LW_OF_TIME, LW_OF_STATE, LW_OF_LENGTH, LW_OF_DISPLACEMENT } lw_expression_scope;

/* An optional expression or number; *out keeps NULL if it is left out. */
lw_status lw_model_read_expression(const lw_json_node *object, const char *key, lw_model *m, lw_expression_scope scope,
                                   lw_expression **out, lw_error *e);

/* The profile of a name; context: the model.  NULL: none. */
const struct lw_moves *lw_model_find_profile(void *context, const char *name);

/* The joint of a load: a pin or a slider. */
lw_status lw_model_read_load_joint(const lw_json_node *object, const char *what, lw_model *m, int *joint, lw_error *e);

/* "links" and "at" of a spring between two points. */
lw_status lw_model_read_ends(const lw_json_node *object, lw_model *m, lw_spring *p, lw_error *e);

/* A word of a text that the program writes: an expression to insert, or (expression NULL) a variable. */
typedef struct lw_generated { const char *word; const lw_expression *expression; int variable; } lw_generated;
lw_status lw_model_generate(const char *text, const lw_generated *word, int n, lw_expression **out, lw_error *e);

/* ---- model_elastic.c ------------------------------------------------------------------------------------- */

/* Joints need a place on an elastic link; guides and gears need a rigid one. */
lw_status lw_model_check_elastic(const lw_json_node *root, const lw_model *m, lw_error *e);

/* ---- model_states.c: what has first-order states --------------------------------------------------------- */

/* A new state; its number, -1: out of memory. */
int lw_model_add_state(lw_model *m, const char *name, const char *unit, double scale);

/* Names of the states of the lists "states", "motors", "cylinders", which expressions may use. */
lw_status lw_model_name_states(const lw_json_node *root, lw_model *m, lw_error *e);

/* Controllers and the ends of cylinders, which other expressions name; later, the equations of states. */
lw_status lw_model_read_controllers(const lw_json_node *root, lw_model *m, lw_error *e);
lw_status lw_model_read_cylinder_ends(const lw_json_node *root, lw_model *m, lw_error *e);
lw_status lw_model_read_states(const lw_json_node *root, lw_model *m, lw_error *e);

/* One of "motors" with a "resistance", or with a "torque"; or false: it has neither. */
bool lw_model_is_driven_motor(const lw_json_node *object);
lw_status lw_model_read_driven_motor(const lw_json_node *object, size_t index, lw_model *m, lw_error *e);

/* ---- model_contact.c: what can touch ---------------------------------------------------------------------- */

/* The "shapes" of all links; then one of "contacts", which needs them, and one of "ropes". */
lw_status lw_model_read_shapes(const lw_json_node *root, lw_model *m, lw_error *e);
lw_status lw_model_read_contact(const lw_json_node *object, size_t index, lw_model *m, lw_error *e);
lw_status lw_model_read_rope(const lw_json_node *object, size_t index, lw_model *m, lw_error *e);

#endif
