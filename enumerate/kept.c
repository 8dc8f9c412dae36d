/* enumerate/kept.c - see kept.h. */
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>
#include "base/bytes.h"
#include "base/file.h"
#include "base/parallel.h"
#include "enumerate/canon.h"
#include "enumerate/kept.h"

#define PART_STRUCTURES 4096         /* structures of one part: about a second of work with nine loops */

struct lw_kept {
    char        *path;
    int          fd;
    bool         begun;
    lw_kept_head head;
    lw_numbers   numbers;
    size_t       n_row;
    bool        *have;               /* (n_part) */
    lw_tally    *row;                /* (n_part, n_row) */
};

static uint64_t hash(const char *text, size_t size)
{
    uint64_t h = 14695981039346656037u;               /* FNV-1a */
    for (size_t i = 0; i < size; i++)
        h = (h ^ (uint8_t)text[i])*1099511628211u;
    return h;
}

/* Structures of part p. */
static uint64_t part_size(const lw_kept_head *h, int p)
{
    uint64_t n = (uint64_t)h->n_part, first = (uint64_t)p;
    return h->n_structure > first ? (h->n_structure - first + n - 1)/n : 0;
}

const lw_kept_head *lw_kept_head_of(const lw_kept *k) { return k->begun ? &k->head : NULL; }
bool lw_kept_has(const lw_kept *k, int p) { return k->begun && k->have[p]; }

int lw_kept_count(const lw_kept *k, int r, int m)
{
    int n = 0;
    for (int p = r; k->begun && p < k->head.n_part; p += m)
        n += k->have[p];
    return n;
}

static lw_status make_room(lw_kept *k, const lw_kept_head *head)
{
    lw_assortment a;
    k->n_row = 0;
    for (bool more = lw_assortment_first(&k->numbers, &a); more; more = lw_assortment_next(&k->numbers, &a))
        k->n_row++;
    k->head = *head;
    k->have = calloc((size_t)head->n_part, sizeof *k->have);
    k->row = calloc((size_t)head->n_part*k->n_row, sizeof *k->row);
    k->begun = k->have && k->row;
    return k->begun ? LW_OK : LW_E_MEMORY;
}

/* ---- reading --------------------------------------------------------------------------------------- */

static lw_status bad_line(const lw_kept *k, long line, const char *why, lw_error *e)
{
    return lw_error_at(e, LW_E_NOTATION, k->path, line, 1, "%s", why);
}

static bool same_head(const lw_kept_head *a, const lw_kept_head *b)
{
    return a->n_link == b->n_link && a->dof == b->dof && strcmp(a->filter, b->filter) == 0
        && a->n_structure == b->n_structure && a->digest == b->digest && a->n_part == b->n_part;
}

static lw_status read_head(lw_kept *k, const char *text, long line, lw_error *e)
{
    lw_kept_head h = { 0 };
    int end = 0;
    int n = sscanf(text, "count links %d dof %d filter %23s structures %" SCNu64 " digest %" SCNx64 " parts %d%n",
                   &h.n_link, &h.dof, h.filter, &h.n_structure, &h.digest, &h.n_part, &end);
    if (n != 6 || text[end] || h.n_part < 1 || h.n_part > 100000000)
        return bad_line(k, line, "this is no line 'count links P dof F filter NAME structures N digest X parts M'", e);
    if (h.n_link != k->head.n_link || h.dof != k->head.dof || strcmp(h.filter, k->head.filter) != 0)
        return lw_error_at(e, LW_E_NOTATION, k->path, line, 1, "this file keeps the count of chains with %d links, F = "
                           "%d, filter %s; give another file", h.n_link, h.dof, h.filter);
    if (k->begun)
        return same_head(&h, &k->head) ? LW_OK
             : bad_line(k, line, "another count begins here, with other structures or parts", e);
    lw_status status = make_room(k, &h);
    return status == LW_OK ? LW_OK : lw_error_set(e, status, "out of memory");
}

/* The numbers of a line `part` whose check is right. */
static bool read_numbers(lw_kept *k, const char *text, int *part)
{
    uint64_t structures, chains, grounds;
    int end = 0;
    if (sscanf(text, "part %d structures %" SCNu64 " chains %" SCNu64 " ground-links %" SCNu64 " by-assortment%n",
               part, &structures, &chains, &grounds, &end) != 4 || end == 0)
        return false;
    if (*part < 1 || *part > k->head.n_part || structures != part_size(&k->head, *part - 1))
        return false;
    bool generating = strcmp(k->head.filter, "generating") == 0;
    lw_tally sum = { 0, 0, 0 }, *row = k->row + (size_t)(*part - 1)*k->n_row;
    const char *at = text + end;
    for (size_t i = 0; i < k->n_row; i++) {
        lw_tally n = { 0, 0, 0 };
        if (sscanf(at, " %" SCNu64 ":%" SCNu64 "%n", &n.n_chain, &n.n_ground, &end) != 2)
            return false;
        at += end;
        if (generating && (*at != ':' || !lw_whole_read(at + 1, &at, &n.n_labelled)))
            return false;
        (void)lw_tally_add(&sum, &n);
        if (!k->have[*part - 1])
            row[i] = n;
    }
    return strncmp(at, " check ", 7) == 0 && sum.n_chain == chains && sum.n_ground == grounds;
}

static lw_status read_part(lw_kept *k, const char *text, long line, lw_error *e)
{
    const char *check = strstr(text, " check ");
    uint64_t want;
    int end = 0, part;
    if (!k->begun)
        return bad_line(k, line, "a part before the line 'count ...'", e);
    if (!check || sscanf(check, " check %" SCNx64 "%n", &want, &end) != 1 || check[end]
        || want != hash(text, (size_t)(check - text)) || !read_numbers(k, text, &part))
        return bad_line(k, line, "this part is damaged; remove the line, and the part is counted again", e);
    if (k->have[part - 1])
        return bad_line(k, line, "this part comes a second time; remove the line", e);
    k->have[part - 1] = true;
    return LW_OK;
}

static lw_status read_lines(lw_kept *k, char *text, size_t size, lw_error *e)
{
    lw_status status = LW_OK;
    long line = 1;
    for (char *at = text, *end; status == LW_OK && at < text + size; at = end + 1, line++) {
        end = at + strcspn(at, "\n");
        *end = '\0';
        if (*at == '#' || !*at)
            continue;
        status = strncmp(at, "count ", 6) == 0 ? read_head(k, at, line, e)
               : strncmp(at, "part ", 5) == 0 ? read_part(k, at, line, e)
               : bad_line(k, line, "this is no file of a kept count", e);
    }
    return status;
}

/* The text of the file, with some bytes more; *size ends with the last whole line. */
static char *read_text(int fd, size_t *size)
{
    off_t length = lseek(fd, 0, SEEK_END);
    char *text = length < 0 ? NULL : calloc((size_t)length + 16, 1);
    size_t n = 0;
    while (text && n < (size_t)length) {
        ssize_t got = pread(fd, text + n, (size_t)length - n, (off_t)n);
        if (got <= 0) {
            free(text);
            return NULL;
        }
        n += (size_t)got;
    }
    while (text && n > 0 && text[n - 1] != '\n')
        n--;
    *size = n;
    return text;
}

void lw_kept_close(lw_kept *k)
{
    if (!k)
        return;
    if (k->fd >= 0)
        close(k->fd);
    free(k->path);
    free(k->have);
    free(k->row);
    free(k);
}

static lw_status open_file(lw_kept *k, const char *path, lw_error *e)
{
    size_t size = 0;
    k->fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (k->fd < 0)
        return lw_file_failed(e, "written", path, errno);
    if (flock(k->fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return lw_error_set(e, LW_E_IO, "another program writes %s; give each its own file and join them with cat", path);
    errno = 0;
    char *text = read_text(k->fd, &size);
    if (!text)
        return errno == ENOMEM ? lw_error_set(e, LW_E_MEMORY, "out of memory") : lw_error_set(e, LW_E_IO, "cannot read %s", path);
    bool own = memchr(text, '\0', size) == NULL && (size > 0 || lseek(k->fd, 0, SEEK_END) == 0 || memcmp(text, "# linkwright", 12) == 0);
    lw_status status = own ? read_lines(k, text, size, e) : bad_line(k, 1, "this is no file of a kept count", e);
    free(text);
    if (status == LW_OK && (ftruncate(k->fd, (off_t)size) != 0 || lseek(k->fd, 0, SEEK_END) < 0))
        status = lw_file_failed(e, "written", path, errno);
    return status;
}

lw_status lw_kept_open(const char *path, int n_link, int dof, const lw_filter *filter, lw_kept **kept, lw_error *e)
{
    lw_kept *k = calloc(1, sizeof *k);
    if (!k || !(k->path = strdup(path))) {
        free(k);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    k->fd = -1;
    k->head = (lw_kept_head){ .n_link = n_link, .dof = dof };
    snprintf(k->head.filter, sizeof k->head.filter, "%s", filter ? filter->name : "none");
    lw_status status = lw_numbers_for_links(n_link, dof, 0, &k->numbers, e);
    if (status == LW_OK)
        status = open_file(k, path, e);
    if (status == LW_OK)
        *kept = k;
    else
        lw_kept_close(k);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------------- */

static lw_status append(lw_kept *k, const lw_bytes *b, lw_error *e)
{
    size_t n = 0;
    while (!b->failed && n < b->size) {
        ssize_t put = write(k->fd, b->data + n, b->size - n);
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            return lw_file_failed(e, "written", k->path, errno);
        n += (size_t)put;
    }
    if (b->failed)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    (void)fdatasync(k->fd);                           /* not for pipes and some file systems */
    return LW_OK;
}

static uint64_t structure_count(const lw_chains *chains)
{
    const lw_structures *set = lw_chains_structures(chains);
    return set ? lw_structures_count(set, lw_chains_numbers(chains)->n_loop) : 1;
}

int lw_kept_parts(const lw_chains *chains)
{
    return (int)((structure_count(chains) + PART_STRUCTURES - 1)/PART_STRUCTURES);
}

lw_status lw_kept_begin(lw_kept *k, const lw_chains *chains, lw_error *e)
{
    const lw_structures *set = lw_chains_structures(chains);
    lw_kept_head h = k->head;
    h.n_structure = structure_count(chains);
    h.digest = set ? lw_structures_digest(set, k->numbers.n_loop) : 0;
    if (k->begun)
        return h.n_structure == k->head.n_structure && h.digest == k->head.digest ? LW_OK
             : lw_error_set(e, LW_E_NOTATION, "%s counts other structures (%" PRIu64 ", digest %016" PRIx64 "; here %"
                            PRIu64 ", %016" PRIx64 ")", k->path, k->head.n_structure, k->head.digest, h.n_structure,
                            h.digest);
    h.n_part = lw_kept_parts(chains);
    lw_status status = make_room(k, &h);
    if (status != LW_OK)
        return lw_error_set(e, status, "out of memory");
    char text[512];
    lw_bytes b = { 0 };
    snprintf(text, sizeof text, "# linkwright chains --links %d --dof %d --count, parts R/%d; numbers of chains and "
             "ground links (inversions)\ncount links %d dof %d filter %s structures %" PRIu64 " digest %016" PRIx64
             " parts %d\n", h.n_link, h.dof, h.n_part, h.n_link, h.dof, h.filter, h.n_structure, h.digest, h.n_part);
    lw_bytes_text(&b, text);
    status = append(k, &b, e);
    lw_bytes_free(&b);
    return status;
}

lw_status lw_kept_add(lw_kept *k, int p, const lw_chain_table *table, lw_error *e)
{
    char text[160], digits[LW_WHOLE_SIZE];
    bool generating = strcmp(k->head.filter, "generating") == 0;
    lw_bytes b = { 0 };
    snprintf(text, sizeof text, "part %d structures %" PRIu64 " chains %" PRIu64 " ground-links %" PRIu64
             " by-assortment", p + 1, part_size(&k->head, p), table->total.n_chain, table->total.n_ground);
    lw_bytes_text(&b, text);
    for (size_t i = 0; i < table->n_row; i++) {
        const lw_tally *n = &table->row[i].n;
        snprintf(text, sizeof text, " %" PRIu64 ":%" PRIu64 "%s%s", n->n_chain, n->n_ground, generating ? ":" : "",
                 generating ? lw_whole_print(n->n_labelled, digits) : "");
        lw_bytes_text(&b, text);
        k->row[(size_t)p*k->n_row + i] = *n;
    }
    snprintf(text, sizeof text, " check %016" PRIx64 "\n", b.failed ? 0 : hash(b.data, b.size));
    lw_bytes_text(&b, text);
    lw_status status = append(k, &b, e);
    k->have[p] = status == LW_OK;
    lw_bytes_free(&b);
    return status;
}

/* ---- counting -------------------------------------------------------------------------------------- */

typedef struct run {
    lw_kept             *k;
    const lw_chains     *chains;
    const lw_chain_walk *how;
    int                 *part;            /* (n) missing ones            */
    size_t               n, done;
    pthread_mutex_t      lock;
    lw_status            status;          /* under `lock`, as all below  */
    lw_error            *e;
} run;

static bool go_on(run *r)
{
    pthread_mutex_lock(&r->lock);
    if (r->status == LW_OK && r->how->tick && !r->how->tick(r->how->tick_context, (double)r->done/(double)r->n))
        r->status = LW_STOPPED;
    bool on = r->status == LW_OK;
    pthread_mutex_unlock(&r->lock);
    return on;
}

/* Ends the part at work when the run has ended. */
static bool part_tick(void *context, double done)
{
    (void)done;
    return go_on(context);
}

static void count_part(void *context, size_t job, int thread)
{
    run *r = context;
    lw_chain_table table = { .n_row = 0 };
    (void)thread;
    if (!go_on(r))
        return;
    lw_chain_walk how = *r->how;
    how.part = r->part[job];
    how.n_part = r->k->head.n_part;
    how.n_thread = 1;
    how.tick = part_tick;
    how.tick_context = r;
    lw_status status = lw_chains_count(r->chains, &how, &table);
    pthread_mutex_lock(&r->lock);
    if (status == LW_OK) {
        status = lw_kept_add(r->k, r->part[job], &table, r->e);
        r->done++;
    } else if (status != LW_STOPPED && r->status == LW_OK) {
        (void)lw_graph_error(r->e, status);
    }
    if (r->status == LW_OK)
        r->status = status;
    pthread_mutex_unlock(&r->lock);
    lw_chain_table_free(&table);
}

lw_status lw_kept_run(lw_kept *k, const lw_chains *chains, const lw_chain_walk *how, lw_error *e)
{
    run r = { .k = k, .chains = chains, .how = how, .status = LW_OK, .e = e };
    r.part = malloc((size_t)k->head.n_part*sizeof *r.part);
    if (!r.part)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int p = how->part; p < k->head.n_part; p += how->n_part)
        if (!k->have[p])
            r.part[r.n++] = p;
    pthread_mutex_init(&r.lock, NULL);
    lw_status status = lw_parallel(how->n_thread, r.n, count_part, &r);
    pthread_mutex_destroy(&r.lock);
    free(r.part);
    return r.status != LW_OK ? r.status : status;
}

lw_status lw_kept_sum(const lw_kept *k, int r, int m, lw_chain_table *table)
{
    lw_status status = lw_chain_table_make(&k->numbers, table);
    for (int p = r; p < k->head.n_part && status == LW_OK; p += m)
        for (size_t i = 0; i < k->n_row && k->have[p]; i++) {
            const lw_tally *n = &k->row[(size_t)p*k->n_row + i];
            if (lw_tally_add(&table->row[i].n, n) != LW_OK || lw_tally_add(&table->total, n) != LW_OK)
                return LW_E_ARG;
        }
    return status;
}
