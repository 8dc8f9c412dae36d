/* The fuzz targets in `make test`: runs each file of the corpus once, so that a fault found by fuzzing
 * stays found. `make fuzz` builds the same targets with libFuzzer instead. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/file.h"

/* tests/fuzz/corpus/NAME for the program fuzz_NAME */
static void corpus_path(char *path, size_t size)
{
    extern char *program_invocation_short_name;
    snprintf(path, size, "tests/fuzz/corpus/%s", program_invocation_short_name + strcspn(program_invocation_short_name, "_") + 1);
}

static int replay_file(const char *path, int (*target)(const uint8_t *data, size_t size))
{
    char *text = NULL;
    size_t size = 0;
    if (lw_file_read_bytes(path, &text, &size, NULL) != LW_OK)
        return 1;
    /* a copy of its own exact size: the sanitizer then sees every read past the end */
    uint8_t *data = malloc(size ? size : 1);
    if (data && size)
        memcpy(data, text, size);
    int failed = !data || target(data, size) != 0;
    free(data);
    free(text);
    return failed;
}

int replay(int argc, char **argv, int (*target)(const uint8_t *data, size_t size));
int replay(int argc, char **argv, int (*target)(const uint8_t *data, size_t size))
{
    extern char *program_invocation_short_name;
    char folder[256], path[1024];
    int n[2] = { 0, 0 };
    corpus_path(folder, sizeof folder);
    if (argc > 1)
        snprintf(folder, sizeof folder, "%s", argv[1]);
    DIR *d = opendir(folder);
    for (struct dirent *f; d && (f = readdir(d)) != NULL;) {
        snprintf(path, sizeof path, "%s/%s", folder, f->d_name);
        if (f->d_name[0] != '.')
            n[replay_file(path, target)]++;
    }
    if (d)
        closedir(d);
    else
        fprintf(stderr, "no folder %s\n", folder);
    printf("%s: %d passed, %d failed\n", program_invocation_short_name, n[0], n[1] + !d);
    return n[1] || !d;
}
