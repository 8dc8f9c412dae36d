/* linkwright studio - the page where one draws a path, searches and drags linkages. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "cli/program/data.h"
#include "cli/program/output.h"
#include "studio/studio.h"

typedef struct settings {
    int         port;
    bool        no_browser;
    const char *atlas;
} settings;

static const cli_option options[] = {
    { "port", 0, CLI_INT, offsetof(settings, port), "N", "0",
      "port on 127.0.0.1; 0: that of the last time if it is free, else any free one", 0, 65535, NULL, NULL },
    { "no-browser", 0, CLI_FLAG, offsetof(settings, no_browser), NULL, NULL, "print the address and open no browser", 0, 0, NULL, NULL },
    { "atlas", 0, CLI_INPUT, offsetof(settings, atlas), "FILE", NULL,
      "catalogue with the coupler curves that appear while you draw ('linkwright help catalogue curves'); without it one "
      "is made once, in some seconds, in the user's cache folder", 0, 0, NULL, NULL },
    { .name = NULL }
};

/* ---- where things are kept --------------------------------------------------------------------------------------- */

/* FOLDER/linkwright/NAME below an XDG folder, which is made; false: there is none. */
static bool own_file(const char *variable, const char *otherwise, const char *name, char path[LW_PATH_SIZE])
{
    char folder[LW_PATH_SIZE - 64];
    const char *base = getenv(variable), *home = getenv("HOME");
    if (base && base[0] == '/')
        snprintf(folder, sizeof folder, "%s/linkwright", base);
    else if (home && home[0] == '/')
        snprintf(folder, sizeof folder, "%s/%s/linkwright", home, otherwise);
    else
        return false;
    for (char *slash = strchr(folder + 1, '/'); ; slash = strchr(slash + 1, '/')) {
        if (slash)
            *slash = 0;
        if (mkdir(folder, 0700) != 0 && errno != EEXIST)
            return false;
        if (!slash)
            break;
        *slash = '/';
    }
    return snprintf(path, LW_PATH_SIZE, "%s/%s", folder, name) < LW_PATH_SIZE;
}

/* Port and token of the last run, so that its pages find the new one.  The file is the user's alone. */
static void recall(const char *path, int *port, char token[STUDIO_TOKEN_SIZE])
{
    struct stat info;
    char text[64] = "";
    FILE *f = fopen(path, "r");
    token[0] = 0;
    *port = 0;
    if (!f)
        return;
    if (fstat(fileno(f), &info) == 0 && info.st_uid == getuid() && (info.st_mode & 077) == 0
        && fgets(text, sizeof text, f) && sscanf(text, "%d %32[0-9a-f]", port, token) == 2
        && (strlen(token) != STUDIO_TOKEN_SIZE - 1 || *port < 1024 || *port > 65535))
        token[0] = 0;
    if (!token[0])
        *port = 0;
    fclose(f);
}

static void remember(const char *path, const studio *s)
{
    char temporary[LW_PATH_SIZE + 8];
    snprintf(temporary, sizeof temporary, "%s.new", path);
    unlink(temporary);
    mode_t mask = umask(077);
    FILE *f = fopen(temporary, "wx");
    umask(mask);
    if (!f)
        return;
    fprintf(f, "%d %s\n", studio_port(s), studio_token(s));
    if (fclose(f) != 0 || rename(temporary, path) != 0)
        unlink(temporary);
}

/* ---- the run ------------------------------------------------------------------------------------------------------ */

static void open_browser(const char *address)
{
    pid_t child = fork();
    if (child == 0) {
        if (fork() == 0) {                       /* the grandchild belongs to nobody who waits */
            setsid();
            if (freopen("/dev/null", "r", stdin) && freopen("/dev/null", "w", stdout) && freopen("/dev/null", "w", stderr))
                execlp("xdg-open", "xdg-open", address, (char *)NULL);
            _exit(1);
        }
        _exit(0);
    }
    if (child > 0)
        waitpid(child, NULL, 0);
}

/* Start at the port that is asked for; without one at that of the last run, else at any. */
static lw_status start(const settings *s, studio_options *o, const char *kept, studio **out, lw_error *e)
{
    char token[STUDIO_TOKEN_SIZE];
    int port;
    recall(kept, &port, token);
    o->port = s->port ? s->port : port;
    o->token = token[0] && o->port == port ? token : NULL;
    lw_status st = studio_start(o, out, e);
    if (st == LW_E_IO && s->port == 0 && o->port != 0) {
        o->port = 0;
        o->token = NULL;
        st = studio_start(o, out, e);
    }
    return st;
}

static int serve(const cli_call *call, const settings *s, studio_options *o)
{
    char kept[LW_PATH_SIZE] = "", address[128];
    studio *server;
    lw_error e = { 0 };
    bool keeps = own_file("XDG_STATE_HOME", ".local/state", "studio", kept);
    lw_status st = start(s, o, kept, &server, &e);
    if (st != LW_OK)
        return cli_fail(call, &e);
    if (keeps)
        remember(kept, server);
    snprintf(address, sizeof address, "http://127.0.0.1:%d/%s/", studio_port(server), studio_token(server));
    printf(call->common.json ? "{\"address\": \"%s\"}\n" : "%s\n", address);
    if (fflush(stdout) != 0) {                   /* nobody would know where it is */
        studio_stop(server);
        lw_file_failed(&e, "written", "-", errno);
        return cli_fail(call, &e);
    }
    cli_note(call, "the studio is at the address above; Ctrl-C ends it");
    if (!s->no_browser)
        open_browser(address);
    while (!cli_interrupted())
        pause();
    studio_stop(server);
    return CLI_DONE;
}

static int run(const cli_call *call)
{
    const settings *s = call->settings;
    char atlas[LW_PATH_SIZE], documents[LW_PATH_SIZE], gallery[LW_PATH_SIZE + 32], *text = NULL;
    studio_options o = { .jobs = call->common.jobs };
    lw_error e = { 0 };
    if (call->common.output)
        return cli_usage(call, "-o does not go with studio: it prints its address, and the page saves files");
    if (call->parsed.n_word > 0) {
        const char *slash = strrchr(call->parsed.word[0], '/');
        if (lw_file_read(call->parsed.word[0], &text, &o.size, &e) != LW_OK)
            return cli_fail(call, &e);
        o.file = slash ? slash + 1 : call->parsed.word[0];
        o.text = text;
    }
    cli_document_folder(documents, sizeof documents);
    snprintf(gallery, sizeof gallery, "%s/examples/gallery", documents);
    o.gallery = gallery;
    if (s->atlas && access(s->atlas, R_OK) != 0) {
        free(text);
        lw_file_failed(&e, "read", s->atlas, errno);
        return cli_fail(call, &e);
    }
    o.make_atlas = !s->atlas && own_file("XDG_CACHE_HOME", ".cache", "studio-curves-1.db", atlas);
    o.atlas = s->atlas ? s->atlas : o.make_atlas ? atlas : NULL;
    int code = serve(call, s, &o);
    free(text);
    return code;
}

const cli_command cli_studio_command = {
    "studio", "[FILE]", "a page in the browser: draw a path, search, drag linkages",
    "  linkwright studio\n"
    "  linkwright studio examples/jansen.json       # drag its joints and watch the curve\n"
    "  linkwright studio examples/walking-foot.csv  # a path to find linkages for\n"
    "  linkwright studio --no-browser --port 8765   # print the address\n",
    "Serves a page on this computer alone (127.0.0.1), at an address with a random token, and opens it in the browser.\n"
    "FILE is a linkage, results of fit, a target (CSV, SVG, DXF), a task, or a file that the page saved. The page draws\n"
    "paths, searches linkages, drags them, shows velocities, centres and forces, and writes all formats (docs/studio.md).\n"
    "The address is printed on standard output. The server ends with Ctrl-C or --time. If it is started again, its pages go\n"
    "on where they were.\n",
    options, sizeof(settings), NULL, 0, 1, run,
    CLI_LINKAGE | CLI_RESULTS | CLI_TARGET | CLI_DRAWING | CLI_TASK | CLI_FOREIGN, false, NULL
};
