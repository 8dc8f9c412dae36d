#include "base/suggest.h"

#include <ctype.h>
#include <stddef.h>
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

/* The first word with `word`, of four letters or more, in it, or whose beginning is `word` with one wrong letter in six. */
static const char *longer_word(const char *word, size_t size, const char *const *words, int n)
{
    for (int i = 0; i < n && size >= 6; i++)
        if (strlen(words[i]) > size && strlen(words[i]) <= WORD_MAX && distance(word, words[i], (int)size) <= (int)size/6)
            return words[i];
    for (int i = 0; i < n && size >= 4; i++)
        if (strstr(words[i], word))
            return words[i];
    return NULL;
}

const char *lw_suggest(const char *word, const char *const *words, int n)
{
    size_t size = strlen(word);
    if (size == 0 || size > WORD_MAX)
        return NULL;
    int best = size < 4 ? 1 : size < 9 ? 2 : (int)size/3;
    const char *found = NULL, *begun = NULL;
    for (int i = 0; i < n; i++) {
        if (strlen(words[i]) > WORD_MAX)
            continue;
        int d = distance(word, words[i], (int)strlen(words[i]));
        if (d < best || (d == best && !found)) {
            best = d;
            found = words[i];
        }
        if (!begun && size >= 2 && strncasecmp(word, words[i], size) == 0)
            begun = words[i];
    }
    return found && (best == 0 || !begun) ? found : begun ? begun : longer_word(word, size, words, n);
}
