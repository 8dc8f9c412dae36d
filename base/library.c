#include "base/library.h"

#include <dlfcn.h>
#include <string.h>

lw_status lw_library_load(const char *file, const char *package, const lw_library_call *call, int n, lw_error *e)
{
    void *library = dlopen(file, RTLD_LAZY | RTLD_LOCAL);
    if (!library) {
        const char *why = dlerror();
        bool missing = why && strstr(why, "No such file");
        return lw_error_set(e, LW_E_IO, "%s cannot be loaded: %s%s%s%s", file, why ? why : "no reason is given",
                            missing ? "; the package " : "", missing ? package : "", missing ? " of Debian holds it" : "");
    }
    for (int i = 0; i < n; i++)
        if (!dlsym(library, call[i].name)) {
            dlclose(library);
            return lw_error_set(e, LW_E_IO, "the library %s has no function %s: it is of another version", file, call[i].name);
        }
    for (int i = 0; i < n; i++) {
        void *found = dlsym(library, call[i].name);
        memcpy(call[i].pointer, &found, sizeof found);
    }
    return LW_OK;
}
