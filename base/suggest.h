/* base/suggest.h - "did you mean ...?": find the word of a list that is nearest to a misspelt one. */
#ifndef LW_BASE_SUGGEST_H
#define LW_BASE_SUGGEST_H

/* The nearest of n words by edit distance (insert, delete, replace, swap neighbours; upper and lower case are equal), or
 * a word that begins with `word`, or nearly so, or has it within.  NULL if none is near enough: one edit per three letters is allowed, and at least two
 * from four letters on.  Of equally near words, the first. */
const char *lw_suggest(const char *word, const char *const *words, int n);

/* The three arguments of "%s%s%s" for `; did you mean "word"?`; nothing if it is NULL. */
#define LW_DID_YOU_MEAN(word) (word) ? "; did you mean \"" : "", (word) ? (word) : "", (word) ? "\"?" : ""

#endif
