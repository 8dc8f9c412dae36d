/* The curve of a linkage's first tracer as x y pairs: the library in one page.
 *
 *     cc coupler_curve.c $(pkg-config --cflags --libs linkwright) -o coupler_curve
 *     ./coupler_curve ../../examples/hoeken.json > curve.txt                                       */
#include <stdio.h>
#include <stdlib.h>
#include "base/file.h"
#include "grammar/linkage.h"
#include "mbs/plan/plan.h"
#include "mbs/plan/pose.h"

static int complain(const lw_error *e)
{
    char text[1200];
    lw_error_print(e, text, sizeof text);
    fprintf(stderr, "%s\n", text);
    return 1;
}

int main(int argc, char **argv)
{
    const char *path = argc > 1 ? argv[1] : "-";
    static lw_linkage linkage;                    /* plain data, some kilobytes */
    static lw_plan plan;
    static lw_pose pose;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    lw_error e;
    char *text;
    size_t size;

    if (lw_file_read(path, &text, &size, &e) != LW_OK)
        return complain(&e);
    if (lw_linkage_read(text, size, path, &linkage, &e) != LW_OK)
        return complain(&e);
    free(text);

    /* once per topology: what the first tracer needs; then the numbers of this posture */
    if (lw_plan_make(&linkage, (lw_plan_options){ .tracers = 1 }, &plan, &e) != LW_OK ||
        lw_plan_read(&plan, &linkage, dim, mode, &input, &e) != LW_OK)
        return complain(&e);

    /* often: no allocation, no global state; LW_OPEN where the linkage cannot close */
    for (int i = 0; i < 360; i++)
        if (lw_pose_solve(&plan, dim, mode, input + i*LW_PI/180, 0, &pose) == LW_OK)
            printf("%.17g %.17g\n", pose.tracer[0][0].x, pose.tracer[0][0].y);
    return 0;
}
