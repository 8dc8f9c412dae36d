/* catalogues/store/query.h - the language of questions to a catalogue, compiled to SQL with parameters.
 *
 *     links=6 and sliders>=1 and class=GCRR and error<0.01
 *     links=8..10 and not planar;  symmetry>1 or grounds<5;  name~"Jansen*";  error_max<2mm;  class in (GCRR, GCCC)
 *
 *     question = test, with  and  or  not  ( )
 *     test     = field | field op value | field in (value, ...) | field = least..greatest
 *     op       = =  !=  <  <=  >  >=  ~        ~: a pattern with * and ?, or a part of the text
 *     value    = number with or without a unit (mm, deg, ...) | word | "text" | 'text' | yes | no | none
 *
 * An unknown value (null) is neither equal nor unequal to anything but  none. Every value becomes a parameter of the
 * SQL, and every field name comes from a table here, so that no text of a question can become SQL. */
#ifndef LW_CATALOGUES_STORE_QUERY_H
#define LW_CATALOGUES_STORE_QUERY_H

#include "base/bytes.h"
#include "catalogues/store/store.h"

#define LW_QUERY_VALUE_MAX 64
#define LW_QUERY_TEXT_MAX  4096

/* The kinds of rows that a query lists. */
typedef enum lw_query_list {
    LW_LIST_CHAINS, LW_LIST_MECHANISMS, LW_LIST_LINKAGES, LW_LIST_STRUCTURES,
    LW_LIST_ANY                                  /* the first that has all fields of the question     */
} lw_query_list;

typedef enum lw_field_kind {
    LW_FIELD_INTEGER, LW_FIELD_REAL, LW_FIELD_LENGTH, LW_FIELD_ANGLE, LW_FIELD_TEXT, LW_FIELD_FLAG
} lw_field_kind;

typedef struct lw_query_field {
    const char   *name, *about;
    lw_field_kind kind;
    const char   *sql[LW_LIST_ANY];              /* in each list; NULL: the list has no such field   */
} lw_query_field;

extern const lw_query_field lw_fields[];               /* ends with name NULL                              */
extern const char *const lw_list_names[LW_LIST_ANY + 1];

typedef struct lw_query_options {
    lw_query_list list;
    const char   *columns;                       /* fields separated by commas; NULL: default        */
    const char   *sort;                          /* fields separated by commas; -FIELD: falling; NULL */
    long          limit;                         /* rows; 0: all                                     */
} lw_query_options;

/* SQL for lw_store_ask. */
typedef struct lw_query {
    lw_query_list list;
    lw_bytes      sql;
    int           n_value;
    lw_value      value[LW_QUERY_VALUE_MAX];
    char          text[2*LW_QUERY_TEXT_MAX];     /* of the values                                    */
} lw_query;

/* Compile the question; NULL or an empty text asks for all rows. LW_E_NOTATION with the column and what to do: an
 * unknown field (with a suggestion), a value of the wrong kind, a parenthesis that is not closed; LW_E_ARG: no list
 * has all the fields; LW_E_MEMORY. Free with lw_query_free, also after a failure. */
lw_status lw_query_compile(const char *text, const lw_query_options *o, lw_query *q, lw_error *e);
void      lw_query_free(lw_query *q);

#endif
