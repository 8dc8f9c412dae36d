/* test_cli_option_names.c - an option means the same in every command: one letter has one name, one name has one letter
 * and one kind of value.  Read from the help texts, which are made from the tables of options. */
#include "tests/cli_run.h"

typedef struct option { char command[32], letter[8], name[40], value[160]; } option;

static option all[512];
static int n_all;

/* "  -l, --links P               text": true, and the row is filled. */
static bool read_row(const char *line, option *o)
{
    char at[3] = "";
    *o = (option){ 0 };
    if (strncmp(line, "      --", 8) == 0)
        line += 6;
    else if (sscanf(line, "  -%1[a-zA-Z], -%1[-]", o->letter, at) == 2)
        line += 6;
    else
        return false;
    int n = 0;
    sscanf(line, "--%39[a-z0-9-]%n", o->name, &n);
    if (line[n] == ' ' && line[n + 1] != ' ')
        sscanf(line + n, " %159[^ \n]", o->value);
    return n > 0;
}

static void read_help(const char *command)
{
    OWN(ran) r = run_with("$P help %s", command);
    for (char *at = strstr(r.out, "\nOptions:"); at && *at; at = strchr(at, '\n'), at += at != NULL)
        if (n_all < 512 && read_row(at, &all[n_all]))
            snprintf(all[n_all++].command, sizeof all[0].command, "%s", command);
}

TEST(read_all)
{
    OWN(ran) r = run("$P help");
    char name[32];
    for (char *at = r.out; at && *at; at = strchr(at, '\n'), at += at != NULL)
        if (strncmp(at, "  ", 2) == 0 && sscanf(at, "  %31[a-z]  ", name) == 1 && strcmp(name, "help") != 0)
            read_help(name);
    CHECK(n_all > 150);
    expect("[ \"$($P help help)\" = \"$($P help)\" ]", 0, NULL, NULL);
}

/* Choices may differ, a list is several of one value, and -o names a folder where a command writes several files. */
static bool same_value(const option *a, const option *b)
{
    size_t n = strlen(a->value), m = strlen(b->value);
    bool choices = strchr(a->value, '|') && strchr(b->value, '|'), folder = strcmp(a->name, "output") == 0;
    bool list = (n < m && strcmp(b->value + n, ",...") == 0) || (m < n && strcmp(a->value + m, ",...") == 0);
    return strcmp(a->value, b->value) == 0 || choices || folder || (list && strncmp(a->value, b->value, n < m ? n : m) == 0);
}

static void told(const option *a, const option *b, const char *why)
{
    printf("%s: -%s --%s %s, %s: -%s --%s %s: %s\n", a->command, a->letter, a->name, a->value, b->command, b->letter,
           b->name, b->value, why);
}

TEST(names_and_letters)
{
    int n_bad = 0;
    for (int i = 0; i < n_all; i++)
        for (int k = 0; k < i; k++) {
            const option *a = &all[i], *b = &all[k];
            bool same_name = strcmp(a->name, b->name) == 0;
            if (a->letter[0] && strcmp(a->letter, b->letter) == 0 && !same_name)
                told(a, b, "one letter, two names"), n_bad++;
            /* -f of convert named the format that is read; it is left out there so that nothing changes silently */
            if (same_name && strcmp(a->letter, b->letter) != 0 && strcmp(a->command, "convert") != 0 && strcmp(b->command, "convert") != 0)
                told(a, b, "one name, two letters"), n_bad++;
            if (same_name && !same_value(a, b))
                told(a, b, "one name, two kinds of value"), n_bad++;
        }
    CHECK_INT(n_bad, 0);
}

/* An option that its help text gives to no action is accepted by all of them.  Those of which that is true stand here. */
TEST(options_name_their_actions)
{
    static const char *const of_all = " bench --output bench --time catalogue --time family --set family --view robot --tool "
                                      "robot --tool-at robot --tool-turn robot --drives-at ";
    char words[64][48], command[20], action[20], line[900], key[80];
    int n = all_commands(words, 64);
    for (int i = 0, k; i < n; i = k) {
        size_t size = strcspn(words[i], " ");
        for (k = i + 1; k < n && strncmp(words[k], words[i], size + 1) == 0;)
            k++;
        if (sscanf(words[i], "%19s %19s", command, action) != 2)
            continue;
        size = (size_t)snprintf(line, sizeof line, "{ ");
        for (int a = i; a < k; a++)
            size += (size_t)snprintf(line + size, sizeof line - size, "$P help %s; ", words[a]);
        snprintf(line + size, sizeof line - size, "} | sed '/^Options of every/,/^linkwright/d' | grep -oE '^ +(-., )?--[a-z-]+' | "
                 "sed 's/.*--/--/' | sort | uniq -c | sed -n 's/^ *%d //p'", k - i);
        OWN(ran) r = run(line);
        char *save = NULL;
        for (char *name = strtok_r(r.out, "\n", &save); name; name = strtok_r(NULL, "\n", &save)) {
            snprintf(key, sizeof key, " %s %.40s ", command, name);
            if (!strstr(of_all, key))
                fprintf(stderr, "%s of '%s' names no action\n", name, command);
            CHECK_HAS(of_all, key);
        }
    }
}

/* help COMMAND ACTION shows only what concerns the action. */
TEST(actions)
{
    OWN(ran) r = run("$P help catalogue build");
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "Usage:  linkwright catalogue build FILE --links P");
    CHECK_HAS(r.out, "--no-pictures");
    CHECK_HAS(r.out, "--commit");
    CHECK(!strstr(r.out, "--sql") && !strstr(r.out, "catalogue query"));
    expect("$P catalogue build --help | grep Usage", 0, "catalogue build FILE", "");
    expect("$P help grammar derive", 0, "--sentence", "");
    expect("$P grammar explain --format lam", 2, "", "--format is no option of 'grammar explain' but of 'grammar parse', "
           "'grammar print', 'grammar derive'");
    expect("$P family sweep examples/families/loader.json --vary reach=2:3:3 --minimise boom_mass", 2, "", "but of 'family optimise'");
    expect("$P help bench mbs", 0, "--tolerance-range", "");
    expect("$P help catalogue bild", 2, "", "did you mean 'build'?");
    expect("$P grammar", 2, "", "a word is missing");
    expect("$P catalogue query", 2, "", "more words are missing");
    expect("$P bench fits", 2, "", "did you mean 'fit'?");
}
