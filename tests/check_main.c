/* main() of the tests that have nothing to prepare.  Weak, because the others have their own. */
#include <stdlib.h>
#include "tests/fresh_memory.h"

int check_main(void);
int main(void);
__attribute__((weak)) int main(void) { return check_main(); }

/* The linker sends the library's calls of malloc here. */
void *__real_malloc(size_t n);
void *__wrap_malloc(size_t n);
void *__wrap_malloc(size_t n)
{
    return fill_with_nan(__real_malloc(n), n);
}
