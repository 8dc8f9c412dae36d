/* Print the commands as sections of the manual page, from the same rows as --help; docs/linkwright.1.in is the rest of
 * the page. */
#include "cli/program/command.h"

/* Print text for roff: escape minus signs and backslashes; no line begins like a request. */
static void roff(const char *text, FILE *f)
{
    for (const char *c = text; *c; c++) {
        if ((c == text || c[-1] == '\n') && (*c == '.' || *c == '\''))
            fputs("\\&", f);
        if (*c == '-')
            fputs("\\-", f);
        else if (*c == '\\')
            fputs("\\e", f);
        else
            fputc(*c, f);
    }
}

static void as_it_is(const char *text, FILE *f)
{
    fputs(".nf\n", f);
    roff(text, f);
    fputs(".fi\n", f);
}

static void option(const cli_option *o, FILE *f)
{
    fputs(".TP\n", f);
    if (o->letter)
        fprintf(f, "\\fB\\-%c\\fR, ", o->letter);
    fputs("\\fB\\-\\-", f);
    roff(o->name, f);
    fputs("\\fR", f);
    if (o->argument) {
        fputs(" \\fI", f);
        roff(o->argument, f);
        fputs("\\fR", f);
    }
    fputc('\n', f);
    char text[CLI_HELP_SIZE];
    cli_option_text(o, text);
    roff(text, f);
    fputc('\n', f);
}

void cli_command_roff(const cli_command *c, FILE *f)
{
    fprintf(f, ".SS %s ", c->name);
    roff(c->words, f);
    fputc('\n', f);
    roff(c->title, f);
    fputs("\n.PP\n", f);
    as_it_is(c->about, f);
    for (const cli_action *a = c->actions; a && a->name; a++) {
        fprintf(f, ".PP\n\\fB%s\\fR ", a->name);
        roff(a->words, f);
        fputs("\n.PP\n", f);
        as_it_is(a->about, f);
    }
    fputs(".PP\nExamples:\n.PP\n", f);
    as_it_is(c->examples, f);
    for (const cli_option *o = c->options; o && o->name; o++)
        option(o, f);
}

void cli_common_roff(FILE *f)
{
    fputs(".SS Options of every command\n", f);
    for (const cli_option *o = cli_common_options; o->name; o++)
        option(o, f);
}
