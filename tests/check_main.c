/* main() of the tests that have nothing to prepare.  Weak, because the others have their own. */
#include <stdlib.h>
#include <string.h>

int check_main(void);
int main(void);
__attribute__((weak)) int main(void) { return check_main(); }

/* The linker sends the library's calls of malloc here: what it leaves unwritten are no numbers, and no other number by chance. */
void *__real_malloc(size_t n);
void *__wrap_malloc(size_t n);
void *__wrap_malloc(size_t n)
{
    enum { FILLED = 1 << 20 };
    void *p = __real_malloc(n);
    return p ? memset(p, 0xff, n < FILLED ? n : FILLED) : NULL;
}
