#include "base/gsl_errors.h"

#include <gsl/gsl_errno.h>
#include <pthread.h>

static pthread_mutex_t      lock = PTHREAD_MUTEX_INITIALIZER;
static int                  n_inside;
static gsl_error_handler_t *of_program;

static void pass_over(const char *reason, const char *file, int line, int code)
{
    (void)reason, (void)file, (void)line, (void)code;
}

void lw_gsl_begin(void)
{
    pthread_mutex_lock(&lock);
    if (n_inside++ == 0)
        of_program = gsl_set_error_handler(pass_over);
    pthread_mutex_unlock(&lock);
}

void lw_gsl_end(void)
{
    pthread_mutex_lock(&lock);
    if (--n_inside == 0) {
        gsl_error_handler_t *now = gsl_set_error_handler(of_program);
        if (now != pass_over)                      /* the program set another one meanwhile */
            gsl_set_error_handler(now);
    }
    pthread_mutex_unlock(&lock);
}
