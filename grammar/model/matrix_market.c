#include "grammar/model/matrix_market.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "base/number.h"

/* The text, and where the next word begins. */
typedef struct words { const char *at, *end, *line, *file; long row; lw_error *e; } words;

static lw_status fault(const words *w, const char *at, const char *why)
{
    return lw_error_at(w->e, LW_E_NOTATION, w->file, w->row, (long)(at - w->line) + 1, "%s", why);
}

/* The next word of this line, or (more) of the lines that follow; comments are skipped.  Returns its length, 0: none. */
static size_t next_word(words *w, bool more, const char **word)
{
    while (w->at < w->end && (*w->at == ' ' || *w->at == '\t' || *w->at == '\r' || (more && (*w->at == '\n' || *w->at == '%')))) {
        if (*w->at == '%')
            while (w->at < w->end && *w->at != '\n')
                w->at++;
        if (w->at < w->end && *w->at == '\n')
            w->row++, w->line = w->at + 1;
        w->at += w->at < w->end;
    }
    *word = w->at;
    while (w->at < w->end && !memchr(" \t\r\n", *w->at, 4))
        w->at++;
    return (size_t)(w->at - *word);
}

static lw_status number(words *w, bool more, double *out)
{
    const char *word;
    size_t n = next_word(w, more, &word);
    if (n == 0)
        return fault(w, word, word == w->end ? "the file ends, but more entries are to follow" : "a number is expected here");
    return lw_number_parse(word, n, out) == LW_OK ? LW_OK : fault(w, word, "this is no finite number");
}

static lw_status whole(words *w, bool more, double least, double most, int *out)
{
    double x = 0;
    lw_status s = number(w, more, &x);
    if (s == LW_OK && !(x >= least && x <= most && x == (double)(int)x))
        s = fault(w, w->at, "this is no number of a row or column, or too large: at most 600");
    *out = s == LW_OK ? (int)x : 0;
    return s;
}

/* Is the next word of the line one of two?  0, 1; -1: neither. */
static int either(words *w, const char *a, const char *b)
{
    const char *word;
    size_t n = next_word(w, false, &word);
    return n == strlen(a) && strncasecmp(word, a, n) == 0 ? 0 : n == strlen(b) && strncasecmp(word, b, n) == 0 ? 1 : -1;
}

lw_status lw_matrix_market_read(const char *text, size_t size, const char *file, int *n, double **out, lw_error *e)
{
    words w = { text, text + size, text, file, 1, e };
    const char *word;
    int columns = 0;
    double entries = 0;
    *n = 0;
    *out = NULL;
    size_t length = next_word(&w, false, &word);
    if (length != 14 || strncasecmp(word, "%%MatrixMarket", length) != 0)
        return fault(&w, text, "a file of the Matrix Market begins with \"%%MatrixMarket matrix\"");
    if (either(&w, "matrix", "matrix") < 0)
        return fault(&w, w.at, "only a \"matrix\" is known");
    int array = either(&w, "coordinate", "array"), kind = array < 0 ? -1 : either(&w, "real", "integer");
    int symmetric = kind < 0 ? -1 : either(&w, "general", "symmetric");
    if (symmetric < 0)
        return fault(&w, w.at, "the matrix is to be coordinate or array, real or integer, general or symmetric");
    lw_status s = whole(&w, true, 1, LW_MATRIX_MOST, n);
    if (s == LW_OK && (s = whole(&w, false, 1, LW_MATRIX_MOST, &columns)) == LW_OK && columns != *n)
        s = fault(&w, w.at, "the matrix is not square");
    if (s == LW_OK && !array && (s = number(&w, false, &entries)) == LW_OK && !(entries >= 0 && entries <= 1.0*columns*columns))
        s = fault(&w, w.at, "a matrix of this size has not so many entries");
    if (s != LW_OK)
        return s;
    double *a = calloc((size_t)columns*(size_t)columns, sizeof *a);
    if (!a)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    long count = array ? symmetric ? (long)columns*(columns + 1)/2 : (long)columns*columns : (long)entries;
    for (long k = 0, i = 0, j = 0; s == LW_OK && k < count; k++) {
        int row = (int)i + 1, column = (int)j + 1;
        double x = 0;
        if (!array && (s = whole(&w, true, 1, columns, &row)) == LW_OK)
            s = whole(&w, false, 1, columns, &column);
        if (s == LW_OK)
            s = number(&w, array, &x);
        if (s == LW_OK) {
            a[(row - 1)*columns + column - 1] = x;
            if (symmetric)
                a[(column - 1)*columns + row - 1] = x;
        }
        if (++i == columns)
            j++, i = symmetric ? j : 0;
    }
    if (s == LW_OK && next_word(&w, true, &word) > 0)
        s = fault(&w, word, "the matrix has more entries than its head says");
    if (s == LW_OK)
        *out = a;
    else
        free(a);
    return s;
}
