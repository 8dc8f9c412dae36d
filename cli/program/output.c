#include "cli/program/output.h"

#include <stdarg.h>

int cli_exit_code(lw_status s)
{
    switch (s) {
    case LW_OK:         return CLI_DONE;
    case LW_NOTHING:    return CLI_NOTHING;
    case LW_STOPPED:    return CLI_LIMIT;
    case LW_OPEN:
    case LW_E_NUMERIC:
    case LW_E_MEMORY:   return CLI_NUMERIC;
    case LW_E_ARG:
    case LW_E_NOTATION:
    case LW_E_IO:
    case LW_E_KIND:     return CLI_BAD_INPUT;
    }
    return CLI_NUMERIC;
}

int cli_fail(const cli_call *call, const lw_error *e)
{
    char text[sizeof e->file + sizeof e->text + 64];
    lw_error_print(e, text, sizeof text);
    fprintf(stderr, "linkwright %s: %s\n", call->command->name, text);
    return cli_exit_code(e->status);
}

int cli_usage(const cli_call *call, const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    fprintf(stderr, "linkwright %s: ", call->command->name);
    vfprintf(stderr, format, arg);
    fprintf(stderr, "\nSee 'linkwright help %s'.\n", call->command->name);
    va_end(arg);
    return CLI_USAGE;
}

void cli_note(const cli_call *call, const char *format, ...)
{
    if (call->common.quiet)
        return;
    va_list arg;
    va_start(arg, format);
    fprintf(stderr, "linkwright %s: ", call->command->name);
    vfprintf(stderr, format, arg);
    fputc('\n', stderr);
    va_end(arg);
}

lw_status cli_open(const cli_call *call, lw_output *o, lw_error *e)
{
    return lw_output_open(o, call->common.output ? call->common.output : "-", e);
}

int cli_close(const cli_call *call, lw_output *o, int code)
{
    lw_error e = { 0 };
    if (lw_output_commit(o, &e) != LW_OK)
        return cli_fail(call, &e);
    return code;
}

/* ---- Ctrl-C ------------------------------------------------------------------------------------ */

/* the one piece of state a signal handler can reach */
static volatile sig_atomic_t interrupted;

static void on_interrupt(int number)
{
    interrupted = 1;
    signal(number, SIG_DFL);
}

void cli_watch_interrupt(void)
{
    signal(SIGINT, on_interrupt);
    signal(SIGTERM, on_interrupt);
}

const volatile sig_atomic_t *cli_stop_flag(void)
{
    return &interrupted;
}
