/* Any bytes are a file of kept answers or have an error; what is added is there when the file is read again. */
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>
#include "cli/program/kept_answers.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    cli_kept *k;
    lw_error e = { 0 };
    char path[64];
    size_t n;
    int fd = memfd_create("fuzz", 0);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size)
        abort();
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    lw_status status = cli_kept_open(path, 7, &k, &e);
    if (status != LW_OK && !e.text[0])
        abort();
    if (status == LW_OK) {
        if (cli_kept_add(k, 3, "an answer", 9, &e) != LW_OK)
            abort();
        cli_kept_close(k);
        if (cli_kept_open(path, 7, &k, &e) != LW_OK)
            abort();
        const char *answer = cli_kept_get(k, 3, &n);
        if (!answer || n != 9 || memcmp(answer, "an answer", 9) != 0)
            abort();
        cli_kept_close(k);
    }
    close(fd);
    return 0;
}
