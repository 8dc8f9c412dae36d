/* A linkage of up to six links whose point follows a figure of eight: fit dimensions over many topologies.
 *
 *     cc fit_six_links.c $(pkg-config --cflags --libs linkwright) -o fit_six_links
 *     ./fit_six_links eight.svg                                                                           */
#include <linkwright.h>
#include <math.h>
#include <stdio.h>

static bool progress(void *context, double done, double seconds, double best)
{
    (void)context;
    fprintf(stderr, "\r%3.0f %%  %4.1f s  best %-12g", 100*done, seconds, best);
    return true;                                          /* false would stop the search, with what it has */
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
    enum { N = 24 };
    double x[N], y[N];
    lw_target *target = NULL;
    lw_results *results = NULL;
    lw_linkage *linkage = NULL;
    lw_picture *picture = NULL;
    lw_result_info info = { 0 };
    lw_error error;

    for (int i = 0; i < N; i++) {                         /* [m] */
        double t = 2*3.14159265358979323846*i/N;
        x[i] = 0.03*sin(t);
        y[i] = 0.015*sin(2*t);
    }
    if (lw_target_create(N, x, y, NULL, NULL, NULL, 1, &target, &error) != LW_OK)
        return complain(&error);

    lw_fit_request request = lw_fit_request_default();
    request.links = 6;
    request.full_turn = true;                             /* a motor drives it */
    request.rounds = 2;                                   /* a few seconds are enough here */
    request.budget = 5e4;
    request.results = 3;
    request.progress = progress;
    lw_status status = lw_fit_target(target, &request, &results, &error);
    fputc('\n', stderr);
    if (status != LW_OK)
        return lw_target_destroy(target), complain(&error);

    for (int i = 0; i < lw_results_count(results); i++) {
        lw_results_info(results, i, &info);
        printf("%d. %-40s mean error %.3f mm%s\n", i + 1, info.title, 1000*info.error_mean,
               info.verified ? "" : ", not verified");
    }

    /* the best one: again, drawn, kept */
    bool good = lw_results_count(results) > 0 && lw_results_info(results, 0, &info) == LW_OK && info.verified
                && info.error_mean < 0.002 && lw_results_linkage(results, 0, &linkage) == LW_OK;
    if (good && argc > 1)
        good = lw_picture_of_linkage(linkage, target, "figure of eight", &picture, &error) == LW_OK
               && lw_picture_save(picture, argv[1], 0, 0, &error) == LW_OK;
    lw_picture_destroy(picture);
    lw_linkage_destroy(linkage);
    lw_results_destroy(results);
    lw_target_destroy(target);
    return good ? 0 : 1;
}
