/* linkwright - planar mechanism synthesis.  main.c: finds the command, reads its options, runs it. */
#include <locale.h>
#include <stdlib.h>
#include <string.h>

#include "base/suggest.h"
#include "cli/program/output.h"

static const cli_command *const commands[] = { &cli_fit_command, &cli_classify_command, &cli_trace_command,
                                              &cli_simulate_command,
                                              &cli_mobility_command, &cli_plasma_command, &cli_convert_command,
                                              &cli_draw_command, &cli_clearance_command, &cli_numbers_command,
                                              &cli_structures_command, &cli_chains_command,
                                              &cli_mechanisms_command, &cli_grammar_command,
                                              &cli_catalogue_command,
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
    fputs("linkwright - linkages from the motion they shall make, and the motion from linkages\n\n"
          "Usage:  linkwright COMMAND [words] [options]\n\n", f);
    for (int i = 0; i < N_COMMAND; i++)
        fprintf(f, "  %-11s %s\n", commands[i]->name, commands[i]->title);
    fputs("\n  help [COMMAND], COMMAND --help     examples and all options of a command\n"
          "  --version                          version\n\n"
          "Data goes to standard output (or -o FILE), messages to standard error.\n"
          "An input is never overwritten, and a file that linkwright did not write only with --force.\n"
          "Exit codes: 0 done, 1 nothing found, 2 wrong usage, 3 bad input, 4 numerical failure,\n"
          "5 stopped by a limit with partial results kept, 130 Ctrl-C, 143 SIGTERM.\n", f);
}

void cli_command_help(const cli_command *c, FILE *f)
{
    fprintf(f, "linkwright %s - %s\n\nExamples:\n%s\nUsage:  linkwright %s %s [options]\n\n%s\n",
            c->name, c->title, c->examples, c->name, c->words, c->about);
    if (c->options && c->options[0].name) {
        fputs("Options:\n", f);
        cli_option_help(c->options, f);
        fputc('\n', f);
    }
    fputs("Options of every command:\n", f);
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

/* Standard output is buffered: what could not be written shows when it is flushed. */
static int finish_text(int code)
{
    if (fflush(stdout) == 0 && !ferror(stdout))
        return cli_interrupted() ? 128 + *cli_stop_flag() : code;
    fputs("linkwright: cannot write to standard output\n", stderr);
    return CLI_BAD_INPUT;
}

/* The middle of the manual page; see the Makefile. */
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
    const cli_command *c = argc > 0 ? find(argv[0]) : NULL;
    if (argc > 0 && !c)
        return unknown_command(argv[0]);
    if (c)
        cli_command_help(c, stdout);
    else
        overview(stdout);
    return finish_text(CLI_DONE);
}

static bool is_plain(const char *word)
{
    return *word && strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                 "-_./:=,+@%") == strlen(word);
}

/* The command as one would type it in a shell.  NULL when out of memory. */
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
        fputs(" '", f);
        for (const char *c = argv[i]; *c; c++)
            fputs(*c == '\'' ? "'\\''" : (char[]){ *c, 0 }, f);
        fputc('\'', f);
    }
    return fclose(f) == 0 ? line : NULL;
}

static int check_words(const cli_call *call)
{
    int n = call->parsed.n_word;
    const cli_command *c = call->command;
    if (n < c->least_words)
        return cli_usage(call, "%s wanted: linkwright %s %s", n ? "more words are" : "something is",
                         c->name, c->words);
    if (n > c->most_words)
        return cli_usage(call, "'%s' is one word too many: linkwright %s %s",
                         call->parsed.word[c->most_words], c->name, c->words);
    return CLI_DONE;
}

static int run(const cli_command *c, int argc, char **argv)
{
    void *settings = calloc(1, c->settings_size + 1);
    char *line = shell_line(argc, argv);
    cli_call call = { .command = c, .settings = settings, .line = line };
    lw_error e = { 0 };
    int code = CLI_NUMERIC;
    if (!settings || !line)
        fputs("linkwright: out of memory\n", stderr);
    else if (cli_parse(c->options, argc - 2, argv + 2, settings, &call.common, &call.parsed, &e) != LW_OK)
        code = cli_usage(&call, "%s", e.text);
    else if (call.common.help) {
        cli_command_help(c, stdout);
        code = finish_text(CLI_DONE);
    } else if ((code = check_words(&call)) == CLI_DONE && (code = cli_check_outputs(&call)) == CLI_DONE)
        code = finish_text(c->run(&call));
    free(call.parsed.word);
    free(settings);
    free(line);
    return code;
}

int main(int argc, char **argv)
{
    setlocale(LC_ALL, "C");
    cli_watch_interrupt();
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
