/* base/suggest.h - "did you mean ...?": find the word of a list that is nearest to a misspelt one. */
#ifndef LW_BASE_SUGGEST_H
#define LW_BASE_SUGGEST_H

#include <stdbool.h>
#include <stddef.h>

/* The nearest of n words by edit distance (insert, delete, replace, swap neighbours; upper and lower case are equal), or
 * a word that begins with `word`, or nearly so, or has it within.  NULL if none is near enough: one edit per three letters is allowed, and at least two
 * from four letters on.  Of equally near words, the first. */
const char *lw_suggest(const char *word, const char *const *words, int n);

/* The same among the names of n items that are `stride` bytes apart.  first: the name of the first one, an array of characters;
 * with `pointers` a pointer to a name. */
const char *lw_suggest_of(const char *word, const void *first, size_t stride, bool pointers, int n);

/* The same for a list of structs, by the member that is, or points to, the name. */
#define LW_SUGGEST(word, list, n, member) \
    lw_suggest_of(word, (n) > 0 ? (const void *)&(list)->member : NULL, sizeof *(list), \
                  __builtin_types_compatible_p(__typeof__((list)->member), __typeof__(&(list)->member[0])), n)

/* The three arguments of "%s%s%s" for `; did you mean "word"?`; nothing if it is NULL. */
#define LW_DID_YOU_MEAN(word) (word) ? "; did you mean \"" : "", (word) ? (word) : "", (word) ? "\"?" : ""

#endif
