/* base/suggest.h - "did you mean ...?": the word of a list that is nearest to a misspelt one. */
#ifndef LW_BASE_SUGGEST_H
#define LW_BASE_SUGGEST_H

/* The nearest of n words by edit distance (insert, drop, change, swap neighbours; capitals do not
 * count), or one that `word` begins; NULL when none is near enough: one edit for each three letters,
 * two at least from four letters on.  The first of equals. */
const char *lw_suggest(const char *word, const char *const *words, int n);

#endif
