/* Any bytes are a file of a kept count or have an error with a line; a second reading gives the same. */
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>
#include "enumerate/kept.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    lw_kept *k;
    lw_error e = { 0 };
    char path[64];
    int fd = memfd_create("fuzz", 0), n[2] = { 0, 0 };
    if (fd < 0 || write(fd, data, size) != (ssize_t)size)
        abort();
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    for (int i = 0; i < 2; i++) {
        if (lw_kept_open(path, 12, 1, NULL, &k, &e) != LW_OK) {
            if (e.line < 1 || i > 0)
                abort();
            break;
        }
        n[i] = lw_kept_count(k, 0, 1);
        lw_kept_close(k);
    }
    if (n[0] != n[1] && e.line < 1)
        abort();
    close(fd);
    return 0;
}
