/* grammar/family/master_internal.h - a master file in memory: the tree of its JSON with compiled formulas. */
#ifndef LW_GRAMMAR_FAMILY_MASTER_INTERNAL_H
#define LW_GRAMMAR_FAMILY_MASTER_INTERNAL_H

#include "base/bytes.h"
#include "grammar/family/master.h"
#include "grammar/text/json_internal.h"

#define COUNT(a) ((int)(sizeof (a)/sizeof *(a)))
#define LW_MASTER_NAME 64              /* bytes of a name of a parameter with its terminator */
#define LW_KEY_UNITS    3

/* How the numbers of a key change when the part is turned and moved. */
typedef enum lw_key_geometry { LW_KEY_PLAIN, LW_KEY_POINT, LW_KEY_DIRECTION, LW_KEY_ANGLE, LW_KEY_TENSOR, LW_KEY_FORCE }
    lw_key_geometry;

typedef struct lw_key {
    const char     *parent, *key;      /* parent: key of the object that holds it; NULL: any              */
    lw_key_geometry geometry;
    bool            posture;           /* lengths and angles are in the units of the file                 */
    const char     *units[LW_KEY_UNITS];
} lw_key;

/* NULL: a key that is not known. */
const lw_key *lw_key_find(const char *parent, const char *key);

/* A part of a text: a literal or a formula. */
typedef struct lw_piece { char *text; size_t size, at; lw_formula *formula; } lw_piece;

typedef enum lw_template_kind {
    LW_TEMPLATE_VERBATIM,              /* JSON text that is written as it is                             */
    LW_TEMPLATE_FORMULA,               /* "=..."                                                          */
    LW_TEMPLATE_PIECES,                /* "text {formula} text"                                          */
    LW_TEMPLATE_OBJECT, LW_TEMPLATE_ARRAY,
    LW_TEMPLATE_PORT                   /* {"port": "instance.port"}                                       */
} lw_template_kind;

typedef struct lw_index { int symbol; struct lw_template *values; } lw_index;    /* of a repeat */

typedef struct lw_template {
    lw_json_node     json;             /* its parent chain leads through other templates                  */
    lw_json_kind     type;
    int              n;                /* children                                                        */
    struct lw_template *child;         /* (n)                                                             */
    lw_template_kind kind;
    char            *verbatim;
    double           number;           /* of a verbatim number                                            */
    lw_formula      *formula;
    lw_piece        *piece;
    int              n_piece;
    const lw_key    *key;              /* of the member that it belongs to; NULL: unknown                 */
    int              n_unit;
    lw_amount        unit[LW_KEY_UNITS];
    struct lw_template *when, *repeat;   /* of an object; NULL: none                                      */
    lw_index        *index;            /* (n of repeat)                                                   */
} lw_template;

typedef struct lw_symbol {
    char             name[LW_MASTER_NAME];
    bool             visible, let;
    lw_template     *node;             /* of its value; NULL: view, self, an index                        */
    lw_formula      *formula;          /* NULL: `value` holds                                             */
    lw_amount        value;
    bool             has_unit;
    lw_amount        unit;
    lw_template     *choices;          /* NULL: any                                                       */
    lw_parameter     info;
    int              mark;             /* of the search for circles                                       */
} lw_symbol;

/* The names that formulas of the root or of a part may use. */
typedef struct lw_scope {
    int        n, capacity;
    lw_symbol *symbol;
    int       *order;                  /* (n_order) symbols with a formula, each after those it needs      */
    int        n_order;
} lw_scope;

typedef struct lw_port { lw_template *node, *at, *angle, *axis; } lw_port;

typedef struct lw_use {
    lw_template *node, *name, *at, *angle, *axis, *attach, *to;
    int          part, n_with;
    struct { int symbol; lw_template *value; } *with;
} lw_use;

typedef struct lw_part {
    const char  *name;
    lw_template *node;
    lw_scope     scope;
    int          n_port, n_use, mark;
    lw_port     *port;
    lw_use      *use;
} lw_part;

typedef struct lw_setting { const char *name; int n; struct { int symbol; lw_amount value; } *set; lw_template *omit; }
    lw_setting;                        /* a configuration or a view */

typedef struct lw_check { lw_template *node; const char *text; lw_formula *formula; } lw_check;

struct lw_master {
    char        *text, *file;
    lw_json      json;
    lw_template *root, *model;
    int          n_template;
    lw_template *block;                /* all templates */
    lw_scope     scope;                /* symbol 0 is `view` */
    int          n_parameter, n_let, n_part, n_use, n_configuration, n_view, n_check;
    lw_part     *part;
    lw_use      *use;                  /* of the model */
    lw_setting  *configuration, *view;
    int          default_view;         /* -1: nothing is left out */
    lw_check    *check;
    lw_amount    length, angle;        /* one unit of the model file */
};

enum { LW_SYMBOL_VIEW = 0, LW_SYMBOL_SELF = 0 };        /* in the scope of the root, of a part */

/* The member of an object; NULL: none. */
lw_template *lw_template_member(const lw_template *object, const char *key);

/* The text of a template; NULL: it is NULL, or no text. */
const char *lw_template_text(const lw_template *t);

/* Error at a template; `inner` (of a formula or text inside it) may be NULL, else its column and text are used. */
lw_status lw_template_fault(const lw_template *t, size_t at, const lw_error *inner, lw_error *e);

struct lw_variant {
    const lw_master *m;
    int         view, configuration;   /* -1: none */
    bool       *given;                 /* (n of the scope) set one by one */
    lw_amount  *own, *value;
    char      **text;                  /* of the values set one by one, owned */
    bool        fresh;                 /* value[] belongs to the settings */
};

/* Index of a configuration or a view (`what`) of this name; -1: there is none, e is filled. */
int lw_setting_find(const char *what, const lw_setting *list, int n, const char *name, lw_error *e);

/* Does the view leave out members with this key? */
bool lw_master_omits(const lw_master *m, int view, const char *key);

/* Work out value[]. */
lw_status lw_variant_update(lw_variant *v, lw_error *e);

static inline lw_status lw_master_no_memory(lw_error *e) { return lw_error_set(e, LW_E_MEMORY, "out of memory for a master file"); }

static inline lw_status lw_template_expect(const lw_template *t, lw_json_kind kind, lw_error *e)
{
    return lw_json_expect(&t->json, kind, e);
}

/* ---- master_compile.c: names of scopes, formulas and texts ---------------------------------------------------- */

/* Where a formula stands: the scope that its words name, and that of the whole master where this one is of a part. */
typedef struct lw_master_place { const lw_master *m; lw_scope *scope; bool in_part; } lw_master_place;

/* The number of a symbol; -1: there is none. */
int lw_scope_find(const lw_scope *s, const char *name);

/* The number of the new symbol; -1: e is filled. */
int lw_scope_add(lw_scope *s, const char *name, lw_template *node, lw_error *e);

/* The formula in text[at .. at + size], the text of t. */
lw_status lw_master_parse_formula(const lw_master_place *p, const lw_template *t, const char *text, size_t at, size_t size, lw_formula **out, lw_error *e);

/* A formula over the names of the root. */
lw_status lw_master_formula(const lw_master *m, const char *text, lw_formula **f, lw_error *e);

/* Compile the formulas and texts of t and below, as the value of a key of `parent`. */
lw_status lw_master_compile(const lw_master_place *p, lw_template *t, const lw_key *key, const char *parent, lw_error *e);

/* After the element: the indexes of its repeat are unknown outside. */
void lw_master_leave_repeat(const lw_master_place *p, const lw_template *object);

/* "when" and "repeat" of an object in a list. */
lw_status lw_master_compile_head(const lw_master_place *p, lw_template *t, lw_error *e);

/* Write a text as a JSON string. */
void lw_master_quote(lw_bytes *b, const char *text);

#endif
