/* studio/server.c - the server of the page (bridge to libmicrohttpd): who may ask, and who answers. */
#include "studio/studio_internal.h"

#include <arpa/inet.h>
#include <errno.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <stdio.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include "base/library.h"
#include "grammar/text/json_internal.h"
#include "studio_files.h"          /* studio_files: the page's files as texts, made by the Makefile */

#define MOST_BYTES (8u << 20)      /* of a request */

/* libmicrohttpd brings the libraries of encrypted connections, so it is loaded with the first server (base/library.h). */
#define CALLS(X) \
    X(add_response_header) X(create_response_from_buffer) X(destroy_response) X(get_daemon_info) X(lookup_connection_value) \
    X(queue_response) X(start_daemon) X(stop_daemon)

static struct {
#define X(f) __typeof__(MHD_##f) *f;
    CALLS(X)
#undef X
} http;
static pthread_once_t loading = PTHREAD_ONCE_INIT;
static lw_error       not_loaded;                /* status LW_OK: it is loaded */

static void load(void)
{
    static const lw_library_call call[] = {
#define X(f) { "MHD_" #f, &http.f },
        CALLS(X)
#undef X
    };
    not_loaded.status = lw_library_load("libmicrohttpd.so.12", "libmicrohttpd12", call, (int)(sizeof call/sizeof *call), &not_loaded);
}

/* ---- answers ------------------------------------------------------------------------------------------------ */

static const struct { const char *name; studio_answer *answer; } answers[] = {
    { "begin", studio_begin },     { "open", studio_open },         { "motion", studio_motion },
    { "analyse", studio_analyse }, { "forces", studio_forces },     { "mobility", studio_mobility },
    { "target", studio_target },   { "search", studio_search_start }, { "news", studio_search_news },
    { "stop", studio_search_stop },{ "nearest", studio_nearest },   { "export", studio_export },
    { "assembly", studio_assembly },{ "chains", studio_chains },   { "chain", studio_chain_linkage }, { "gallery", studio_gallery },
};

static void put_error(studio_reply *r, int status, const lw_error *e)
{
    lw_bytes_free(&r->body);
    r->status = status;
    r->type = "application/json";
    lw_bytes_text(&r->body, "{");
    studio_put_text(&r->body, "error", e->text);
    if (e->line > 0) {
        studio_put_real(&r->body, "line", (double)e->line);
        studio_put_real(&r->body, "column", (double)e->column);
    }
    lw_bytes_text(&r->body, "}\n");
}

static void refuse(studio_reply *r, int status, const char *why)
{
    lw_error e = { 0 };
    snprintf(e.text, sizeof e.text, "%s", why);
    put_error(r, status, &e);
}

void studio_ask(studio *s, const char *name, const lw_bytes *body, studio_reply *r)
{
    lw_error e = { 0 };
    json_error_t fault;
    size_t i = 0, n = sizeof answers/sizeof *answers;
    while (i < n && strcmp(answers[i].name, name) != 0)
        i++;
    if (i == n) {
        refuse(r, MHD_HTTP_NOT_FOUND, "the studio has no such answer");
        return;
    }
    json_t *ask;
    lw_status st = lw_json_load(body->data ? body->data : "", body->size, JSON_REJECT_DUPLICATES, &ask, &fault);
    if (st == LW_E_MEMORY) {
        refuse(r, MHD_HTTP_INTERNAL_SERVER_ERROR, "out of memory");
        return;
    }
    if (!json_is_object(ask)) {
        refuse(r, MHD_HTTP_BAD_REQUEST, "the body of the request is not a JSON object");
        json_decref(ask);
        return;
    }
    st = answers[i].answer(s, ask, r, &e);
    json_decref(ask);
    if (st < 0 && !e.text[0])
        snprintf(e.text, sizeof e.text, "%s", lw_status_text(st));
    if (st < 0)
        put_error(r, 422, &e);
}

/* A file of the page: those of the table, nothing of the disk. */
static void give_file(const char *name, studio_reply *r)
{
    static const char *const types[][2] = { { ".html", "text/html; charset=utf-8" }, { ".css", "text/css; charset=utf-8" },
                                            { ".js", "text/javascript; charset=utf-8" }, { ".svg", "image/svg+xml" } };
    if (!*name)
        name = "index.html";
    for (size_t i = 0; studio_files[i].name; i++) {
        if (strcmp(studio_files[i].name, name) != 0)
            continue;
        for (const char *const *line = studio_files[i].line; *line; line++)
            lw_bytes_text(&r->body, *line);
        for (size_t k = 0; k < sizeof types/sizeof *types; k++)
            if (strcmp(strrchr(name, '.'), types[k][0]) == 0)
                r->type = types[k][1];
        return;
    }
    refuse(r, MHD_HTTP_NOT_FOUND, "the studio has no such page");
}

/* ---- who may ask -------------------------------------------------------------------------------------------- */

static bool same_secret(const char *a, const char *b, size_t n)
{
    unsigned char differs = 0;
    for (size_t i = 0; i < n; i++)
        differs |= (unsigned char)(a[i] ^ b[i]);
    return differs == 0;
}

/* Is this "127.0.0.1:PORT" or "localhost:PORT", behind "http://" if it is an origin? */
static bool is_here(const studio *s, const char *text, const char *before)
{
    char here[64];
    static const char *const hosts[] = { "127.0.0.1", "localhost" };
    for (int i = 0; i < 2; i++) {
        snprintf(here, sizeof here, "%s%s:%d", before, hosts[i], s->port);
        if (strcmp(text, here) == 0)
            return true;
    }
    return false;
}

/* NULL: the request may be answered.  Else why not.  *rest: the address behind the token. */
static const char *forbidden(const studio *s, struct MHD_Connection *c, const char *url, const char **rest)
{
    const char *host = http.lookup_connection_value(c, MHD_HEADER_KIND, "Host");
    const char *origin = http.lookup_connection_value(c, MHD_HEADER_KIND, "Origin");
    const char *site = http.lookup_connection_value(c, MHD_HEADER_KIND, "Sec-Fetch-Site");
    size_t n = STUDIO_TOKEN_SIZE - 1;
    if (!host || !is_here(s, host, ""))
        return "the request names another host";
    if (origin && !is_here(s, origin, "http://"))
        return "the request comes from the page of another origin";
    if (strlen(url) < n + 2 || url[0] != '/' || url[n + 1] != '/' || !same_secret(url + 1, s->token, n))
        return "the address lacks the token; open the address that linkwright studio printed";
    if (site && strcmp(site, "cross-site") == 0 && strcmp(url + n + 2, "") != 0)
        return "the request comes from the page of another site";
    *rest = url + n + 2;
    return NULL;
}

/* ---- requests ----------------------------------------------------------------------------------------------- */

typedef struct request {
    lw_bytes body;
    bool     too_large;
} request;

static enum MHD_Result send_reply(struct MHD_Connection *c, studio_reply *r)
{
    static const char *const headers[][2] = {
        { "Cache-Control", "no-store" }, { "X-Content-Type-Options", "nosniff" }, { "Referrer-Policy", "no-referrer" },
        { "X-Frame-Options", "DENY" }, { "Cross-Origin-Resource-Policy", "same-origin" },
        { "Cross-Origin-Opener-Policy", "same-origin" },
        { "Content-Security-Policy", "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
                                     "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'" },
    };
    if (r->body.failed)
        refuse(r, MHD_HTTP_INTERNAL_SERVER_ERROR, "out of memory");
    struct MHD_Response *response = http.create_response_from_buffer(r->body.size, r->body.data ? r->body.data : "", MHD_RESPMEM_MUST_COPY);
    lw_bytes_free(&r->body);
    if (!response)
        return MHD_NO;
    enum MHD_Result done = http.add_response_header(response, "Content-Type", r->type);
    for (size_t i = 0; i < sizeof headers/sizeof *headers && done == MHD_YES; i++)
        done = http.add_response_header(response, headers[i][0], headers[i][1]);
    if (done == MHD_YES)
        done = http.queue_response(c, (unsigned)r->status, response);
    http.destroy_response(response);
    return done;
}

static bool says_too_large(struct MHD_Connection *c)
{
    const char *size = http.lookup_connection_value(c, MHD_HEADER_KIND, "Content-Length");
    return size && (strlen(size) > 9 || strtol(size, NULL, 10) > (long)MOST_BYTES);
}

static enum MHD_Result handle(void *context, struct MHD_Connection *c, const char *url, const char *method,
                              const char *version, const char *data, size_t *size, void **own)
{
    studio *s = context;
    request *q = *own;
    studio_reply r = { 200, "application/json", { 0 } };
    const char *rest = "", *why = forbidden(s, c, url, &rest);
    (void)version;
    if (!q) {
        if (!(q = *own = calloc(1, sizeof *q)))
            return MHD_NO;
        if (why)
            refuse(&r, MHD_HTTP_FORBIDDEN, why);
        else if (says_too_large(c))
            refuse(&r, MHD_HTTP_CONTENT_TOO_LARGE, "the request is larger than 8 MB");
        return r.body.size ? send_reply(c, &r) : MHD_YES;
    }
    if (*size > 0) {
        q->too_large = q->too_large || q->body.size + *size > MOST_BYTES;
        if (!q->too_large)
            lw_bytes_add(&q->body, data, *size);
        *size = 0;
        return MHD_YES;
    }
    bool post = strcmp(method, "POST") == 0, get = strcmp(method, "GET") == 0 || strcmp(method, "HEAD") == 0;
    const char *type = http.lookup_connection_value(c, MHD_HEADER_KIND, "Content-Type");
    if (q->too_large)
        refuse(&r, MHD_HTTP_CONTENT_TOO_LARGE, "the request is larger than 8 MB");
    else if (q->body.failed)
        refuse(&r, MHD_HTTP_INTERNAL_SERVER_ERROR, "out of memory");
    else if (get && strncmp(rest, "api/", 4) != 0)
        give_file(rest, &r);
    else if (!post || strncmp(rest, "api/", 4) != 0)
        refuse(&r, MHD_HTTP_METHOD_NOT_ALLOWED, "files are read with GET, questions are asked with POST");
    else if (!type || strncmp(type, "application/json", 16) != 0)
        refuse(&r, MHD_HTTP_UNSUPPORTED_MEDIA_TYPE, "a question has the content type application/json");
    else
        studio_ask(s, rest + 4, &q->body, &r);
    return send_reply(c, &r);
}

static void done(void *context, struct MHD_Connection *c, void **own, enum MHD_RequestTerminationCode why)
{
    request *q = *own;
    (void)context, (void)c, (void)why;
    if (q)
        lw_bytes_free(&q->body);
    free(q);
    *own = NULL;
}

/* ---- start and end ------------------------------------------------------------------------------------------- */

static lw_status make_token(char token[STUDIO_TOKEN_SIZE], lw_error *e)
{
    unsigned char random[(STUDIO_TOKEN_SIZE - 1)/2];
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return lw_error_set(e, LW_E_IO, "the system has no random bytes: %s", strerror(errno));
    for (size_t i = 0; i < sizeof random; i++)
        snprintf(token + 2*i, 3, "%02x", random[i]);
    return LW_OK;
}

static lw_status listen_here(studio *s, int port, lw_error *e)
{
    pthread_once(&loading, load);
    if (not_loaded.status != LW_OK)
        return lw_error_set(e, not_loaded.status, "the studio needs libmicrohttpd: %s", not_loaded.text);
    struct sockaddr_in here = { .sin_family = AF_INET, .sin_port = htons((uint16_t)port),
                                .sin_addr.s_addr = htonl(INADDR_LOOPBACK) };
    s->daemon = http.start_daemon(MHD_USE_THREAD_PER_CONNECTION | MHD_USE_INTERNAL_POLLING_THREAD, 0, NULL, NULL, handle, s,
                                 MHD_OPTION_SOCK_ADDR, (struct sockaddr *)&here, MHD_OPTION_CONNECTION_LIMIT, 64u,
                                 MHD_OPTION_CONNECTION_TIMEOUT, 120u, MHD_OPTION_NOTIFY_COMPLETED, done, s, MHD_OPTION_END);
    if (!s->daemon)
        return lw_error_set(e, LW_E_IO, "cannot listen on port %d of 127.0.0.1: %s", port, strerror(errno));
    const union MHD_DaemonInfo *info = http.get_daemon_info(s->daemon, MHD_DAEMON_INFO_BIND_PORT);
    s->port = port ? port : info ? info->port : 0;
    return LW_OK;
}

lw_status studio_start(const studio_options *o, studio **out, lw_error *e)
{
    studio *s = calloc(1, sizeof *s);
    *out = NULL;
    if (!s)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    pthread_mutex_init(&s->lock, NULL);
    pthread_cond_init(&s->news, NULL);
    s->jobs = o->jobs;
    s->file = o->file ? strdup(o->file) : NULL;
    s->text = o->file ? strndup(o->text, o->size) : NULL;
    s->atlas = o->atlas ? strdup(o->atlas) : NULL;
    s->gallery = o->gallery ? strdup(o->gallery) : NULL;
    lw_status st = (o->file && (!s->file || !s->text)) || (o->atlas && !s->atlas) || (o->gallery && !s->gallery)
                 ? lw_error_set(e, LW_E_MEMORY, "out of memory") : LW_OK;
    if (st == LW_OK && o->token)
        snprintf(s->token, sizeof s->token, "%s", o->token);
    else if (st == LW_OK)
        st = make_token(s->token, e);
    if (st == LW_OK)
        st = listen_here(s, o->port, e);
    if (st == LW_OK) {
        studio_atlas_begin(s, o->make_atlas);
        *out = s;
    } else
        studio_stop(s);
    return st;
}

int         studio_port(const studio *s) { return s->port; }
const char *studio_token(const studio *s) { return s->token; }

void studio_stop(studio *s)
{
    if (!s)
        return;
    pthread_mutex_lock(&s->lock);
    s->closing = true;
    pthread_cond_broadcast(&s->news);
    pthread_mutex_unlock(&s->lock);
    if (s->daemon)
        http.stop_daemon(s->daemon);
    studio_searches_end(s);
    studio_atlas_end(s);
    pthread_cond_destroy(&s->news);
    pthread_mutex_destroy(&s->lock);
    free(s->file);
    free(s->text);
    free(s->atlas);
    free(s->gallery);
    free(s);
}
