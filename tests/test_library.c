/* Libraries loaded late: found, missing, of another version. */
#include "base/library.h"
#include "tests/check.h"

typedef double of_number(double);

TEST(calls_what_it_loaded)
{
    of_number *sine = NULL, *root = NULL;
    const lw_library_call call[] = { { "sin", &sine }, { "cbrt", &root } };
    CHECK_OK(lw_library_load("libm.so.6", "libc6", call, 2, &check_error));
    if (!sine || !root) {
        CHECK(!"pointers are filled");
        return;
    }
    CHECK_NEAR(sine(0.5), 0.479425538604203, 1e-15, 0);
    CHECK_NEAR(root(-27), -3, 1e-15, 0);
}

TEST(says_what_is_missing)
{
    of_number *sine = NULL, *none = NULL;
    lw_error e = { 0 };
    const lw_library_call call[] = { { "sin", &sine }, { "lw_no_such_function", &none } };
    CHECK_FAILS(lw_library_load("libm.so.6", "libc6", call, 2, &check_error), LW_E_IO, "has no function lw_no_such_function");
    CHECK(!sine && !none);
    CHECK_INT(lw_library_load("lib-that-is-not-there.so.9", "libthere9", call, 1, &e), LW_E_IO);
    CHECK_HAS(e.text, "lib-that-is-not-there.so.9");
    CHECK_HAS(e.text, "the package libthere9 of Debian");
    CHECK_INT(lw_library_load("lib-that-is-not-there.so.9", "libthere9", call, 1, NULL), LW_E_IO);
    CHECK_INT(lw_library_load("/proc/self/cmdline", "libthere9", call, 1, &e), LW_E_IO);     /* no library: no package helps */
    CHECK(!strstr(e.text, "the package"));
}
