/* The completion script of bash, from the same rows as --help. */
#include "cli/program/command.h"

/* Print the names of options, -x and --name, separated by blanks. */
static void names(const cli_option *options, FILE *f)
{
    for (const cli_option *o = options; o && o->name; o++) {
        if (o->letter)
            fprintf(f, "-%c ", o->letter);
        fprintf(f, "--%s ", o->name);
    }
}

/* Print a case for each option that takes one of a few words, or a file. */
static void values(const cli_option *options, FILE *f)
{
    for (const cli_option *o = options; o && o->name; o++) {
        if (o->kind != CLI_CHOICE)
            continue;
        fprintf(f, "        --%s", o->name);
        if (o->letter)
            fprintf(f, "|-%c", o->letter);
        fputs(") words=\"", f);
        for (const char *c = o->argument; *c; c++)
            fputc(*c == '|' ? ' ' : *c, f);
        fputs("\" ;;\n", f);
    }
}

void cli_bash_completion(const cli_command *const *commands, int n, FILE *f)
{
    fputs("# bash completion of linkwright; made by 'linkwright help --completion bash'\n_linkwright()\n{\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words=\n"
          "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n        COMPREPLY=($(compgen -W \"help --version ", f);
    for (int i = 0; i < n; i++)
        fprintf(f, "%s ", commands[i]->name);
    fputs("\" -- \"$word\"))\n        return\n    fi\n    case ${COMP_WORDS[1]} in\n", f);
    for (int i = 0; i < n; i++) {
        fprintf(f, "    %s) case $before in\n", commands[i]->name);
        values(commands[i]->options, f);
        fputs("        *) ", f);
        if (commands[i]->actions) {
            fputs("[ \"$COMP_CWORD\" -eq 2 ] && words=\"", f);
            for (const cli_action *a = commands[i]->actions; a->name; a++)
                fprintf(f, "%s ", a->name);
            fputs("\"; ", f);
        }
        fputs("[[ $word == -* ]] && words=\"", f);
        names(commands[i]->options, f);
        names(cli_common_options, f);
        fputs("\" ;; esac ;;\n", f);
    }
    fputs("    help) words=\"", f);
    for (int i = 0; i < n; i++)
        fprintf(f, "%s ", commands[i]->name);
    fputs("\" ;;\n    esac\n"
          "    if [ -n \"$words\" ]; then COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
          "    else COMPREPLY=($(compgen -f -- \"$word\")); fi\n}\n"
          "complete -o filenames -F _linkwright linkwright\n", f);
}
