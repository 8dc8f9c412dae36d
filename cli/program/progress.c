#include "cli/program/progress.h"

#include <unistd.h>
#include "base/clock.h"

#define FIRST_AFTER 1.0       /* [s] shorter work shows no progress                                */
#define SHOW_EVERY  0.2       /* [s]                                                               */

cli_progress cli_progress_begin(const cli_call *call, const char *what, const char *unit)
{
    double now = lw_clock_wall();
    return (cli_progress){ .on = !call->common.quiet && isatty(STDERR_FILENO), .what = what,
                           .unit = unit, .start = now, .shown = now + FIRST_AFTER - SHOW_EVERY };
}

static bool is_due(cli_progress *p)
{
    double now = lw_clock_wall();
    if (!p->on || now - p->shown < SHOW_EVERY)
        return false;
    p->shown = now;
    return true;
}

/* The line has n characters now: wipe what is left of the one before. */
static void wipe_rest(cli_progress *p, int n)
{
    if (n < p->width)
        fprintf(stderr, "%*s", p->width - n, "");
    p->width = n;
}

void cli_progress_show(cli_progress *p, double done, double total, const char *note)
{
    if (!is_due(p))
        return;
    double spent = p->shown - p->start, rate = spent > 0 ? done/spent : 0;
    int n = fprintf(stderr, "\r%s: %.0f", p->what, done);
    if (total > 0)
        n += fprintf(stderr, " of %.0f", total);
    n += fprintf(stderr, " %s, %.3g/s", p->unit, rate);
    if (total > done && rate > 0)
        n += fprintf(stderr, ", %.0f s left", (total - done)/rate);
    if (note)
        n += fprintf(stderr, ", %s", note);
    wipe_rest(p, n);
}

void cli_progress_tell(cli_progress *p, const char *note)
{
    if (is_due(p))
        wipe_rest(p, fprintf(stderr, "\r%s: %.0f s, %s", p->what, p->shown - p->start, note));
}

void cli_progress_end(cli_progress *p)
{
    if (p->width)
        fprintf(stderr, "\r%*s\r", p->width, "");
    p->width = 0;
}
