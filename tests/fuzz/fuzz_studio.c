/* A question of the studio's page, "NAME\n{JSON}", is answered or refused with a reason, in JSON where it says so. */
#include "studio/studio_internal.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    static studio s = { .token = "0123456789abcdef0123456789abcdef", .lock = PTHREAD_MUTEX_INITIALIZER,
                        .news = PTHREAD_COND_INITIALIZER };
    const uint8_t *line = size ? memchr(data, '\n', size) : NULL;
    char name[16] = "";
    lw_bytes body = { 0 };
    studio_reply r = { 200, "application/json", { 0 } };
    if (!line || line - data >= (ptrdiff_t)sizeof name)
        return 0;
    memcpy(name, data, (size_t)(line - data));
    if (strcmp(name, "search") == 0)                            /* it would begin threads */
        return 0;
    lw_bytes_add(&body, line + 1, size - (size_t)(line + 1 - data));
    studio_ask(&s, name, &body, &r);
    if (r.body.failed || r.body.size == 0 || (r.status != 200 && r.status != 400 && r.status != 404 && r.status != 422))
        abort();
    if (strcmp(r.type, "application/json") == 0) {
        json_t *v = json_loadb(r.body.data, r.body.size, 0, NULL);
        if (!v || (r.status != 200 && !json_is_string(json_object_get(v, "error"))))
            abort();
        json_decref(v);
    }
    lw_bytes_free(&r.body);
    lw_bytes_free(&body);
    return 0;
}
