#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>
#include "base/bytes.h"

#define FILE_SIZE_MAX ((size_t)256 << 20)
#define READ_STEP     ((size_t)1 << 16)

/* ---- words for the errors of the system ---------------------------------------------------------- */

typedef struct reason { int number; const char *why; } reason;

static const reason reasons[] = {
    { ENOENT,       "no such file or folder; check the spelling" },
    { ENOTDIR,      "a part of the path is a file, not a folder" },
    { EISDIR,       "it is a folder, not a file" },
    { EACCES,       "permission denied; check the rights of the file and its folder" },
    { EPERM,        "the system does not permit it here" },
    { EROFS,        "the file system is read-only; choose another folder" },
    { ENOSPC,       "no space left on the device; free some, or choose another folder" },
    { EDQUOT,       "the disk quota is used up; free some space, or choose another folder" },
    { EFBIG,        "the file would become too large" },
    { ENAMETOOLONG, "the name is too long" },
    { ELOOP,        "too many symbolic links" },
    { EMFILE,       "too many open files" },
    { ENFILE,       "too many open files" },
    { EPIPE,        "the program at the other end of the pipe has ended" },
    { EIO,          "the device reports an error" },
    { ETXTBSY,      "the file is being executed" },
    { EBADF,        "it is not open" },
    { EWOULDBLOCK,  "another program is writing it" },
};

lw_status lw_file_failed(lw_error *e, const char *verb, const char *path, int number)
{
    if (!*path)
        return lw_error_set(e, LW_E_IO, "a file cannot be %s: its name is empty", verb);
    if (strcmp(path, "-") == 0 && strcmp(verb, "written") == 0)
        path = "standard output";                /* "-" alone would be called standard input */
    for (size_t i = 0; i < sizeof reasons/sizeof *reasons; i++)
        if (reasons[i].number == number)
            return lw_error_at(e, LW_E_IO, path, 0, 0, "cannot be %s: %s", verb, reasons[i].why);
    return lw_error_at(e, LW_E_IO, path, 0, 0, "cannot be %s: system error %d", verb, number);
}

/* ---- in --------------------------------------------------------------------------------------- */

/* Read fd to its end into a growing, terminated buffer.  Returns 0 or an error number; EFBIG when
 * there is more than FILE_SIZE_MAX. */
static int read_all(int fd, size_t expected, char **text, size_t *size)
{
    size_t room = expected + READ_STEP, n = 0;
    char *buf = malloc(room + 1);
    int error = buf ? 0 : ENOMEM;
    while (!error) {
        if (n == room) {
            char *more = realloc(buf, 2*room + 1);
            if (!more) {
                error = ENOMEM;
                break;
            }
            buf = more;
            room *= 2;
        }
        ssize_t got = read(fd, buf + n, room - n);
        if (got == 0)
            break;
        if (got < 0)
            error = errno == EINTR ? 0 : errno;
        else if ((n += (size_t)got) > FILE_SIZE_MAX)
            error = EFBIG;
    }
    if (error) {
        free(buf);
        return error;
    }
    buf[n] = '\0';
    *text = buf;
    *size = n;
    return 0;
}

lw_status lw_file_unchanged(int fd, const struct stat *before, const char *path, lw_error *e)
{
    struct stat now;
    if (!S_ISREG(before->st_mode) || fstat(fd, &now) != 0)
        return LW_OK;
    if (now.st_size == before->st_size && now.st_mtim.tv_sec == before->st_mtim.tv_sec && now.st_mtim.tv_nsec == before->st_mtim.tv_nsec)
        return LW_OK;
    return lw_error_at(e, LW_E_IO, path, 0, 0, "another program changed it while it was read");
}

lw_status lw_file_read_bytes(const char *path, char **text, size_t *size, lw_error *e)
{
    bool standard = strcmp(path, "-") == 0;
    int fd = standard ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC);
    struct stat st;
    int error = 0;
    size_t expected = 0;
    if (fd < 0)
        return lw_file_failed(e, "read", path, errno);
    if (fstat(fd, &st) != 0)
        error = errno;
    else if (S_ISDIR(st.st_mode))
        error = EISDIR;
    else if (S_ISREG(st.st_mode) && st.st_size > (off_t)FILE_SIZE_MAX)
        error = EFBIG;
    else if (S_ISREG(st.st_mode))
        expected = (size_t)st.st_size;
    if (!error)
        error = read_all(fd, expected, text, size);
    lw_status s = error ? LW_E_IO : lw_file_unchanged(fd, &st, path, e);
    if (!error && s != LW_OK)
        free(*text);
    if (!standard)
        close(fd);
    if (error == EFBIG)
        return lw_error_at(e, LW_E_IO, path, 0, 0, "cannot be read: it is larger than %zu MiB, "
                           "which is no file meant for here", FILE_SIZE_MAX >> 20);
    if (error == ENOMEM)
        return lw_error_at(e, LW_E_MEMORY, path, 0, 0, "cannot be read: out of memory");
    return error ? lw_file_failed(e, "read", path, error) : s;
}

lw_status lw_file_read(const char *path, char **text, size_t *size, lw_error *e)
{
    char *bytes = NULL;
    size_t n = 0;
    lw_status s = lw_file_read_bytes(path, &bytes, &n, e);
    if (s == LW_OK && lw_text_is_utf16(bytes, n)) {
        char *utf8 = lw_text_from_utf16(bytes, n, &n);
        free(bytes);
        if (!(bytes = utf8))
            s = lw_error_at(e, LW_E_MEMORY, path, 0, 0, "cannot be read: out of memory");
    } else if (s == LW_OK && n >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0) {
        memmove(bytes, bytes + 3, n - 3 + 1);
        n -= 3;
    }
    if (s == LW_OK) {
        *text = bytes;
        *size = n;
    }
    return s;
}

/* ---- out -------------------------------------------------------------------------------------- */

/* The open file that a path names ("-", "/dev/stdout", "/dev/fd/3"), -1 for others.  Opening these
 * anew would truncate or replace what the caller of the program has redirected. */
static int named_stream(const char *path)
{
    static const char *const folders[] = { "/dev/fd/", "/proc/self/fd/" };
    if (strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0)
        return STDOUT_FILENO;
    if (strcmp(path, "/dev/stderr") == 0)
        return STDERR_FILENO;
    for (size_t i = 0; i < sizeof folders/sizeof *folders; i++) {
        size_t n = strlen(folders[i]);
        char *end;
        if (strncmp(path, folders[i], n) == 0 && path[n] >= '0' && path[n] <= '9') {
            long fd = strtol(path + n, &end, 10);
            if (!*end && fd < INT_MAX)
                return (int)fd;
        }
    }
    return -1;
}

/* Take the lock of a temporary file, which its program holds as long as it lives. False: another program has it, or has
 * removed the file. */
static bool lock_temporary(int fd)
{
    struct stat st;
    if (flock(fd, LOCK_EX | LOCK_NB) != 0)
        return errno != EWOULDBLOCK;                 /* a file system without locks: keep going */
    return fstat(fd, &st) == 0 && st.st_nlink > 0;
}

/* Create a file of a new name in the folder of o->path.  The name does not grow with the target's,
 * which may already be as long as the system allows. */
static int create_beside(lw_output *o)
{
    const char *slash = strrchr(o->path, '/');
    int folder = slash ? (int)(slash - o->path) + 1 : 0, fd = -1;
    for (int i = 0; i < 1000 && fd < 0; i++) {
        snprintf(o->temp, sizeof o->temp, "%.*s.lw-%ld-%d.tmp", folder, o->path, (long)getpid(), i);
        fd = open(o->temp, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd < 0 && errno != EEXIST)
            break;
        if (fd >= 0 && !lock_temporary(fd)) {        /* another program takes it for one of a killed program */
            close(fd);
            fd = -1;
        }
    }
    return fd;
}

/* Remove a temporary file if the program that made it no longer lives. */
static void remove_left_over(int folder, const char *name)
{
    int end = 0, fd = -1;
    if (sscanf(name, ".lw-%*d-%*d.tmp%n", &end) == 0 && end > 0 && !name[end])
        fd = openat(folder, name, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (fd >= 0 && flock(fd, LOCK_EX | LOCK_NB) == 0) {
        static const char *const ends[] = { "", "-journal", "-wal", "-shm", "-lock" };       /* of a database */
        for (int i = 0; i < 5; i++) {
            char path[NAME_MAX + 16];
            snprintf(path, sizeof path, "%s%s", name, ends[i]);
            unlinkat(folder, path, 0);
        }
    }
    if (fd >= 0)
        close(fd);
}

void lw_output_clean(const char *path)
{
    char folder[LW_PATH_SIZE];
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
    DIR *d = named_stream(path) < 0 ? opendir(folder) : NULL;
    for (struct dirent *file; d && (file = readdir(d));)
        remove_left_over(dirfd(d), file->d_name);
    if (d)
        closedir(d);
}

/* The file that a killed program left behind, or a new one, for this program alone. Links are not followed. */
static int open_partial(lw_output *o)
{
    snprintf(o->temp, sizeof o->temp, "%s.partial", o->path);
    int fd = open(o->temp, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd >= 0 && flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        close(fd);
        errno = EWOULDBLOCK;
        return -1;
    }
    return fd;
}

/* A regular file is replaced where it really lies: a symbolic link keeps pointing to it. */
static int open_replacement(lw_output *o, const char *path, const struct stat *old)
{
    char real[PATH_MAX];
    const char *target = old && realpath(path, real) ? real : path;
    if (!*target || strlen(target) >= sizeof o->path) {
        errno = *target ? ENAMETOOLONG : ENOENT;
        return -1;
    }
    strcpy(o->path, target);
    if (old && access(o->path, W_OK) != 0)          /* rename() would overrule the protection */
        return -1;
    int fd = o->partial ? open_partial(o) : create_beside(o);
    if (fd >= 0 && old && fchmod(fd, old->st_mode & 07777) != 0)
        errno = 0;                                   /* a file system without rights: keep going */
    return fd;
}

static lw_status open_output(lw_output *o, const char *path, bool partial, lw_error *e)
{
    struct stat st;
    int stream = named_stream(path), fd;
    size_t n = strlen(path);
    *o = (lw_output){ .f = NULL, .partial = partial };
    if (stream >= 0) {
        fflush(stream == STDERR_FILENO ? stderr : stdout);
        int mode = fcntl(stream, F_GETFL);
        errno = EBADF;
        fd = mode >= 0 && (mode & O_ACCMODE) != O_RDONLY ? dup(stream) : -1;
    } else if (stat(path, &st) != 0) {
        if (n > 0 && path[n-1] == '/')
            return lw_file_failed(e, "written", path, EISDIR);
        if (errno == ENOENT && lstat(path, &st) == 0)
            return lw_error_at(e, LW_E_IO, path, 0, 0, "cannot be written: it is a link to a file that does not exist");
        fd = errno == ENOENT || errno == ENAMETOOLONG ? open_replacement(o, path, NULL) : -1;
    } else if (S_ISDIR(st.st_mode)) {
        return lw_file_failed(e, "written", path, EISDIR);
    } else if (S_ISREG(st.st_mode)) {
        fd = open_replacement(o, path, &st);
    } else {
        fd = open(path, O_WRONLY | O_CLOEXEC);       /* a device or pipe cannot be replaced */
    }
    if (fd < 0)
        return lw_file_failed(e, "written", path, errno);
    if (!o->temp[0])
        snprintf(o->path, sizeof o->path, "%s", path);
    o->f = fdopen(fd, partial && o->temp[0] ? "r+b" : "wb");
    if (!o->f) {
        close(fd);
        lw_output_abandon(o);
        return lw_error_at(e, LW_E_MEMORY, path, 0, 0, "cannot be written: out of memory");
    }
    return LW_OK;
}

lw_status lw_output_open(lw_output *o, const char *path, lw_error *e)
{
    return open_output(o, path, false, e);
}

lw_status lw_output_open_partial(lw_output *o, const char *path, lw_error *e)
{
    return open_output(o, path, true, e);
}

/* The stream remembers that an earlier write failed, not why: one more byte, in a file that is lost
 * anyway, asks again. */
static int why_it_failed(FILE *f)
{
    errno = 0;
    return write(fileno(f), "\n", 1) < 0 && errno ? errno : EIO;
}

/* Everything on the disk, or the number of the error.  Pipes and terminals cannot be synced. */
static int finish(FILE *f, bool sync)
{
    int error = 0;
    errno = 0;
    if (fflush(f) != 0 || ferror(f))
        error = errno ? errno : why_it_failed(f);
    if (!error && sync && fsync(fileno(f)) != 0 && errno != EINVAL && errno != EROFS && errno != ENOTSUP)
        error = errno;
    if (fclose(f) != 0 && !error)
        error = errno;
    return error;
}

/* ---- whose file is it? ------------------------------------------------------------------------- */

#define OWN_ATTRIBUTE "user.linkwright"
#define OWN_SIZE      64

/* The text of the attribute: it no longer fits once anybody has changed the file. */
static bool own_text(const char *path, char text[OWN_SIZE])
{
    struct stat st;
    if (stat(path, &st) != 0)
        return false;
    snprintf(text, OWN_SIZE, "%lld %lld.%09ld", (long long)st.st_size, (long long)st.st_mtim.tv_sec, st.st_mtim.tv_nsec);
    return true;
}

/* Not every file system keeps attributes, and no output fails for want of one. */
static void mark_own(const char *path)
{
    char text[OWN_SIZE];
    if (own_text(path, text) && setxattr(path, OWN_ATTRIBUTE, text, strlen(text), 0) != 0)
        errno = 0;
}

static bool begins_with_command(const char *path)
{
    char head[4096];
    FILE *f = fopen(path, "rb");
    size_t n = f ? fread(head, 1, sizeof head - 1, f) : 0;
    if (f)
        fclose(f);
    head[n] = '\0';
    return strncmp(head, "# linkwright ", 13) == 0
           || (head[0] == '{' && strstr(head, "\"command\": \"linkwright "));
}

bool lw_file_is_own(const char *path)
{
    char text[OWN_SIZE], kept[OWN_SIZE];
    ssize_t n = getxattr(path, OWN_ATTRIBUTE, kept, sizeof kept);
    if (n < 0)
        return begins_with_command(path);
    return own_text(path, text) && (size_t)n == strlen(text) && memcmp(kept, text, (size_t)n) == 0;
}

bool lw_output_keep(const char *temp, const char *path)
{
    struct stat st;
    if (stat(temp, &st) != 0 || st.st_size == 0)
        return false;
    mark_own(temp);
    return rename(temp, path) == 0;
}

static lw_status commit_to(lw_output *o, const char *path, lw_error *e)
{
    if (!o->f)
        return lw_error_set(e, LW_E_ARG, "this output is not open");
    int error = finish(o->f, o->temp[0] != '\0');
    o->f = NULL;
    if (!error && o->temp[0])
        mark_own(o->temp);
    if (!error && o->temp[0] && strcmp(o->temp, path) != 0 && rename(o->temp, path) != 0)
        error = errno;
    if (error) {
        lw_output_abandon(o);
        return lw_file_failed(e, "written", path, error);
    }
    o->temp[0] = '\0';
    return LW_OK;
}

lw_status lw_output_commit(lw_output *o, lw_error *e)
{
    return commit_to(o, o->path, e);
}

lw_status lw_output_commit_partial(lw_output *o, lw_error *e)
{
    char path[LW_PATH_SIZE + 16];
    struct stat st;
    snprintf(path, sizeof path, "%s.partial", o->path);
    if (o->temp[0] && !o->partial && lstat(path, &st) == 0 && !(S_ISREG(st.st_mode) && lw_file_is_own(path))) {
        lw_output_abandon(o);
        return lw_error_at(e, LW_E_IO, path, 0, 0, "the work was stopped, and the result so far is lost: this file "
                           "exists, and linkwright did not write it");
    }
    return commit_to(o, path, e);
}

void lw_output_abandon(lw_output *o)
{
    if (o->f)
        fclose(o->f);
    if (o->temp[0] && !o->partial)
        unlink(o->temp);
    o->f = NULL;
    o->temp[0] = '\0';
}

lw_status lw_file_write(const char *path, const void *bytes, size_t size, lw_error *e)
{
    lw_output o;
    lw_status s = lw_output_open(&o, path, e);
    if (s != LW_OK)
        return s;
    fwrite(bytes, 1, size, o.f);                     /* _commit looks at ferror */
    return lw_output_commit(&o, e);
}
