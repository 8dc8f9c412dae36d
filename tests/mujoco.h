/* tests/mujoco.h - MuJoCo, loaded when a test runs, if it is installed (Debian: libmujoco-dev). */
#ifndef LW_TESTS_MUJOCO_H
#define LW_TESTS_MUJOCO_H

#if __has_include(<mujoco/mujoco.h>)
#include <dlfcn.h>
#include <mujoco/mujoco.h>

#include "tests/check.h"
#include "tests/temporary.h"

static struct {
    __typeof__(mj_version)     *version;
    __typeof__(mj_loadXML)     *load;
    __typeof__(mj_makeData)    *make;
    __typeof__(mj_fwdPosition) *position;
    __typeof__(mj_step)        *step;
    __typeof__(mj_name2id)     *find;
    __typeof__(mj_deleteModel) *free_model;
    __typeof__(mj_deleteData)  *free_data;
    __typeof__(mj_resetDataKeyframe) *reset;
} mj;

static inline bool have_mujoco(void)
{
    void *lib = dlopen("libmujoco.so", RTLD_NOW | RTLD_LOCAL);
    if (!lib)
        return false;
    *(void **)&mj.version = dlsym(lib, "mj_version");
    *(void **)&mj.load = dlsym(lib, "mj_loadXML");
    *(void **)&mj.make = dlsym(lib, "mj_makeData");
    *(void **)&mj.position = dlsym(lib, "mj_fwdPosition");
    *(void **)&mj.step = dlsym(lib, "mj_step");
    *(void **)&mj.find = dlsym(lib, "mj_name2id");
    *(void **)&mj.free_model = dlsym(lib, "mj_deleteModel");
    *(void **)&mj.free_data = dlsym(lib, "mj_deleteData");
    *(void **)&mj.reset = dlsym(lib, "mj_resetDataKeyframe");
    return mj.version && mj.version() == mjVERSION_HEADER && mj.load && mj.make && mj.position && mj.step && mj.find
        && mj.free_model && mj.free_data && mj.reset;
}

/* A model from text; NULL after a message. */
static inline mjModel *mujoco_load(const char *end, const char *xml, size_t size)
{
    char path[220], why[1000] = "";
    snprintf(path, sizeof path, "%s/model.%s", temporary_folder(), end);
    FILE *f = fopen(path, "w");
    CHECK(f && fwrite(xml, 1, size, f) == size);
    if (f)
        fclose(f);
    mjModel *m = mj.load(path, NULL, why, sizeof why);
    if (!m)
        fprintf(stderr, "    %s\n%s", why, xml);
    return m;
}
#else
static inline bool have_mujoco(void) { return false; }
#endif

#endif
