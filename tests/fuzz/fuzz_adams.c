/* An ADAMS dataset that can be read can be written, and is the same linkage when it is read again. */
#include "catalogues/exchange/adams.h"
#include "catalogues/exchange/export.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    lw_assembly k, back;
    lw_bytes b = { 0 };
    lw_error e = { 0 };
    if (lw_adams_read((const char *)data, size, "fuzz", &k, &e) != LW_OK) {
        if (e.line < 1 || e.column < 1 || !e.text[0])
            abort();
        return 0;
    }
    k.n_input = 0;                         /* else the writer searches the range of the input */
    if (lw_export_adams(&k, NULL, &b, &e) != LW_OK)
        abort();
    if (lw_adams_read(b.data, b.size, "again", &back, &e) != LW_OK || back.n_joint != k.n_joint
        || back.n_link != k.n_link || back.n_tracer != k.n_tracer)
        abort();
    lw_bytes_free(&b);
    lw_assembly_free(&k);
    lw_assembly_free(&back);
    return 0;
}
