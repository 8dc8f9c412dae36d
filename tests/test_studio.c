/* test_studio.c - the server of the studio: who may ask, what is refused, what the answers hold. */
#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "studio/studio.h"
#include "tests/check.h"

static studio *server;

/* Send raw bytes, read the whole reply; its status. */
static int ask_raw(const char *bytes, size_t size, char *reply, size_t room)
{
    struct sockaddr_in a = { .sin_family = AF_INET, .sin_port = htons((uint16_t)studio_port(server)),
                             .sin_addr.s_addr = htonl(INADDR_LOOPBACK) };
    int s = socket(AF_INET, SOCK_STREAM, 0), status = 0;
    size_t n = 0;
    struct timeval limit = { 20, 0 };
    setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    reply[0] = 0;
    if (connect(s, (struct sockaddr *)&a, sizeof a) == 0) {
        for (size_t sent = 0; sent < size;) {
            ssize_t k = send(s, bytes + sent, size - sent, MSG_NOSIGNAL);
            if (k <= 0)
                break;
            sent += (size_t)k;
        }
        for (ssize_t k; n + 1 < room && (k = recv(s, reply + n, room - 1 - n, 0)) > 0;)
            n += (size_t)k;
        reply[n] = 0;
        sscanf(reply, "HTTP/1.1 %d", &status);
    }
    close(s);
    return status;
}

static char reply[1 << 20];

/* A request with the right host and more headers; "T" in the address stands for the token. */
static int ask(const char *method, const char *path, const char *headers, const char *body)
{
    static char text[1 << 16];
    char address[512];
    snprintf(address, sizeof address, "%s", path);
    if (strncmp(path, "/T", 2) == 0)
        snprintf(address, sizeof address, "/%s%s", studio_token(server), path + 2);
    int n = snprintf(text, sizeof text, "%s %s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: close\r\n%sContent-Length: %zu\r\n\r\n%s",
                     method, address, studio_port(server), headers, strlen(body), body);
    return ask_raw(text, (size_t)n, reply, sizeof reply);
}

#define JSON "Content-Type: application/json\r\n"
static int question(const char *name, const char *body)
{
    char path[64];
    snprintf(path, sizeof path, "/T/api/%s", name);
    return ask("POST", path, JSON, body);
}

TEST(one_server_a_port)
{
    lw_error e = { 0 };
    studio *second;
    studio_options o = { .port = studio_port(server) };
    CHECK(strlen(studio_token(server)) == STUDIO_TOKEN_SIZE - 1 && o.port > 0);
    CHECK(studio_start(&o, &second, &e) == LW_E_IO);
    CHECK_HAS(e.text, "cannot listen");
    o.port = 0;
    CHECK(studio_start(&o, &second, &e) == LW_OK && strcmp(studio_token(server), studio_token(second)) != 0);
    studio_stop(second);
}

TEST(who_may_ask)
{
    char text[512];
    CHECK(ask("GET", "/T/", "", "") == 200 && strstr(reply, "linkwright studio"));
    CHECK_HAS(reply, "Content-Security-Policy: default-src 'none'; script-src 'self'");
    CHECK(strstr(reply, "Referrer-Policy: no-referrer") && !strstr(reply, "Access-Control-Allow-Origin"));
    CHECK(ask("GET", "/T/main.js", "", "") == 200 && strstr(reply, "text/javascript"));
    CHECK(question("begin", "{}") == 200 && strstr(reply, "\"version\""));
    /* no token, a wrong one, one that is too short */
    CHECK(ask("GET", "/", "", "") == 403);
    CHECK(ask("GET", "/main.js", "", "") == 403);
    CHECK(ask("POST", "/api/begin", JSON, "{}") == 403);
    CHECK(ask("GET", "/00000000000000000000000000000000/", "", "") == 403);
    CHECK(ask("GET", "/0000/", "", "") == 403 && strstr(reply, "token"));
    snprintf(text, sizeof text, "/%.31s%c/", studio_token(server), studio_token(server)[31] == '0' ? '1' : '0');
    CHECK(ask("GET", text, "", "") == 403);
    /* other origins, other hosts (a name that was pointed at this computer) */
    CHECK(ask("POST", "/T/api/begin", JSON "Origin: http://example.com\r\n", "{}") == 403);
    CHECK(ask("POST", "/T/api/begin", JSON "Origin: null\r\n", "{}") == 403);
    CHECK(ask("POST", "/T/api/begin", JSON "Sec-Fetch-Site: cross-site\r\n", "{}") == 403);
    CHECK(ask("GET", "/T/main.js", "Sec-Fetch-Site: cross-site\r\n", "") == 403);
    snprintf(text, sizeof text, JSON "Origin: http://127.0.0.1:%d\r\n", studio_port(server));
    CHECK(ask("POST", "/T/api/begin", text, "{}") == 200);
    snprintf(text, sizeof text, "GET /%s/ HTTP/1.1\r\nHost: evil.example:%d\r\nConnection: close\r\n\r\n", studio_token(server),
             studio_port(server));
    CHECK(ask_raw(text, strlen(text), reply, sizeof reply) == 403);
    /* a form of another page can send neither this type nor read the answer */
    CHECK(ask("POST", "/T/api/begin", "Content-Type: text/plain\r\n", "{}") == 415);
    CHECK(ask("GET", "/T/api/begin", "", "") == 405);
    CHECK(ask("PUT", "/T/main.js", JSON, "{}") == 405);
}

TEST(paths_and_sizes)
{
    static const char *const paths[] = { "/T/../../../../etc/passwd", "/T/..%2f..%2f..%2fetc/passwd", "/T/%2e%2e/etc/passwd",
                                         "/T//etc/passwd", "/T/studio/server.c", "/T/main.js/", "/T/MAIN.JS" };
    for (size_t i = 0; i < sizeof paths/sizeof *paths; i++) {
        int status = ask("GET", paths[i], "", "");
        CHECK(status == 404 || status == 403);
        CHECK(!strstr(reply, "root:"));
    }
    CHECK(question("gallery", "{\"name\": \"../index\"}") == 422 && strstr(reply, "gallery has no"));
    CHECK(question("gallery", "{\"name\": \"../../../README\"}") == 422);
    CHECK(question("search", "{\"task\": {\"linkwright-task\": 1, \"target\": \"/etc/passwd\"}}") == 422);
    CHECK(strstr(reply, "must hold its stations") && !strstr(reply, "root:"));
    /* said to be large, and large without saying so */
    char head[512];
    int n = snprintf(head, sizeof head, "POST /%s/api/motion HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: close\r\n" JSON
                     "Content-Length: 90000000\r\n\r\n{", studio_token(server), studio_port(server));
    CHECK(ask_raw(head, (size_t)n, reply, sizeof reply) == 413);
    size_t large = 9u << 20;
    char *body = malloc(large + 1024);
    n = snprintf(body, 1024, "POST /%s/api/motion HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: close\r\n" JSON
                 "Transfer-Encoding: chunked\r\n\r\n%zx\r\n", studio_token(server), studio_port(server), large);
    memset(body + n, 'x', large);
    memcpy(body + n + large, "\r\n0\r\n\r\n", 7);
    int status = ask_raw(body, (size_t)n + large + 7, reply, sizeof reply);
    CHECK(status == 413);
    free(body);
    /* nonsense */
    CHECK(question("begin", "") == 400);
    CHECK(question("begin", "[1,2") == 400);
    CHECK(question("begin", "{\"a\":1,\"a\":2}") == 400);
    CHECK(question("nothing", "{}") == 404);
    char deep[4096];
    memset(deep, '[', sizeof deep - 1);
    deep[sizeof deep - 1] = 0;
    CHECK(question("motion", deep) == 400);
}

#define FOURBAR "{\"linkwright\":1,\"units\":{\"length\":\"mm\",\"angle\":\"deg\"},\"links\":[\"ground\",\"crank\",\"coupler\",\"rocker\"]," \
    "\"joints\":[{\"name\":\"A\",\"links\":[\"ground\",\"crank\"],\"at\":[0,0]},{\"name\":\"B\",\"links\":[\"crank\",\"coupler\"],\"at\":[0,20]}," \
    "{\"name\":\"C\",\"links\":[\"coupler\",\"rocker\"],\"at\":[60,40]},{\"name\":\"D\",\"links\":[\"ground\",\"rocker\"],\"at\":[50,0]}]," \
    "\"input\":{\"joint\":\"A\"},\"tracers\":[{\"name\":\"P\",\"link\":\"coupler\",\"at\":[30,60]}]}"

TEST(answers)
{
    CHECK(question("motion", "{\"linkage\":" FOURBAR ",\"points\":1000}") == 200);
    CHECK(strstr(reply, "\"mobility\":1") && strstr(reply, "\"loops\":true") && strstr(reply, "\"unit\":\"mm\""));
    CHECK(question("motion", "{\"linkage\":{\"linkwright\":1,\"joints\":[]}}") == 422 && strstr(reply, "\"error\":\""));
    CHECK(question("motion", "{}") == 422 && strstr(reply, "no \\\"linkage\\\""));
    CHECK(question("analyse", "{\"linkage\":" FOURBAR "}") == 200);
    CHECK(strstr(reply, "\"transmission\":[") && strstr(reply, "\"cognates\":[{") && strstr(reply, "\"crank-rocker\""));
    CHECK(question("mobility", "{\"linkage\":" FOURBAR "}") == 200 && strstr(reply, "\"kind\":\"moves\""));
    CHECK(question("assembly", "{\"linkage\":" FOURBAR "}") == 200 && strstr(reply, "\"frames\":1") && !strstr(reply, "null"));
    CHECK(question("assembly", "{}") == 422);
    CHECK(question("motion", "{\"linkage\":[]}") == 422 && strstr(reply, "an object or a text"));
    CHECK(question("open", "{\"name\":\"a.csv\",\"text\":\"x,y\\n0,0\\n1,0\\n1,1\\n\"}") == 200 && strstr(reply, "\"kind\":\"target\""));
    CHECK(question("open", "{\"name\":\"a.csv\",\"text\":\"x,y\\n0,zero\\n\"}") == 422 && strstr(reply, "\"line\":2"));
    CHECK(question("open", "{\"name\":\"a.obj\",\"text\":\"o cube\\nv 0 1 2\\n\"}") == 422 && strstr(reply, "this is a mesh of triangles, not a linkage or a target"));
    char *many = malloc(101*(sizeof FOURBAR + 20) + 100);
    for (int bad = 0; bad < 2 && many; bad++) {                            /* all results of a file, or an error */
        char *end = many + sprintf(many, "{\"name\":\"r.json\",\"text\":{\"results\":[");
        int n = 0;
        for (int i = 0; i < 100; i++)
            end += sprintf(end, "%s{\"linkage\":%s}", i ? "," : "", bad && i == 90 ? "{}" : FOURBAR);
        strcpy(end, "]}}");
        CHECK_INT(question("open", many), bad ? 422 : 200);
        for (const char *at = reply; (at = strstr(at, "\"joints\"")); at++)
            n++;
        CHECK(bad || n == 100);
    }
    free(many);
    CHECK(question("target", "{\"name\":\"d.csv\",\"unit\":\"mm\",\"force_unit\":true,\"stations\":9,\"closed\":true,"
                   "\"text\":\"x,y\\n0,0\\n10,0\\n10,10\\n0,10\\n\"}") == 200 && strstr(reply, "\"closed\":true"));
    CHECK(question("chains", "{\"links\":4}") == 200 && strstr(reply, "\"mechanism\":"));
    CHECK(question("chains", "{\"links\":20}") == 422);
    CHECK(question("export", "{\"format\":\"dxf\",\"linkage\":" FOURBAR "}") == 200 && strstr(reply, "SECTION"));
    CHECK(question("export", "{\"format\":\"../x\",\"linkage\":" FOURBAR "}") == 422);
    CHECK(question("news", "{\"id\":7}") == 422 && question("stop", "{\"id\":7}") == 422);
    CHECK(question("nearest", "{\"x\":[0,1],\"y\":[0,1]}") == 422);
}

/* 201 links: a row of 100 parallelograms.  Its crank turns, rods stay level, and all cranks draw the circle of the first. */
TEST(linkages_of_any_size)
{
    enum { N = 100 };
    char *body = malloc(1 << 16), *row = body + (1 << 15), *end = row;
    end += sprintf(end, "{\"linkwright\":1,\"links\":[\"ground\",\"c0\"");
    for (int i = 1; i <= N; i++)
        end += sprintf(end, ",\"c%d\",{\"name\":\"r%d\",\"mass\":1,\"centre\":[%g,1]}", i, i, i - 0.5);
    end += sprintf(end, "],\"input\":{\"joint\":\"A0\"},\"tracers\":[{\"name\":\"P\",\"link\":\"r%d\",\"at\":[%d,1]}],\"joints\":["
                   "{\"name\":\"A0\",\"links\":[\"ground\",\"c0\"],\"at\":[0,0]}", N, N);
    for (int i = 1; i <= N; i++)
        end += sprintf(end, ",{\"name\":\"A%d\",\"links\":[\"ground\",\"c%d\"],\"at\":[%d,0]},{\"name\":\"B%d\",\"links\":[\"c%d\",\"r%d\"],"
                       "\"at\":[%d,1]},{\"name\":\"C%d\",\"links\":[\"r%d\",\"c%d\"],\"at\":[%d,1]}", i, i, i, i, i - 1, i, i - 1, i, i, i, i);
    strcpy(end, "]}");
    const struct { const char *name, *format, *wanted; } about[] = {
        { "open", "{\"name\":\"row.json\",\"text\":%s}", "\"r100\"" },
        { "motion", "{\"linkage\":%s,\"points\":24,\"frames\":8}", "\"mobility\":1" },
        { "mobility", "{\"linkage\":%s}", "\"kind\":\"moves\",\"count\":1,\"freedom\":1,\"redundant\":0" },
        { "export", "{\"format\":\"svg\",\"linkage\":%s}", "<svg" },
        { "export", "{\"format\":\"mjcf\",\"linkage\":%s}", "<mujoco" },
        { "forces", "{\"speed\":1,\"seconds\":0.1,\"linkage\":%s}", "\"unit\":\"N m\"" },
        { "analyse", "{\"frames\":8,\"linkage\":%s}", "\"ranges\":[]" },
    };
    for (size_t i = 0; i < sizeof about/sizeof *about; i++) {
        FREED char *text = malloc(1 << 16);
        snprintf(text, 1 << 16, about[i].format, row);
        CHECK_INT(question(about[i].name, text), 200);
        CHECK_HAS(reply, about[i].wanted);
        if (strcmp(about[i].name, "motion") == 0)
            CHECK(strstr(reply, "\"loops\":true") && strstr(reply, "\"note\":\"\""));
        if (strcmp(about[i].name, "analyse") == 0) {           /* P runs on a circle of 1 m: velocity and acceleration at the start */
            double v[4] = { 0 };
            const char *at = strstr(reply, "\"name\":\"P\",\"rates\":[");
            CHECK(at && sscanf(strchr(at, '['), "[%lf,%lf,%lf,%lf", &v[0], &v[1], &v[2], &v[3]) == 4);
            CHECK_NEAR(v[0], -1, 1e-9, 0);
            CHECK_NEAR(hypot(v[1], v[2]), 0, 1e-9, 0);
            CHECK_NEAR(v[3], -1, 1e-9, 0);
        }
    }
    free(body);
}

/* A search tells what it finds, and ends when it is asked to. */
TEST(search_ends)
{
    static const char task[] = "{\"task\":{\"linkwright-task\":1,\"units\":{\"length\":\"mm\"},\"closed\":true,\"links\":6,\"stations\":["
        "{\"x\":40,\"y\":0},{\"x\":25,\"y\":22},{\"x\":0,\"y\":25},{\"x\":-20,\"y\":20},{\"x\":-40,\"y\":0},{\"x\":0,\"y\":-5}]},"
        "\"results\":3,\"seed\":2}";
    int id = 0;
    CHECK(question("search", task) == 200);
    CHECK_HAS(reply, "linkwright fit task.json --seed 2 --results 3");
    const char *at = strstr(reply, "\"id\":");
    CHECK(at && sscanf(at, "\"id\":%d", &id) == 1);
    char text[64];
    snprintf(text, sizeof text, "{\"id\":%d,\"after\":0}", id);
    CHECK(question("news", text) == 200);
    while (strstr(reply, "\"best\":null") && strstr(reply, "running"))
        question("news", text);
    snprintf(text, sizeof text, "{\"id\":%d}", id);
    CHECK(question("stop", text) == 200);
    snprintf(text, sizeof text, "{\"id\":%d,\"after\":1000000000}", id);
    do
        CHECK(question("news", text) == 200);
    while (strstr(reply, "\"running\""));
    CHECK_HAS(reply, "\"results\":[{\"title\":");
    CHECK_HAS(reply, "\"verified\":true");
}

CHECK_MAIN
{
    studio_options o = { .file = "a.json", .text = "{}", .size = 2, .gallery = "examples/gallery" };
    lw_error e = { 0 };
    if (studio_start(&o, &server, &e) != LW_OK) {
        fprintf(stderr, "%s\n", e.text);
        return 1;
    }
    check_run();
    studio_stop(server);
    return check_end();
}
