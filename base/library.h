/* base/library.h - foreign libraries that are loaded when their first function is called.
 *
 * Commands are stages of pipes and often start by the hundred, and few of them need igraph, cairo or libmicrohttpd.
 * These bring forty more libraries, and with them a start takes four times the processor time.  So they are loaded late.
 * A packager must name them: debian/rules does so with a small program that links them.  A bridge keeps a struct of
 * function pointers, filled once under its own lock:
 *
 *     #define CALLS(X) X(create) X(destroy)
 *     static struct { ... __typeof__(cairo_create) *create; } cairo;
 *     const lw_library_call call[] = { { "cairo_create", &cairo.create }, ... }; */
#ifndef LW_BASE_LIBRARY_H
#define LW_BASE_LIBRARY_H

#include "base/error.h"

/* pointer: to a function pointer */
typedef struct lw_library_call { const char *name; void *pointer; } lw_library_call;

/* Load `file` ("libcairo.so.2", as the system looks libraries up) and fill the pointers of call (n).  It stays loaded
 * until the process ends.  LW_E_IO: it is not there, or lacks one of the functions; then no pointer is changed, and the
 * message names the package of Debian that holds it. */
lw_status lw_library_load(const char *file, const char *package, const lw_library_call *call, int n, lw_error *e);

#endif
