#include "base/suggest.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

#define WORD_MAX 64             /* longer words get no suggestion */

static int least(int a, int b) { return a < b ? a : b; }
static int lower(char c) { return tolower((unsigned char)c); }

/* Optimal string alignment distance (Damerau 1964) from a to the first n letters of b: row i of the table from the two rows before. */
static int distance(const char *a, const char *b, int n)
{
    int row[3][WORD_MAX + 1];
    for (int j = 0; j <= n; j++)
        row[0][j] = j;
    int i = 0;
    for (; a[i]; i++) {
        int *now = row[(i + 1)%3], *last = row[i%3], *before = row[(i + 2)%3];
        now[0] = i + 1;
        for (int j = 0; j < n; j++) {
            int d = least(last[j] + (lower(a[i]) != lower(b[j])), 1 + least(last[j+1], now[j]));
            if (i > 0 && j > 0 && lower(a[i]) == lower(b[j-1]) && lower(a[i-1]) == lower(b[j]))
                d = least(d, before[j-1] + 1);
            now[j+1] = d;
        }
    }
    return row[i%3][n];
}

/* The words among which to search, as lw_suggest_of has them. */
typedef struct list { const void *first; size_t stride; bool pointers; int n; } list;

static const char *word_of(const list *l, int i)
{
    const void *at = (const char *)l->first + (size_t)i*l->stride;
    return l->pointers ? *(const char *const *)at : at;
}

/* The first word with `word`, of four letters or more, in it, or whose beginning is `word` with one wrong letter in six. */
static const char *longer_word(const char *word, size_t size, const list *l)
{
    for (int i = 0; i < l->n && size >= 6; i++) {
        const char *w = word_of(l, i);
        if (strlen(w) > size && strlen(w) <= WORD_MAX && distance(word, w, (int)size) <= (int)size/6)
            return w;
    }
    for (int i = 0; i < l->n && size >= 4; i++)
        if (strstr(word_of(l, i), word))
            return word_of(l, i);
    return NULL;
}

const char *lw_suggest_of(const char *word, const void *first, size_t stride, bool pointers, int n)
{
    const list l = { first, stride, pointers, n };
    size_t size = strlen(word);
    if (size == 0 || size > WORD_MAX)
        return NULL;
    int best = size < 4 ? 1 : size < 9 ? 2 : (int)size/3;
    const char *found = NULL, *begun = NULL;
    for (int i = 0; i < n; i++) {
        const char *w = word_of(&l, i);
        if (strlen(w) > WORD_MAX)
            continue;
        int d = distance(word, w, (int)strlen(w));
        if (d < best || (d == best && !found)) {
            best = d;
            found = w;
        }
        if (!begun && size >= 2 && strncasecmp(word, w, size) == 0)
            begun = w;
    }
    return found && (best == 0 || !begun) ? found : begun ? begun : longer_word(word, size, &l);
}

const char *lw_suggest(const char *word, const char *const *words, int n)
{
    return lw_suggest_of(word, words, sizeof *words, true, n);
}
