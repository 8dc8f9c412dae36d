/* Files in and out: nothing half-written, every refusal says why. */
#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "tests/check.h"
#include "tests/temporary.h"

static int count_files(void)
{
    int n = 0;
    DIR *d = opendir(temporary_folder());
    for (struct dirent *e; d && (e = readdir(d)); )
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    if (d)
        closedir(d);
    return n;
}

static void check_content(const char *path, const char *want)
{
    FREED char *text = NULL;
    size_t size = 0;
    CHECK_INT(lw_file_read(path, &text, &size, NULL), LW_OK);
    CHECK_TEXT(text, want);
    CHECK_INT(size, strlen(want));
}

static void check_refused(const char *path, const char *part)
{
    lw_error e = { 0 };
    CHECK_INT(lw_file_write(path, "x", 1, &e), LW_E_IO);
    CHECK_HAS(e.text, part);
    CHECK_HAS(e.text, "cannot be written");
}

TEST(write_then_read)
{
    const char *path = temporary_file("a.txt");
    CHECK_INT(lw_file_write(path, "hello\n", 6, NULL), LW_OK);
    check_content(path, "hello\n");
    CHECK_INT(lw_file_write(path, "", 0, NULL), LW_OK);
    check_content(path, "");
    CHECK_INT(count_files(), 1);
    unlink(path);
}

/* Byte order marks, a pair of surrogates, halves of pairs, half a character. */
TEST(texts_in_utf_16)
{
    static const struct { int n; const char *bytes, *text; } rows[] = {
        { 5, "\xef\xbb\xbfxy", "xy" }, { 3, "\xef\xbb\xbf", "" }, { 2, "\xff\xfe", "" },
        { 8, "\xff\xfe" "x\0" "\xe9\0" "\xac\x20", "x\u00e9\u20ac" }, { 8, "\xfe\xff" "\0x" "\xd8\x3d\xde\x00", "x\U0001f600" },
        { 6, "\xff\xfe" "\x3d\xd8" "x\0", "\ufffdx" }, { 6, "\xff\xfe" "\x00\xde" "x\0", "\ufffdx" }, { 5, "\xff\xfe" "x\0" "y", "x\ufffd" },
    };
    const char *path = temporary_file("wide.txt");
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        CHECK_INT(lw_file_write(path, rows[i].bytes, (size_t)rows[i].n, NULL), LW_OK);
        check_content(path, rows[i].text);
    }
    unlink(path);
}

TEST(large_file_with_zero_bytes)
{
    size_t n = 3000001, size = 0;
    char *bytes = malloc(n), *text = NULL;
    for (size_t i = 0; i < n; i++)
        bytes[i] = (char)(i*i >> 3);
    CHECK_INT(lw_file_write(temporary_file("big"), bytes, n, NULL), LW_OK);
    CHECK_INT(lw_file_read(temporary_file("big"), &text, &size, NULL), LW_OK);
    CHECK_INT(size, n);
    CHECK(text && memcmp(text, bytes, n) == 0 && text[n] == '\0');
    free(text);
    free(bytes);
    unlink(temporary_file("big"));
}

TEST(unfinished_output_leaves_the_old_file)
{
    const char *path = temporary_file("keep");
    lw_output o;
    CHECK_INT(lw_file_write(path, "old", 3, NULL), LW_OK);
    CHECK_INT(lw_output_open(&o, path, NULL), LW_OK);
    fputs("new, but never finished", o.f);
    fflush(o.f);
    check_content(path, "old");
    lw_output_abandon(&o);
    lw_output_abandon(&o);                            /* harmless twice */
    check_content(path, "old");
    CHECK_INT(count_files(), 1);
    CHECK_INT(lw_output_commit(&o, NULL), LW_E_ARG);
    unlink(path);
}

TEST(rights_and_links_survive)
{
    struct stat st;
    const char *path = temporary_file("script"), *link = temporary_file("link");
    CHECK_INT(lw_file_write(path, "old", 3, NULL), LW_OK);
    CHECK_INT(chmod(path, 0750), 0);
    CHECK_INT(symlink("script", link), 0);
    CHECK_INT(lw_file_write(link, "new", 3, NULL), LW_OK);
    CHECK_INT(lstat(link, &st), 0);
    CHECK(S_ISLNK(st.st_mode));
    CHECK_INT(stat(path, &st), 0);
    CHECK_INT(st.st_mode & 0777, 0750);
    check_content(path, "new");
    unlink(link);
    unlink(path);
}

TEST(longest_name_the_system_allows)
{
    char name[257];
    memset(name, 'n', 255);
    name[255] = '\0';
    CHECK_INT(lw_file_write(temporary_file(name), "x", 1, NULL), LW_OK);
    check_content(temporary_file(name), "x");
    unlink(temporary_file(name));
    name[255] = 'n';
    name[256] = '\0';
    check_refused(temporary_file(name), "too long");
}

TEST(what_cannot_be_written)
{
    char longest[1400];
    memset(longest, 'd', sizeof longest - 1);
    longest[sizeof longest - 1] = '\0';
    check_refused("/dev/full", "no space left");
    check_refused(temporary_file("no/such/folder/x"), "no such file or folder");
    check_refused(temporary_folder(), "folder");
    check_refused(temporary_file("new/"), "folder");
    check_refused("/proc/linkwright-test", "cannot be written");
    check_refused("", "its name is empty");
    check_refused(longest, "too long");
    CHECK_INT(lw_file_write(temporary_file("plain"), "x", 1, NULL), LW_OK);
    check_refused(temporary_file("plain/below"), "a part of the path is a file");
    unlink(temporary_file("plain"));
    CHECK_INT(count_files(), 0);
}

/* A disk that fills up in the middle, played by a limit on the size of files. */
TEST(a_failed_write_leaves_the_old_file)
{
    const char *path = temporary_file("full");
    CHECK_INT(lw_file_write(path, "old", 3, NULL), LW_OK);
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        static char bytes[100000];
        lw_error e;
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &(struct rlimit){ 50000, 50000 });
        lw_status s = lw_file_write(path, bytes, sizeof bytes, &e);
        _exit(s == LW_E_IO && strstr(e.text, "too large") ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    CHECK_INT(status, 0);
    check_content(path, "old");
    CHECK_INT(count_files(), 1);
    unlink(path);
}

TEST(devices_are_written_in_place)
{
    struct stat st;
    CHECK_INT(lw_file_write("/dev/null", "x", 1, NULL), LW_OK);
    CHECK_INT(stat("/dev/null", &st), 0);
    CHECK(S_ISCHR(st.st_mode));
}

static void check_unreadable(const char *path, const char *part)
{
    char *text = NULL;
    size_t size;
    lw_error e = { 0 };
    CHECK_INT(lw_file_read(path, &text, &size, &e), LW_E_IO);
    CHECK_HAS(e.text, part);
    CHECK_TEXT(e.file, path);
    CHECK(text == NULL);
}

TEST(what_cannot_be_read)
{
    check_unreadable(temporary_file("missing"), "no such file");
    check_unreadable(temporary_folder(), "folder, not a file");
    check_unreadable("", "its name is empty");
    check_unreadable("/dev/zero", "larger than 256 MiB");
    check_unreadable("/proc/self/mem", "cannot be read");
}

/* A child whose standard output is a file already begun: "-" and "/dev/stdout" go on from there. */
TEST(standard_output_is_continued)
{
    static const char *const names[] = { "-", "/dev/stdout", "/dev/fd/1" };
    for (size_t i = 0; i < sizeof names/sizeof *names; i++) {
        const char *path = temporary_file("out");
        fflush(stdout);
        pid_t child = fork();
        if (child == 0) {
            if (!freopen(path, "w", stdout))
                _exit(9);
            printf("one ");
            int s = lw_file_write(names[i], "two", 3, NULL) == LW_OK ? 0 : 1;
            _exit(s);
        }
        int status = -1;
        waitpid(child, &status, 0);
        CHECK_INT(status, 0);
        check_content(path, "one two");
        unlink(path);
    }
}

TEST(standard_input_is_read)
{
    const char *path = temporary_file("in");
    CHECK_INT(lw_file_write(path, "given", 5, NULL), LW_OK);
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        char *text;
        size_t size;
        if (!freopen(path, "r", stdin))
            _exit(9);
        _exit(lw_file_read("-", &text, &size, NULL) == LW_OK && strcmp(text, "given") == 0 ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    CHECK_INT(status, 0);
    unlink(path);
}

/* What a killed program leaves: found again, for one program at a time, and whole only after a commit. */
TEST(partial_output_is_gone_on_with)
{
    const char *path = temporary_file("long.txt"), *partial = temporary_file("long.txt.partial");
    char text[8] = "";
    lw_output o, second;
    CHECK_INT(lw_output_open_partial(&o, path, NULL), LW_OK);
    fputs("one\n", o.f);
    CHECK_FAILS(lw_output_open_partial(&second, path, &check_error), LW_E_IO, "another program is writing it");
    lw_output_abandon(&o);
    CHECK(access(path, F_OK) != 0);
    check_content(partial, "one\n");
    CHECK_INT(lw_output_open_partial(&o, path, NULL), LW_OK);
    CHECK(fgets(text, sizeof text, o.f) && strcmp(text, "one\n") == 0);
    CHECK_INT(fseek(o.f, 0, SEEK_END), 0);
    fputs("two\n", o.f);
    CHECK_INT(lw_output_commit(&o, NULL), LW_OK);
    check_content(path, "one\ntwo\n");
    CHECK_INT(count_files(), 1);
    unlink(path);
    CHECK_INT(lw_output_open_partial(&o, "/dev/null", NULL), LW_OK);
    CHECK_INT(lw_output_commit(&o, NULL), LW_OK);
}

/* A text that another program appends to meanwhile is no version of the file: sooner or later this is noticed. */
TEST(changes_while_it_is_read)
{
    const char *path = temporary_file("growing");
    lw_error e = { 0 };
    lw_status s = LW_OK;
    CHECK_INT(lw_file_write(path, "", 0, NULL), LW_OK);
    CHECK_INT(truncate(path, 1 << 20), 0);
    pid_t writer = fork();
    if (writer == 0) {
        int fd = open(path, O_WRONLY | O_APPEND);
        while (write(fd, "+", 1) == 1) { }
        _exit(1);
    }
    for (int i = 0; i < 10000 && s == LW_OK; i++) {
        char *text = NULL;
        size_t size = 0;
        s = lw_file_read_bytes(path, &text, &size, &e);
        if (s == LW_OK)
            free(text);
    }
    kill(writer, SIGKILL);
    waitpid(writer, NULL, 0);
    CHECK_INT(s, LW_E_IO);
    CHECK_HAS(e.text, "changed it while it was read");
    unlink(path);
}

/* A link that somebody put beside the output must not lead the writing to another file. */
TEST(partial_output_follows_no_link)
{
    const char *path = temporary_file("linked.txt"), *partial = temporary_file("linked.txt.partial");
    const char *other = temporary_file("other.txt");
    lw_output o;
    CHECK_INT(lw_file_write(other, "kept\n", 5, NULL), LW_OK);
    CHECK_INT(symlink(other, partial), 0);
    CHECK_INT(lw_output_open_partial(&o, path, NULL), LW_E_IO);
    check_content(other, "kept\n");
}
