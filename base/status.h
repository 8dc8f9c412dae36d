/* base/status.h - the status that a function returns.
 *
 * One list defines the names, numbers and texts.  Numbers >= 0 are outcomes: the function did its work.  Numbers < 0 are
 * failures: nothing was done. */
#ifndef LW_BASE_STATUS_H
#define LW_BASE_STATUS_H

#define LW_STATUS_LIST(X)                                                          \
    X(LW_OK,            0, "success")                                              \
    X(LW_OPEN,          1, "the linkage cannot close at this input")               \
    X(LW_STOPPED,       2, "a limit ended the search before its tolerance")        \
    X(LW_NOTHING,       3, "nothing was found")                                    \
    X(LW_E_ARG,        -1, "argument outside its documented range")                \
    X(LW_E_MEMORY,     -2, "out of memory")                                        \
    X(LW_E_NOTATION,   -3, "text does not follow docs/notation.md")                \
    X(LW_E_IO,         -4, "a file could not be read or written")                  \
    X(LW_E_NUMERIC,    -5, "the numbers do not allow an answer")                   \
    X(LW_E_KIND,       -6, "this kind of mechanism is not handled here")

typedef enum lw_status {
#define X(name, code, text) name = code,
    LW_STATUS_LIST(X)
#undef X
} lw_status;

/* Text of a status; never NULL, even for a number that is not a status. */
const char *lw_status_text(lw_status s);

/* Name of a status, "LW_OK" ...; "LW_?" for a number that is not a status. */
const char *lw_status_name(lw_status s);

#endif
