/* linkwright - planar mechanism synthesis.  main.c: finds the command, reads its options, runs it. */
#include <fcntl.h>
#include <locale.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/suggest.h"
#include "cli/program/data.h"
#include "cli/program/output.h"

static const cli_command *const commands[] = { &cli_fit_command, &cli_classify_command, &cli_trace_command,
                                              &cli_simulate_command,
                                              &cli_mobility_command, &cli_plasma_command, &cli_convert_command,
                                              &cli_draw_command, &cli_gallery_command, &cli_clearance_command, &cli_profile_command,
                                              &cli_robot_command, &cli_drive_command, &cli_family_command,
                                              &cli_numbers_command,
                                              &cli_structures_command, &cli_chains_command,
                                              &cli_mechanisms_command, &cli_grammar_command,
                                              &cli_catalogue_command, &cli_studio_command,
                                              &cli_bench_command };

#define N_COMMAND ((int)(sizeof commands/sizeof *commands))

static const cli_command *find(const char *name)
{
    for (int i = 0; i < N_COMMAND; i++)
        if (strcmp(commands[i]->name, name) == 0)
            return commands[i];
    return NULL;
}

static void overview(FILE *f)
{
    char documents[1024];
    cli_document_folder(documents, sizeof documents);
    fputs("linkwright - design linkages for a wanted motion, and analyse how linkages move\n\n"
          "Usage:  linkwright COMMAND [words] [options]\n\n", f);
    for (int i = 0; i < N_COMMAND; i++)
        fprintf(f, "  %-11s %s\n", commands[i]->name, commands[i]->title);
    fputs("\n  help COMMAND [ACTION]     examples and all options of a command; COMMAND --help is the same\n"
          "  --version, -V             version\n\n"
          "Data goes to standard output (or -o FILE), messages to standard error.\n"
          "An input is never overwritten, and a file that linkwright did not write only with --force.\n"
          "Exit codes: 0 done, 1 nothing found, 2 wrong usage, 3 bad input, 4 numerical failure,\n"
          "5 stopped by a limit with partial results kept, 129 SIGHUP, 130 Ctrl-C, 143 SIGTERM.\n", f);
    fprintf(f, "The files docs/... and examples/... are in %s.\n", documents);
}

static const cli_action *find_action(const cli_command *c, const char *name)
{
    for (const cli_action *a = c->actions; a && a->name; a++)
        if (strcmp(a->name, name) == 0)
            return a;
    return NULL;
}

/* Does a clause of the help text, or the first one, begin with this action, as in "build, check: number of links; html: ..."? */
static bool names_action(const char *help, const char *action, bool first)
{
    size_t n = strlen(action);
    for (const char *clause = help, *next; clause; clause = next && !first ? next + 2 : NULL) {
        size_t head = strspn(clause, "abcdefghijklmnopqrstuvwxyz, ");
        next = strstr(clause, "; ");
        for (const char *at = clause; clause[head] == ':' && (at = strstr(at, action)) && at < clause + head; at++)
            if ((at == clause || at[-1] == ' ') && (at[n] == ',' || at[n] == ':'))
                return true;
    }
    return false;
}

/* Does the option apply to the action? If the first clause of its help names no action, it applies to all of them. */
static bool belongs_to(const cli_option *o, const cli_command *c, const cli_action *only)
{
    bool any = false;
    for (const cli_action *a = c->actions; only && a->name; a++)
        any = any || names_action(o->help, a->name, true);
    return !any || names_action(o->help, only->name, false);
}

/* Print the lines of `text` that contain `part`. */
static void matching_lines(const char *text, const char *part, FILE *f)
{
    for (size_t n; *text; text += n) {
        n = strcspn(text, "\n");
        n += text[n] != 0;
        const char *found = strstr(text, part);
        if (found && found < text + n)
            fwrite(text, 1, n, f);
    }
}

static void actions_help(const cli_action *a, const cli_action *only, FILE *f)
{
    for (; a && a->name; a++) {
        if (only && a != only)
            continue;
        if (!only)
            fprintf(f, "\n  %s %s\n", a->name, a->words);
        for (const char *line = a->about; *line; line += strcspn(line, "\n") + 1)
            fprintf(f, "%s%.*s\n", only ? "" : "      ", (int)strcspn(line, "\n"), line);
    }
}

/* Help of one command, from its row, or of one of its actions (NULL: of all). */
static void command_help(const cli_command *c, const cli_action *only, FILE *f)
{
    char part[64] = "";
    if (only)
        snprintf(part, sizeof part, "%s %s", c->name, only->name);
    fprintf(f, "linkwright %s - %s\n\nExamples:\n", only ? part : c->name, c->title);
    matching_lines(c->examples, part, f);
    fprintf(f, "\nUsage:  linkwright %s %s [options]\n\n%s", only ? part : c->name, only ? only->words : c->words, only ? "" : c->about);
    actions_help(c->actions, only, f);
    fputs("\nOptions:\n", f);
    for (const cli_option *o = c->options; o && o->name; o++)
        if (belongs_to(o, c, only))
            cli_option_help(o, f);
    fputs("\nOptions of every command:\n", f);
    cli_common_help(c->options, f);
}

static int unknown_command(const char *word)
{
    const char *names[N_COMMAND + 1];
    for (int i = 0; i < N_COMMAND; i++)
        names[i] = commands[i]->name;
    names[N_COMMAND] = "help";
    const char *near = lw_suggest(word, names, N_COMMAND + 1);
    fprintf(stderr, "linkwright: there is no command '%s'", word);
    if (near)
        fprintf(stderr, "; did you mean '%s'?", near);
    fputs("\nSee 'linkwright help'.\n", stderr);
    return CLI_USAGE;
}

static int unknown_action(const cli_command *c, const char *word)
{
    const char *names[16];
    int n = 0;
    fprintf(stderr, "linkwright %s: there is no action '%s'", c->name, word);
    for (const cli_action *a = c->actions; a && a->name && n < 16; a++)
        names[n++] = a->name;
    const char *near = lw_suggest(word, names, n);
    if (near)
        fprintf(stderr, "; did you mean '%s'?", near);
    for (int i = 0; i < n && !near; i++)
        fprintf(stderr, "%s%s", i == 0 ? "; there are " : i < n - 1 ? ", " : " and ", names[i]);
    fprintf(stderr, "\nSee 'linkwright help %s'.\n", c->name);
    return CLI_USAGE;
}

/* Standard output is buffered: a failure to write is seen when it is flushed. */
static int finish_text(int code)
{
    if (code == CLI_DONE && cli_end_code(code) == CLI_NUMERIC)
        fputs("linkwright: out of memory; the output is not whole\n", stderr);
    if (fflush(stdout) == 0 && !ferror(stdout))
        return cli_end_code(code);
    fputs("linkwright: cannot write to standard output\n", stderr);
    return CLI_BAD_INPUT;
}

/* Print the middle of the manual page; see the Makefile. */
static int manual(void)
{
    for (int i = 0; i < N_COMMAND; i++)
        cli_command_roff(commands[i], stdout);
    cli_common_roff(stdout);
    return finish_text(CLI_DONE);
}

static int help(int argc, char **argv)
{
    if (argc > 0 && strcmp(argv[0], "--roff") == 0)
        return manual();
    if (argc > 1 && strcmp(argv[0], "--completion") == 0 && strcmp(argv[1], "bash") == 0) {
        cli_bash_completion(commands, N_COMMAND, stdout);
        return finish_text(CLI_DONE);
    }
    bool itself = argc == 1 && strcmp(argv[0], "help") == 0;
    const cli_command *c = argc > 0 ? find(argv[0]) : NULL;
    if (argc > 0 && !c && !itself)
        return unknown_command(argv[0]);
    const cli_action *action = c && argc > 1 ? find_action(c, argv[1]) : NULL;
    if (argc > 1 && !action)
        return unknown_action(c, argv[1]);
    if (c)
        command_help(c, action, stdout);
    else
        overview(stdout);
    return finish_text(CLI_DONE);
}

static bool is_plain(const char *word)
{
    return *word && strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:=,+@%") == strlen(word);
}

/* A word in quotes: in $'...' if it holds a byte that does not fit into a line of text. */
static void put_quoted(const char *word, FILE *f)
{
    bool plain = true;
    int n;
    for (const char *c = word; *c && plain; c += n)
        plain = (n = lw_text_character(c)) > 0 && *c != '\n';
    fputs(plain ? " '" : " $'", f);
    for (const char *c = word; *c; c += n) {
        n = lw_text_character(c);
        if (plain && *c == '\'')
            fputs("'\\''", f);
        else if (!plain && (*c == '\'' || *c == '\\'))
            fprintf(f, "\\%c", *c);
        else if (n == 0 || *c == '\n')
            fprintf(f, "\\%03o", (unsigned char)*c);
        else
            fwrite(c, 1, (size_t)n, f);
        n += n == 0;
    }
    fputc('\'', f);
}

/* The command as typed in a shell. NULL: out of memory. */
static char *shell_line(int argc, char **argv)
{
    char *line = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&line, &size);
    if (!f)
        return NULL;
    fputs("linkwright", f);
    for (int i = 1; i < argc; i++) {
        if (is_plain(argv[i])) {
            fprintf(f, " %s", argv[i]);
            continue;
        }
        put_quoted(argv[i], f);
    }
    if (fclose(f) == 0)
        return line;
    free(line);
    return NULL;
}

/* Report an option of other actions, and name these. */
static int foreign_option(const cli_call *call, const cli_option *o, const cli_action *given)
{
    const cli_command *c = call->command;
    char owners[256] = "";
    for (const cli_action *a = c->actions; a->name; a++) {
        size_t n = strlen(owners);
        if (belongs_to(o, c, a))
            snprintf(owners + n, sizeof owners - n, "%s'%s %s'", n ? ", " : "", c->name, a->name);
    }
    return cli_usage(call, "--%s is no option of '%s %s' but of %s; 'linkwright help %s %s' lists those of %s", o->name, c->name,
                     given->name, owners, c->name, given->name, given->name);
}

/* Check the number of words that the command, or its action, takes. *run: the function that runs it. */
static int check_words(const cli_call *call, int (**run)(const cli_call *call))
{
    const cli_command *c = call->command;
    int n = call->parsed.n_word, least = c->least_words, most = c->most_words;
    char usage[256];
    snprintf(usage, sizeof usage, "linkwright %s %s", c->name, c->words);
    *run = c->run;
    if (c->actions) {
        const cli_action *a = n > 0 ? find_action(c, call->parsed.word[0]) : NULL;
        if (n > 0 && !a)
            return unknown_action(c, call->parsed.word[0]);
        least = a ? a->least + 1 : 1;
        most = a ? a->most + 1 : 1;
        *run = a ? a->run : NULL;
        for (const cli_option *o = c->options; a && o && o->name; o++)
            if (cli_given(&call->parsed, o->name) && !belongs_to(o, c, a))
                return foreign_option(call, o, a);
        if (a)
            snprintf(usage, sizeof usage, "linkwright %s %s %s", c->name, a->name, a->words);
    }
    if (n < least)
        return cli_usage(call, "%s missing; write: %s", n ? "more words are" : "a word is", usage);
    if (n > most)
        return cli_usage(call, "'%s' is one word too many; write: %s", call->parsed.word[most], usage);
    return CLI_DONE;
}

static int run(const cli_command *c, int argc, char **argv)
{
    void *settings = calloc(1, c->settings_size + 1);
    char *line = shell_line(argc, argv);
    cli_call call = { .command = c, .settings = settings, .line = line };
    lw_error e = { 0 };
    int code = CLI_NUMERIC, (*act)(const cli_call *call) = NULL;
    if (!settings || !line)
        fputs("linkwright: out of memory\n", stderr);
    else if (cli_parse(c->options, argc - 2, argv + 2, settings, &call.common, &call.parsed, &e) != LW_OK)
        code = e.status == LW_E_MEMORY ? cli_fail(&call, &e) : cli_usage(&call, "%s", e.text);
    else if (call.common.json = call.common.json || (!c->pictures && cli_ends_in(call.common.output, "json")), call.common.help) {
        command_help(c, call.parsed.n_word ? find_action(c, call.parsed.word[0]) : NULL, stdout);
        code = finish_text(CLI_DONE);
    } else if ((code = check_words(&call, &act)) == CLI_DONE && (code = cli_check_outputs(&call)) == CLI_DONE) {
        cli_limit_time(call.common.time);
        cli_limit_memory(&call);
        code = finish_text(act(&call));
        if (cli_timed_out())
            cli_note(&call, "stopped by --time");
    }
    cli_end_folders(code);
    free(call.parsed.word);
    free(settings);
    free(line);
    return code;
}

/* A standard stream that is closed would be the number of the next file that is opened. In its place stands one that
 * cannot be read, or written, so that its use fails. */
static void hold_streams(void)
{
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) < 0)
            (void)!open("/dev/null", fd == 0 ? O_WRONLY : O_RDONLY);
}

int main(int argc, char **argv)
{
    hold_streams();
    setlocale(LC_ALL, "C");
    cli_watch_signals();
    if (argc < 2) {
        overview(stderr);
        return CLI_USAGE;
    }
    if (strcmp(argv[1], "--version") == 0 || strcmp(argv[1], "-V") == 0) {
        puts("linkwright " LW_VERSION);
        return finish_text(CLI_DONE);
    }
    if (strcmp(argv[1], "help") == 0 || strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
        return help(argc - 2, argv + 2);
    const cli_command *c = find(argv[1]);
    return c ? run(c, argc, argv) : unknown_command(argv[1]);
}
