/* test_cli_documents.c - every command of README.md and docs/tutorial.md, run as it is printed and in that order, in one
 * folder with the examples.
 *
 * A command is an indented line that begins with `linkwright` or `$ linkwright`; a comment after " # " belongs to the page.
 * Long searches that save nothing are ended by --time, and may then say so (exit code 5); everything else must end with 0, a
 * question to a catalogue also with 1 (nothing found). */
#include "tests/cli_run.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#define LIMIT " --time 0.1"
#define SHORT " --rounds 1"              /* all that a next command needs, on a machine of any speed */

/* Commands that would measure or compute for seconds, and what makes them short. */
static const struct { const char *begins, *add; } coarse[] = {
    { "linkwright bench mbs ", " --tolerance-range 1e-4:1e-4 --peers none --time 0.001" },
    { "linkwright family sweep ", " -n 20" },
};

/* Commands that search or draw samples until they are told to stop. */
static bool is_long(const char *command)
{
    static const char *const word[] = { "linkwright fit ", "linkwright bench ", "linkwright catalogue curves ", "linkwright catalogue release ",
                                        "linkwright family optimise " };
    for (size_t i = 0; i < sizeof word/sizeof *word; i++)
        if (strncmp(command, word[i], strlen(word[i])) == 0)
            return strstr(command, "--time") == NULL;
    return false;
}

/* The end of the command in a line: before " # " outside quotes, without blanks. */
static size_t command_length(const char *line)
{
    size_t n = 0;
    for (char quote = 0; line[n]; n++) {
        if (quote ? line[n] == quote : line[n] == '\'' || line[n] == '"')
            quote = quote ? 0 : line[n];
        if (!quote && line[n] == '#' && n > 0 && line[n - 1] == ' ')
            break;
    }
    while (n > 0 && isspace((unsigned char)line[n - 1]))
        n--;
    return n;
}

/* Later commands need the files of a search, which takes one round without a limit of time. */
static void run_one(const char *page, int number, const char *command)
{
    bool shortened = is_long(command) && strncmp(command, "linkwright fit ", 15) == 0 && (strstr(command, " -o ") || strstr(command, " --save "));
    bool limited = is_long(command) && !shortened;
    const char *pipe = strpbrk(command, "|>"), *add = limited ? LIMIT : shortened ? SHORT : "";
    for (size_t i = 0; i < sizeof coarse/sizeof *coarse; i++)
        if (strncmp(command, coarse[i].begins, strlen(coarse[i].begins)) == 0)
            add = coarse[i].add;
    size_t first = pipe && add[0] ? (size_t)(pipe - command) : strlen(command);
    ran r = run_with("cd $D/w && PATH=$D/bin:$PATH && %.*s%s %s", (int)first, command, add, command + first);
    bool asks = strstr(command, "catalogue query") || strstr(command, "catalogue nearest");
    bool good = r.code == 0 || (limited && r.code == 5) || (asks && r.code == 1);
    CHECK(good);
    if (!good)
        fprintf(stderr, "%s:%d: exit code %d: %s\n%.600s\n", page, number, r.code, command, r.err);
    ran_free(&r);
}

/* Commands that stand on the page `elsewhere`, too, run there. */
static int run_page(const char *page, const char *elsewhere)
{
    char *text = slurp(page), *rest = text, *other = elsewhere ? slurp(elsewhere) : NULL;
    int number = 0, n = 0;
    for (char *line; (line = strsep(&rest, "\n"));) {
        number++;
        if (strncmp(line, "    ", 4) != 0)
            continue;
        line += strspn(line, " ");
        line += strncmp(line, "$ ", 2) == 0 ? 2 : 0;
        if (strncmp(line, "linkwright ", 11) != 0 || line[11] == '<')
            continue;
        line[command_length(line)] = 0;
        if (other && strstr(other, line))
            continue;
        run_one(page, number, line);
        n++;
    }
    free(text);
    free(other);
    return n;
}

TEST(prepare)
{
    OWN(ran) r = run("mkdir $D/w $D/bin && cp -r examples $D/w && ln -s $(realpath $P) $D/bin/linkwright");
    CHECK_INT(r.code, 0);
}

TEST(commands_of_readme)
{
    CHECK(run_page("README.md", "docs/tutorial.md") > 25);
}

TEST(commands_of_tutorial)
{
    CHECK(run_page("docs/tutorial.md", NULL) > 10);
}
