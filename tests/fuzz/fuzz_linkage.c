/* A linkage that can be read passes the check and reads back after writing; in SI units it gives the same text. */

#include "grammar/linkage/linkage.h"
#include "tests/fuzz/fuzz.h"

static void round_trip(const lw_linkage *k, int indent)
{
    static lw_linkage back;
    lw_error e = { .text = "" };
    char *text = lw_linkage_write(k, indent);
    demand(text && lw_linkage_read(text, strlen(text), "w", &back, &e) == LW_OK);
    char *again = lw_linkage_write(&back, indent);
    demand(again != NULL);
    if (k->units.metre == 1 && k->units.radian == 1)
        demand(strcmp(text, again) == 0);
    free(again);
    free(text);
}

static int one_input(const uint8_t *data, size_t size)
{
    static lw_linkage k;
    lw_error e = { .text = "" };
    lw_status s = lw_linkage_read((const char *)data, size, "f", &k, &e);
    if (refused(s, &e))
        return 0;
    demand(lw_linkage_check(&k, &e) == LW_OK);
    round_trip(&k, 0);
    round_trip(&k, 2);
    return 0;
}
