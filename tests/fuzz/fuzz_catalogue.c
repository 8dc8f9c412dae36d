/* Any bytes as the file of a catalogue: opened, checked and queried without a crash, or refused with a text. */
#include <stdio.h>
#include "linkwright.h"
#include "tests/fuzz/fuzz.h"
#include "tests/temporary.h"

static lw_status take(void *context, int n_column, const char *const *name, const lw_value *value)
{
    (void)context, (void)n_column, (void)name, (void)value;
    return LW_OK;
}

static int one_input(const uint8_t *data, size_t size)
{
    char path[300];
    lw_catalogue *c = NULL;
    lw_error e;
    snprintf(path, sizeof path, "%s/fuzz.db", temporary_folder());
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(data, 1, size, f) != size)
        abort();
    fclose(f);
    lw_status s = lw_catalogue_open(path, false, 0, &c, &e);
    if (s != LW_OK && !e.text[0])
        abort();
    if (s == LW_OK) {
        (void)lw_catalogue_check(c, &e);
        (void)lw_catalogue_query(c, "links > 3", "chains", NULL, NULL, 10, take, NULL, &e);
        (void)lw_catalogue_query(c, "error < 1", "linkages", NULL, NULL, 10, take, NULL, &e);
    }
    lw_catalogue_close(c);
    return 0;
}
