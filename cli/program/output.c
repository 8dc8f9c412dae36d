#include "cli/program/output.h"
#include "cli/program/file_kind.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
#include "base/real.h"

int cli_exit_code(lw_status s)
{
    switch (s) {
    case LW_OK:         return CLI_DONE;
    case LW_NOTHING:    return CLI_NOTHING;
    case LW_STOPPED:    return CLI_LIMIT;
    case LW_OPEN:
    case LW_E_NUMERIC:
    case LW_E_MEMORY:   return CLI_NUMERIC;
    case LW_E_ARG:
    case LW_E_NOTATION:
    case LW_E_IO:
    case LW_E_KIND:     return CLI_BAD_INPUT;
    }
    return CLI_NUMERIC;
}

/* The action among the words of the call; NULL: the command has none. */
static const cli_action *action_of(const cli_call *call)
{
    for (const cli_action *a = call->command->actions; a && a->name && call->parsed.n_word > 0; a++)
        if (strcmp(a->name, call->parsed.word[0]) == 0)
            return a;
    return NULL;
}

/* Kinds of files that the command, or its action, reads. */
static unsigned kinds_read(const cli_call *call)
{
    const cli_action *a = action_of(call);
    return a ? a->reads : call->command->reads;
}

int cli_fail(const cli_call *call, const lw_error *e)
{
    char text[sizeof e->file + sizeof e->text + 64];
    if (e->status == LW_OK) {                    /* no exit code 0 because the failing call filled no message */
        fprintf(stderr, "linkwright %s: the work could not be finished; most likely it ran out of memory\n", call->command->name);
        return CLI_NUMERIC;
    }
    lw_error told = *e;
    if (e->status == LW_E_NOTATION && strncmp(e->text, "this is a", 9) != 0)
        cli_wrong_kind(e->file, kinds_read(call), &told);
    lw_error_print(&told, text, sizeof text);
    fprintf(stderr, "linkwright %s: %s", call->command->name, text);
    if (e->status == LW_E_MEMORY)
        fprintf(stderr, "; the limit is %.3g GB (--memory)", cli_memory(call)/1e9);
    if (e->status == LW_STOPPED && cli_timed_out())
        fputs("; give it longer with --time", stderr);
    fputc('\n', stderr);
    return cli_exit_code(e->status);
}

int cli_usage(const cli_call *call, const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    fprintf(stderr, "linkwright %s: ", call->command->name);
    vfprintf(stderr, format, arg);
    fprintf(stderr, "\nSee 'linkwright help %s'.\n", call->command->name);
    va_end(arg);
    return CLI_USAGE;
}

void cli_note(const cli_call *call, const char *format, ...)
{
    if (call->common.quiet)
        return;
    va_list arg;
    va_start(arg, format);
    fprintf(stderr, "linkwright %s: ", call->command->name);
    vfprintf(stderr, format, arg);
    fputc('\n', stderr);
    va_end(arg);
}

static void say(void *context, const char *text) { cli_note(context, "%s", text); }

lw_note_sink cli_notes(const cli_call *call) { return (lw_note_sink){ (void *)(uintptr_t)call, say }; }

/* The only state that a signal handler changes: the first signal, and when the program is ended by force. */
static volatile sig_atomic_t interrupted;
static double                forced_end;         /* monotonic [s]                                    */

static volatile sig_atomic_t finishing;          /* > 0: a file is committed, the program is not ended by force */
static double                left;               /* what is left of --time meanwhile [s]; 0: no end  */

/* The temporary files of -o and, after it, of pictures, which a forced end removes; "" for none. */
enum { TEMPORARY_MAX = 8 };
static char temporary[TEMPORARY_MAX][sizeof ((lw_output *)0)->temp];
static char partial_name[LW_PATH_SIZE + 16];     /* what the first becomes then, as far as it is written */

/* ---- an output that fails ends the work ------------------------------------------------------------ */

/* The output is written through a stream that notices the first failure. A command may work for hours between two looks at
 * ferror, and all that time for nothing. Lines are held to be written together, but for HELD seconds at most, so that rows that
 * take long are written, and fail, one by one. */
#define HELD 0.1
static struct { FILE *shown, *real; double last; size_t n; char held[8192]; } watched;

static void end_after_failed_write(void);

static bool write_held(FILE *real, const char *data, size_t n)
{
    bool done = fwrite(watched.held, 1, watched.n, real) == watched.n && (n == 0 || fwrite(data, 1, n, real) == n);
    watched.n = 0;
    if (!done)
        end_after_failed_write();
    return done;
}

static double now_of(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9*(double)t.tv_nsec;
}

static ssize_t pass_on(void *real, const char *data, size_t n)
{
    double now = now_of(CLOCK_MONOTONIC_COARSE);
    if (watched.n + n > sizeof watched.held || now - watched.last > HELD) {
        watched.last = now;
        return write_held(real, data, n) ? (ssize_t)n : 0;
    }
    memcpy(watched.held + watched.n, data, n);
    watched.n += n;
    return (ssize_t)n;
}

static int close_real(void *real)
{
    write_held(real, NULL, 0);
    FILE *f = watched.real ? real : NULL;        /* NULL: unwatch keeps it open */
    watched.shown = watched.real = NULL;
    return f ? fclose(f) : 0;
}

static void watch(lw_output *o)
{
    FILE *f = watched.shown || isatty(fileno(o->f)) ? NULL
            : fopencookie(o->f, "wb", (cookie_io_functions_t){ .write = pass_on, .close = close_real });
    if (!f)
        return;                                  /* a terminal shows each line at once, and takes all */
    setvbuf(o->f, NULL, _IONBF, 0);
    setvbuf(f, NULL, _IOLBF, sizeof watched.held);
    watched.last = 0;
    watched.real = o->f;
    o->f = watched.shown = f;
}

/* Give o its own stream back, which knows whether a write has failed. */
static void unwatch(lw_output *o)
{
    if (!o->f || o->f != watched.shown)
        return;
    FILE *real = watched.real;
    watched.real = NULL;
    fclose(o->f);
    o->f = real;
}

static lw_status open_path(const char *path, lw_output *o, lw_error *e)
{
    lw_output_clean(path);
    lw_status s = lw_output_open(o, path, e);
    if (s == LW_OK) {
        watch(o);
        snprintf(partial_name, sizeof partial_name, "%s.partial", o->path);
        strcpy(temporary[0], o->temp);
    }
    return s;
}

static const char *option_text(const cli_call *call, int i)
{
    return *(const char *const *)((const char *)call->settings + call->command->options[i].place);
}

void cli_csv_field(FILE *f, const char *text, size_t n)
{
    bool quoted = false;
    for (size_t i = 0; i < n; i++)
        quoted = quoted || strchr(",\"\r\n", text[i]);
    if (quoted)
        fputc('"', f);
    for (size_t i = 0; i < n; i++) {
        if (text[i] == '"')
            fputc('"', f);
        fputc(text[i], f);
    }
    if (quoted)
        fputc('"', f);
}

void cli_csv_text(FILE *f, const char *text) { cli_csv_field(f, text, strlen(text)); }

lw_status cli_open(const cli_call *call, lw_output *o, lw_error *e)
{
    bool picture = false;
    for (int i = 0; call->command->options && call->command->options[i].name; i++) {
        cli_kind kind = call->command->options[i].kind;
        picture = picture || ((kind == CLI_PLOT || kind == CLI_GIF) && option_text(call, i));
    }
    return open_path(call->common.output ? call->common.output : picture && !call->common.json ? "/dev/null" : "-", o, e);
}

/* Have SIGALRM sent after so many seconds; 0: never.  Returns what was left until then; 0: it was not asked for.  A timer of
 * timer_create would need a queued signal, which the system may refuse. */
static double set_timer(double seconds)
{
    struct itimerval t = { .it_value = { (time_t)seconds, (suseconds_t)(1e6*(seconds - floor(seconds))) } }, before = { 0 };
    setitimer(ITIMER_REAL, &t, &before);
    return (double)before.it_value.tv_sec + 1e-6*(double)before.it_value.tv_usec;
}

void cli_hold(void)
{
    if (finishing++ == 0)
        left = set_timer(0);
}

void cli_go_on(void)
{
    if (--finishing > 0)
        return;
    if (interrupted)
        set_timer(fmax(1e-6, forced_end - now_of(CLOCK_MONOTONIC)));
    else if (left > 0)
        set_timer(left);
}

/* Commit the file: nothing ends the program by force meanwhile. */
static lw_status commit(lw_output *o, bool partial, lw_error *e)
{
    bool file = temporary[0][0];                 /* a pipe that nobody reads may hold the program up */
    if (file)
        cli_hold();
    unwatch(o);
    lw_status s = (partial ? lw_output_commit_partial : lw_output_commit)(o, e);
    if (file) {
        temporary[0][0] = 0;
        cli_go_on();
    }
    return s;
}

static bool lost;

void cli_lost(void) { lost = true; }

static int close_lost(lw_output *o, int code)
{
    lw_output_abandon(o);
    if (code <= CLI_NOTHING)
        fputs("linkwright: out of memory; the output is not whole\n", stderr);
    return cli_end_code(code);
}

int cli_close(const cli_call *call, lw_output *o, int code)
{
    lw_error e = { 0 };
    if (lost)
        return close_lost(o, code);
    unwatch(o);
    code = cli_end_code(code);
    bool partial = o->temp[0] && code != CLI_DONE && code != CLI_NOTHING && !ferror(o->f);     /* else the error names the file */
    if (partial && !o->partial && ftello(o->f) == 0) {
        lw_output_abandon(o);
        return code;
    }
    if (commit(o, partial, &e) != LW_OK)
        return cli_fail(call, &e);
    if (partial)
        fprintf(stderr, "linkwright %s: stopped before the end: what was found is in %s.partial\n", call->command->name, o->path);
    return code;
}

int cli_close_marked(const cli_call *call, lw_output *o, int code)
{
    lw_error e = { 0 };
    if (lost)
        return close_lost(o, code);
    return commit(o, false, &e) == LW_OK ? cli_end_code(code) : cli_fail(call, &e);
}

const char *cli_picture_path(const cli_call *call, const char *path, int code, char partial[LW_PATH_SIZE + 16])
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    struct stat st;
    if (code == CLI_DONE)
        return path;
    if (!dot || (slash && dot < slash))
        dot = path + strlen(path);
    snprintf(partial, LW_PATH_SIZE + 16, "%.*s.partial%s", (int)(dot - path), path, dot);
    if (lstat(partial, &st) == 0 && !(S_ISREG(st.st_mode) && lw_file_is_own(partial))) {
        fprintf(stderr, "linkwright %s: what was found is not written: %s exists, and linkwright did not write it\n",
                call->command->name, partial);
        return NULL;
    }
    fprintf(stderr, "linkwright %s: what was found goes to %s\n", call->command->name, partial);
    return partial;
}

/* ---- nothing of the user is overwritten ---------------------------------------------------------- */

static bool is_file(const char *path, struct stat *st)
{
    return path && strcmp(path, "-") != 0 && stat(path, st) == 0 && S_ISREG(st->st_mode);
}

static bool is_same(const struct stat *a, const struct stat *b)
{
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

/* Is the input `path`, or in drawing.svg#curve the part before '#', the file `st`? */
static bool is_input(const char *path, const struct stat *st)
{
    struct stat input;
    char file[PATH_MAX];
    const char *hash = path ? strrchr(path, '#') : NULL;
    if (is_file(path, &input))
        return is_same(&input, st);
    if (!hash || snprintf(file, sizeof file, "%.*s", (int)(hash - path), path) >= PATH_MAX)
        return false;
    return is_file(file, &input) && is_same(&input, st);
}

static char **named;                   /* files that are named inside the inputs */
static int n_named;

/* Copies the path. */
static lw_status add_name(const char *path, lw_error *e)
{
    char *copy = strdup(path), **more = realloc(named, sizeof *named*((size_t)n_named + 1));
    named = more ? more : named;
    if (!copy || !more) {
        free(copy);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    named[n_named++] = copy;
    return LW_OK;
}

int cli_add_input(const cli_call *call, const char *path)
{
    lw_error e = { 0 };
    return add_name(path, &e) == LW_OK ? cli_check_outputs(call) : cli_fail(call, &e);
}

/* The input of this run that is the same file as `st`, as the user wrote it; NULL if none is. */
static const char *input_that_is(const cli_call *call, const struct stat *st)
{
    struct stat input;
    const cli_option *o = call->command->options;
    for (int i = 0; i < call->parsed.n_word; i++)
        if (is_input(call->parsed.word[i], st))
            return call->parsed.word[i];
    for (int i = 0; o && o[i].name; i++)
        if ((o[i].kind == CLI_INPUT || o[i].kind == CLI_STORE) && is_input(option_text(call, i), st))
            return option_text(call, i);
    for (int i = 0; i < n_named; i++)
        if (is_input(named[i], st))
            return named[i];
    return fstat(STDIN_FILENO, &input) == 0 && is_same(&input, st) ? "standard input" : NULL;
}

int cli_may_write(const cli_call *call, const char *path)
{
    struct stat st;
    if (!is_file(path, &st))
        return CLI_DONE;
    const char *input = input_that_is(call, &st);
    if (input)
        return cli_usage(call, "%s is an input of this command (%s) and is not overwritten; name another file", path, input);
    if (st.st_size > 0 && !call->common.force && !lw_file_is_own(path))
        return cli_usage(call, "%s exists, and linkwright did not write it or it was changed since; name another file, "
                         "or replace it with --force", path);
    return CLI_DONE;
}

static bool is_too_long(const char *path)
{
    struct stat st;
    return lstat(path, &st) != 0 && errno == ENAMETOOLONG;
}

/* A run that is stopped writes `path`.partial: the name may not be too long, and no file of the user may have it. */
static int may_write_partial(const cli_call *call, const char *path)
{
    char partial[LW_PATH_SIZE + 16];
    struct stat st;
    snprintf(partial, sizeof partial, "%s.partial", path);
    bool device = strcmp(path, "-") == 0 || (stat(path, &st) == 0 && !S_ISREG(st.st_mode));
    if (!device && is_too_long(partial))
        return cli_usage(call, "%.80s...: the name is too long, because a run that is stopped adds .partial to it; choose a "
                         "shorter one", path);
    if (device || path != call->common.output || lstat(partial, &st) != 0
        || (S_ISREG(st.st_mode) && (st.st_size == 0 || lw_file_is_own(partial))))
        return CLI_DONE;
    bool resumes = false;
    for (const cli_option *o = call->command->options; o && o->name; o++)
        resumes = resumes || strcmp(o->name, "resume") == 0;
    return cli_usage(call, "%s exists, and linkwright did not finish it; a run that is stopped would replace it. Rename or "
                     "remove it%s", partial, resumes ? ", or continue it by --resume" : "");
}

/* Do two paths name the same file, which may not exist yet? */
static bool same_place(const char *a, const char *b)
{
    char folder[2][LW_PATH_SIZE], real[2][PATH_MAX];
    const char *path[2] = { a, b }, *name[2];
    struct stat st[2];
    bool there[2] = { stat(a, &st[0]) == 0, stat(b, &st[1]) == 0 };
    if (there[0] || there[1])
        return there[0] && there[1] && S_ISREG(st[0].st_mode) && is_same(&st[0], &st[1]);
    for (int i = 0; i < 2; i++) {
        const char *slash = strrchr(path[i], '/');
        snprintf(folder[i], LW_PATH_SIZE, "%.*s", slash ? (int)(slash - path[i]) + 1 : 1, slash ? path[i] : ".");
        name[i] = slash ? slash + 1 : path[i];
        if (!realpath(folder[i], real[i]))
            return false;
    }
    return strcmp(name[0], name[1]) == 0 && strcmp(real[0], real[1]) == 0;
}

int cli_may_write_in(const cli_call *call, const char *folder, const char *format, ...)
{
    char path[CLI_PATH_SIZE];
    size_t n = (size_t)snprintf(path, sizeof path, "%s/", folder);
    va_list arg;
    va_start(arg, format);
    if (n < sizeof path)
        n += (size_t)vsnprintf(path + n, sizeof path - n, format, arg);
    va_end(arg);
    if (n >= LW_PATH_SIZE || is_too_long(path))
        return cli_usage(call, "%.80s: the names of files in this folder become too long; choose a shorter one", folder);
    if (call->common.output && same_place(path, call->common.output))
        return cli_usage(call, "-o %s is also one of the files that go into the folder %s; name another file", call->common.output, folder);
    return cli_may_write(call, path);
}

/* Abandon a file; the next one of its folder has the same temporary name, which a forced end removes. */
static void forget_temporary(lw_output *o)
{
    for (int i = 1; i < TEMPORARY_MAX; i++)
        if (!temporary[i][0]) {
            strcpy(temporary[i], o->temp);
            break;
        }
    lw_output_abandon(o);
}

/* Check that a file written at the end of a long run can be written. The file of -o is opened by the command itself. */
static int try_output(const cli_call *call, const char *path)
{
    struct stat st;
    lw_output o;
    lw_error e = { 0 };
    if (stat(path, &st) == 0 && !S_ISREG(st.st_mode))
        return CLI_DONE;
    lw_output_clean(path);
    if (lw_output_open(&o, path, &e) != LW_OK)
        return cli_fail(call, &e);
    forget_temporary(&o);
    return CLI_DONE;
}

bool cli_ends_in(const char *path, const char *words)
{
    const char *dot = path ? strrchr(path, '.') : NULL;
    for (size_t n; dot && *words; words += n + (words[n] == ' '))
        if (n = strcspn(words, " "), strlen(dot + 1) == n && strncasecmp(dot + 1, words, n) == 0)
            return true;
    return false;
}

/* A name whose end promises another kind of file than the one that would be written is refused before the work. */
static int check_ends(const cli_call *call)
{
    const cli_option *o = call->command->options;
    const char *path = call->common.output, *plot = NULL;
    for (int i = 0; o && o[i].name; i++) {
        bool still = o[i].kind == CLI_PLOT, moves = o[i].kind == CLI_GIF;
        const char *file = still || moves ? option_text(call, i) : NULL;
        if (file && !cli_ends_in(file, still ? "svg pdf png" : "gif"))
            return cli_usage(call, "--%s %s: the name does not say what kind of picture it is to be; end it in %s", o[i].name,
                             file, still ? ".svg, .pdf or .png" : ".gif");
        plot = plot ? plot : still ? "plot FILE" : strcmp(o[i].name, "save") == 0 ? "save FOLDER" : NULL;
    }
    if (!path || call->command->pictures)
        return CLI_DONE;
    if (cli_ends_in(path, "svg pdf png gif html htm jpg jpeg bmp tif tiff webp eps ps dxf stl step stp"))
        return cli_usage(call, "-o %s: this command writes data to -o, no pictures; %s%s%s", path, plot ? "--" : "see 'linkwright "
                         "help draw' or 'linkwright help convert'", plot ? plot : "", plot ? " draws them" : "");
    if (cli_given(&call->parsed, "json") && cli_ends_in(path, "csv"))
        return cli_usage(call, "-o %s: --json writes JSON; end the name in .json, or leave out --json", path);
    const cli_action *a = action_of(call);
    const char *writes = a && a->writes ? a->writes : call->command->writes;
    if (writes && cli_ends_in(path, *writes == 'J' ? "csv tsv txt" : "csv tsv"))
        return cli_usage(call, "-o %s: this command writes %s; end the name in .json%s", path, writes,
                         *writes == 'J' ? "" : " for JSON, or in .txt");
    return CLI_DONE;
}

static const char *outputs[CLI_OPTION_MAX + 1];          /* of this run, for cli_name_input */
static int n_output;

int cli_check_outputs(const cli_call *call)
{
    const cli_option *o = call->command->options;
    const char **path = outputs;
    int n = 0, code = CLI_DONE;
    if (call->common.output)
        path[n++] = call->common.output;
    for (int i = 0; o && o[i].name; i++)
        if ((o[i].kind == CLI_OUTPUT || o[i].kind == CLI_PLOT || o[i].kind == CLI_GIF || o[i].kind == CLI_STORE) && option_text(call, i)
            && !(o[i].kind == CLI_STORE && access(option_text(call, i), F_OK) == 0))
            path[n++] = option_text(call, i);
    n_output = n;
    for (int i = 0; i < n && code == CLI_DONE; i++) {
        for (int k = 0; k < i; k++)
            if (strcmp(path[i], "-") != 0 && same_place(path[i], path[k]))
                return cli_usage(call, "%s and %s are one file, and both are written; name two", path[k], path[i]);
        bool continued = cli_given(&call->parsed, "resume");         /* keep the listing so far */
        code = continued ? CLI_DONE : cli_may_write(call, path[i]);
        if (code == CLI_DONE && !continued)
            code = may_write_partial(call, path[i]);
        if (code == CLI_DONE && !continued && path[i] != call->common.output)
            code = try_output(call, path[i]);
    }
    return code == CLI_DONE ? check_ends(call) : code;
}

lw_status cli_name_input(const char *path, lw_error *e)
{
    struct stat st;
    for (int i = 0; i < n_output; i++)
        if (is_file(outputs[i], &st) && is_input(path, &st))
            return lw_error_set(e, LW_E_ARG, "%.200s is an input of this command and is not overwritten; name another file", outputs[i]);
    return add_name(path, e);
}

/* A folder that this command made, and those it made before. */
typedef struct made_folder { struct made_folder *before; char path[]; } made_folder;
static made_folder *last_made;

static void keep_made(const char *path)
{
    size_t size = strlen(path) + 1;
    made_folder *made = malloc(sizeof *made + size);
    if (!made)
        return;                                  /* it stays if the command fails */
    made->before = last_made;
    memcpy(made->path, path, size);
    last_made = made;
}

void cli_end_folders(int code)
{
    for (made_folder *before; last_made; last_made = before) {
        before = last_made->before;
        if (code != CLI_DONE)
            rmdir(last_made->path);
        free(last_made);
    }
}

int cli_make_folder(const cli_call *call, const char *folder)
{
    char path[LW_PATH_SIZE];
    lw_error e = { 0 };
    int error = strlen(folder) < sizeof path ? 0 : ENAMETOOLONG;
    snprintf(path, sizeof path, "%s", folder);
    for (char *at = path + 1; !error; at++) {
        char end = *at;
        if (end && end != '/')
            continue;
        *at = 0;
        error = mkdir(path, 0777) == 0 ? 0 : errno;
        if (error == 0)
            keep_made(path);
        error = error == EEXIST ? 0 : error;
        *at = end;
        if (!end)
            break;
    }
    struct stat st;
    if (!error && (stat(folder, &st) != 0 || !S_ISDIR(st.st_mode)))
        error = ENOTDIR;
    if (!error && access(folder, W_OK | X_OK) != 0)
        error = errno;
    if (!error) {
        char any[LW_PATH_SIZE + 2];
        lw_output o;
        snprintf(any, sizeof any, "%s/x", folder);
        lw_output_clean(any);
        if (lw_output_open(&o, any, NULL) == LW_OK)
            forget_temporary(&o);
        return CLI_DONE;
    }
    lw_file_failed(&e, "made or written", folder, error);
    return cli_fail(call, &e);
}

/* ---- the end: Ctrl-C, signals and --time ---------------------------------------------------------- */

#define GRACE 0.8             /* [s] how long a command may take to stop in order                    */

/* The number of the first signal if it is none: the output cannot be written, as a program that gets SIGPIPE. */
#define WRITE_FAILED SIGPIPE

/* A phase that does not look at the flag, for example one inside a foreign library, is ended by force. */
static void end_now(void)
{
    static const char stopped[] = "linkwright: stopped; what was begun is lost, what was written before is kept\n",
                      failed[] = "linkwright: the output cannot be written\n";
    bool wrote = interrupted != WRITE_FAILED;
    if (write(STDERR_FILENO, wrote ? stopped : failed, wrote ? sizeof stopped - 1 : sizeof failed - 1) < 0)
        errno = 0;
    for (int i = 0; i < TEMPORARY_MAX; i++)
        if (temporary[i][0] && !(i == 0 && lw_output_keep(temporary[0], partial_name)))
            unlink(temporary[i]);
    _exit(cli_end_code(CLI_DONE));
}

/* Set the flag, end standard input, and give the command the time to stop in order. */
static void begin_end(int number)
{
    int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
    forced_end = now_of(CLOCK_MONOTONIC) + GRACE;
    interrupted = number;
    if (nothing >= 0) {
        dup2(nothing, STDIN_FILENO);             /* a waiting read is restarted and meets the end */
        close(nothing);
    }
    if (!finishing)
        set_timer(GRACE);
}

static void end_after_failed_write(void)
{
    int was = errno;
    if (interrupted == 0)
        begin_end(WRITE_FAILED);
    errno = was;
}

static void on_signal(int number)
{
    int was = errno;
    if (interrupted == 0) {
        begin_end(number);
        if (number != SIGALRM)
            signal(number, SIG_DFL);
    } else if (number == SIGALRM && !finishing) {
        end_now();
    }
    errno = was;
}

void cli_watch_signals(void)
{
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    if (signal(SIGHUP, on_signal) == SIG_IGN)
        signal(SIGHUP, SIG_IGN);                 /* nohup */
    signal(SIGALRM, on_signal);
    signal(SIGXFSZ, SIG_IGN);                    /* a file beyond the limit of the shell: the write fails */
}

void cli_limit_time(double seconds)
{
    static bool limited;
    if (seconds > 0 && !limited)
        set_timer(fmax(1e-6, seconds));
    limited = limited || seconds > 0;
}

const volatile sig_atomic_t *cli_stop_flag(void)
{
    return &interrupted;
}

const char *cli_stop_text(lw_stop s)
{
    int number = interrupted;
    return s != LW_STOP_USER || number == 0 ? lw_stop_text(s) : number == WRITE_FAILED ? "an output that cannot be written"
         : number == SIGALRM ? lw_stop_text(LW_STOP_TIME)
         : number == SIGINT ? "signal SIGINT (Ctrl-C)" : number == SIGTERM ? "signal SIGTERM" : "signal SIGHUP";
}

int cli_end_code(int code)
{
    int number = interrupted;
    if (lost && code <= CLI_NOTHING)
        code = CLI_NUMERIC;
    if (number == SIGALRM)
        return code == CLI_DONE || code == CLI_NOTHING ? CLI_LIMIT : code;
    if (number == WRITE_FAILED)
        return code == CLI_DONE || code == CLI_NOTHING || code == CLI_LIMIT ? CLI_BAD_INPUT : code;
    return number ? 128 + number : code;
}

/* ---- memory ------------------------------------------------------------------------------------------ */

/* The limit of this process' control group, or infinity. */
static double group_memory(void)
{
    double limit = INFINITY;
    FILE *f = fopen("/sys/fs/cgroup/memory.max", "r");
    if (f && fscanf(f, "%lf", &limit) != 1)
        limit = INFINITY;
    if (f)
        fclose(f);
    return limit;
}

double cli_memory(const cli_call *call)
{
    double machine = (double)sysconf(_SC_PHYS_PAGES)*(double)sysconf(_SC_PAGESIZE);
    return call->common.memory > 0 ? 1e9*call->common.memory : 0.75*fmin(machine, group_memory());
}

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
#define RESERVES true                            /* sanitizers reserve terabytes: no limit holds           */
#else
#define RESERVES false
#endif

void cli_limit_memory(const cli_call *call)
{
    struct rlimit r;
    double most = cli_memory(call);
    if (!RESERVES && getrlimit(RLIMIT_DATA, &r) == 0 && (r.rlim_cur == RLIM_INFINITY || most < (double)r.rlim_cur)) {
        r.rlim_cur = (rlim_t)most;
        setrlimit(RLIMIT_DATA, &r);
    }
}

/* ---- input ---------------------------------------------------------------------------------------- */

void cli_say_waiting(const char *what)
{
    if (isatty(STDIN_FILENO))
        fprintf(stderr, "linkwright: waiting for %s on standard input; end it with Ctrl-D, or name a file instead\n", what);
}

lw_status cli_read_file(const char *path, const char *what, char **text, size_t *size, lw_error *e)
{
    bool standard = strcmp(path, "-") == 0;
    if (standard)
        cli_say_waiting(what);
    lw_status s = lw_file_read(path, text, size, e);
    if (s != LW_OK || !standard || !cli_interrupted())
        return s;
    free(*text);
    *text = NULL;
    return lw_error_at(e, LW_STOPPED, path, 0, 0, "interrupted while it was read");
}
