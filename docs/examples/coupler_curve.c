/* The curve of a linkage's first tracer as x y pairs, over a full turn of its input.
 *
 *     cc coupler_curve.c $(pkg-config --cflags --libs linkwright) -o coupler_curve
 *     ./coupler_curve hoeken.json > curve.txt                                                              */
#include <linkwright.h>
#include <stdio.h>
#include <string.h>

/* Hoeken's straight-line linkage, for those who name no file. */
static lw_status hoeken(lw_linkage **linkage, lw_error *error)
{
    static const lw_joint_info joint[] = {
        { .kind = 'r', .link = { 0, 1 }, .at = { 0, 0 } },        /* ground and crank   */
        { .kind = 'r', .link = { 1, 2 }, .at = { 0, 1 } },        /* crank and coupler  */
        { .kind = 'r', .link = { 2, 3 }, .at = { 2, 2.5 } },      /* coupler and rocker */
        { .kind = 'r', .link = { 0, 3 }, .at = { 2, 0 } }
    };
    static const lw_input_info input = { .joint = 0 };
    static const lw_tracer_info tracer = { .name = "P", .link = 2, .at = { 4, 4 } };
    return lw_linkage_create(4, 0, 4, joint, 1, &input, 1, &tracer, linkage, error);
}

static int complain(const lw_error *error)
{
    char text[1200];
    lw_error_print(error, text, sizeof text);
    fprintf(stderr, "%s\n", text);
    return 1;
}

int main(int argc, char **argv)
{
    enum { N = 360 };
    const double turn = 2*3.14159265358979323846;
    double input[N], x[N], y[N], margin[N];
    lw_linkage *linkage = NULL;
    lw_kinematics *kinematics = NULL;
    lw_error error;

    if ((argc > 1 ? lw_linkage_load(argv[1], &linkage, &error) : hoeken(&linkage, &error)) != LW_OK)
        return complain(&error);

    /* once: what this topology needs, and the dimensions of this posture */
    if (lw_kinematics_create(linkage, &kinematics, &error) != LW_OK)
        return lw_linkage_destroy(linkage), complain(&error);

    /* often: no memory is allocated */
    for (int i = 0; i < N; i++)
        input[i] = lw_kinematics_input(kinematics) + i*turn/N;
    lw_status status = lw_kinematics_trace(kinematics, 0, N, input, x, y, NULL, margin);

    int points = 0;
    for (int i = 0; i < N && status == LW_OK; i++)
        if (margin[i] >= 0) {                                  /* it can close there */
            printf("%.17g %.17g\n", x[i], y[i]);
            points++;
        }
    lw_kinematics_destroy(kinematics);
    lw_linkage_destroy(linkage);
    return points == N || argc > 1 ? 0 : 1;
}
