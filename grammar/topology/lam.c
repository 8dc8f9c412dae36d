#include "grammar/topology/lam.h"

#include <stdlib.h>
#include <string.h>
#include "grammar/text/text_internal.h"

void lw_lam_from_mechanism(const lw_mechanism *m, lw_lam *a)
{
    memset(a, 0, sizeof *a);
    a->n_link = m->n_link;
    a->n_joint = m->n_joint;
    for (int j = 0; j < m->n_joint; j++) {
        a->number[m->link[j][0]][m->link[j][1]] = (uint8_t)(j + 1);
        a->kind[j] = m->kind[j];
    }
}

void lw_lam_mechanism(const lw_lam *a, lw_mechanism *m, uint8_t *number_of)
{
    lw_mechanism_clear(m, a->n_link);
    for (int i = 0; i < a->n_link; i++)
        for (int k = i + 1; k < a->n_link; k++)
            if (a->number[i][k]) {
                if (number_of)
                    number_of[m->n_joint] = a->number[i][k];
                lw_mechanism_join(m, i, k, a->kind[a->number[i][k] - 1]);
            }
}

size_t lw_lam_print(const lw_lam *a, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    for (int i = 0; i < a->n_link; i++)
        for (int k = 0; k < a->n_link; k++) {
            int number = i < k ? a->number[i][k] : 0;
            lw_text_add(&t, "%d", number);
            if (number && a->kind[number - 1] != LW_JOINT_REVOLUTE)
                lw_text_byte(&t, a->kind[number - 1]);
            lw_text_byte(&t, k + 1 < a->n_link ? ' ' : '\n');
        }
    return t.length;
}

/* The matrix read so far, and the place of each number. */
typedef struct reading {
    lw_lam   *a;
    lw_cursor at[LW_LINK_MAX][LW_LINK_MAX];
    lw_cursor of[LW_JOINT_MAX + 1];         /* place of a joint number               */
    uint8_t   row_of[LW_JOINT_MAX + 1];     /* its row + 1; 0: not seen              */
    int       below[LW_LINK_MAX][LW_LINK_MAX];
    int       last;                         /* the largest joint number              */
    bool      plain;                        /* 1 means a joint, whatever its number  */
} reading;

static lw_status read_kind(lw_cursor *c, int number, char *kind)
{
    int byte = lw_cursor_peek(c);
    *kind = LW_JOINT_REVOLUTE;
    if (byte == ' ' || byte == ',' || byte == '\t' || byte == '\n' || byte == '\r' || byte == ';' || byte == '#' || byte < 0)
        return LW_OK;
    char name[24];
    if (byte > 127 || !lw_joint_freedoms((char)byte))
        return lw_cursor_fail(c, "%s is no joint letter; a joint is r (pin), t (slider), p (pin in "
                              "slot) or g (gear or cam)", lw_byte_name(byte, name));
    if (number == 0)
        return lw_cursor_fail(c, "0 means no joint and takes no joint letter");
    *kind = (char)lw_cursor_next(c);
    return LW_OK;
}

/* A joint number in the upper triangle. */
static lw_status note_joint(reading *r, const lw_cursor *at, int row, int column, int number, char kind)
{
    if (number > LW_JOINT_MAX)
        return lw_cursor_fail(at, "joint %d is too many: at most %d joints are handled", number, LW_JOINT_MAX);
    if (r->row_of[number])
        return lw_cursor_fail(at, "joint %d is numbered twice: first at line %ld, column %ld",
                              number, r->of[number].line, r->of[number].column);
    r->row_of[number] = (uint8_t)(row + 1);
    r->of[number] = *at;
    r->a->number[row][column] = (uint8_t)number;
    r->a->kind[number - 1] = kind;
    r->a->n_joint++;
    if (number > r->last)
        r->last = number;
    return LW_OK;
}

static lw_status read_entry(lw_cursor *c, reading *r, int row, int column)
{
    lw_cursor at = *c;
    int number;
    char name[24], kind;
    if (column == LW_LINK_MAX)
        return lw_cursor_fail(&at, "the row has more than %d entries, the most links a chain may have", LW_LINK_MAX);
    if (!lw_cursor_number(c, &number))
        return lw_cursor_fail(&at, "%s where a joint number was expected", lw_byte_name(lw_cursor_peek(&at), name));
    lw_status s = read_kind(c, number, &kind);
    if (s != LW_OK)
        return s;
    r->at[row][column] = at;
    if (row == column && number != 0)
        return lw_cursor_fail(&at, "link %d is joined to itself: the diagonal must be 0", row + 1);
    if (row < column && number != 0)
        return note_joint(r, &at, row, column, r->plain ? r->a->n_joint + 1 : number, kind);
    r->below[row][column] = number;
    return LW_OK;
}

/* Read one row; *n_entry is 0 for a line of blanks or a comment only. */
static lw_status read_row(lw_cursor *c, reading *r, int row, int *n_entry)
{
    for (*n_entry = 0;; ++*n_entry) {
        lw_cursor_skip(c, false, 0);
        int byte = lw_cursor_peek(c);
        if (byte == ',' && *n_entry > 0) {
            lw_cursor_next(c);
            lw_cursor_skip(c, false, 0);
            byte = lw_cursor_peek(c);
        }
        if (byte == '#')
            while (lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != '\n')
                lw_cursor_next(c);
        byte = lw_cursor_peek(c);
        if (byte < 0 || byte == '\n' || byte == '\r' || byte == ';')
            return LW_OK;
        if (row == LW_LINK_MAX)
            return lw_cursor_fail(c, "row %d is too many: at most %d links are handled", row + 1, LW_LINK_MAX);
        lw_status s = read_entry(c, r, row, *n_entry);
        if (s != LW_OK)
            return s;
    }
}

static lw_status read_rows(lw_cursor *c, reading *r)
{
    int n_row = 0, n_first = 0;
    while (lw_cursor_peek(c) >= 0) {
        int n_entry;
        lw_status s = read_row(c, r, n_row, &n_entry);
        if (s != LW_OK)
            return s;
        if (n_entry > 0 && n_row == 0)
            n_first = n_entry;
        if (n_entry > 0 && n_entry != n_first)
            return lw_cursor_fail(c, "row %d has %d entries, the first row %d", n_row + 1, n_entry, n_first);
        n_row += n_entry > 0;
        lw_cursor_next(c);
    }
    if (n_row == 0)
        return lw_cursor_fail(c, "there is no matrix");
    if (n_row != n_first)
        return lw_cursor_fail(c, "the matrix has %d rows of %d entries; it must be square", n_row, n_first);
    r->a->n_link = n_row;
    return LW_OK;
}

/* Check the mirror image below the diagonal, and that no number is missing. */
static lw_status check_whole(const reading *r)
{
    for (int i = 0; i < r->a->n_link; i++)
        for (int k = 0; k < i; k++)
            if (r->below[i][k] && (r->plain ? !r->a->number[k][i] : r->below[i][k] != r->a->number[k][i]))
                return lw_cursor_fail(&r->at[i][k], "entry (%d, %d) is %d, its mirror image (%d, %d) "
                                      "is %d; below the diagonal stands 0 or the same number", i + 1,
                                      k + 1, r->below[i][k], k + 1, i + 1, r->a->number[k][i]);
    for (int number = 1; number <= r->last; number++)
        if (!r->row_of[number])
            return lw_cursor_fail(&r->of[r->last], "there is a joint %d but no joint %d: joints are "
                                  "numbered 1 to %d", r->last, number, r->a->n_joint);
    return LW_OK;
}

/* Only 0 and 1? */
static bool is_plain(const char *text, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        if (text[i] == '#')
            while (i + 1 < size && text[i + 1] != '\n')
                i++;
        else if (!strchr("01 ,;\t\r\n", text[i]) || !text[i])
            return false;
        bool digit = text[i] == '0' || text[i] == '1';
        if (digit && i + 1 < size && (text[i + 1] == '0' || text[i + 1] == '1'))
            return false;                           /* 10 or 11 */
    }
    return true;
}

lw_status lw_lam_read(const char *text, size_t size, const char *file, lw_lam *a, lw_error *e)
{
    lw_cursor c = lw_cursor_start(text, size, file, e);
    lw_lam out = { 0 };
    reading *r = calloc(1, sizeof *r);
    if (!r)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    r->a = &out;
    r->plain = is_plain(text, size);
    lw_status s = read_rows(&c, r);
    if (s == LW_OK)
        s = check_whole(r);
    if (s == LW_OK)
        *a = out;
    free(r);
    return s;
}
