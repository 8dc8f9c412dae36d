/* linkwright catalogue release - chains, mechanisms and Assur groups as a data set to cite. */
#include "catalogues/build/release.h"
#include "cli/catalogue/catalogue.h"

#define LINKS 14                 /* chains; mechanisms have up to 4 links less, Assur groups 2 less */
#define LEAST 7                  /* so that there are mechanisms with 3 links                       */

static bool goes_on(void *watch, double done, double total)
{
    (void)total;
    return cli_catalogue_goes_on(watch, done);
}

int cli_catalogue_release(const cli_call *call)
{
    static const char *const list[][2] = { { "chains", ".g6" }, { "mechanisms", ".csv" }, { "assur-groups", ".csv" } };
    static const char *const file[] = { "README.md", "LICENSE.txt", "CITATION.cff", "SHA256SUMS", "counts.csv",
                                        "atlas.sqlite" };
    const cli_catalogue_settings *s = call->settings;
    const char *folder = call->common.output;
    int links = cli_given(&call->parsed, "links") ? s->links : LINKS;
    char command[LW_RELEASE_COMMAND];
    lw_release_size size = lw_release_sizes(links, command);
    lw_error e = { 0 };
    if (!folder || (folder[0] == '-' && !folder[1]))
        return cli_usage(call, "release writes a folder of files: name it with -o FOLDER");
    if (links < LEAST)
        return cli_usage(call, "--links takes %d or more here", LEAST);
    int code = cli_make_folder(call, folder);
    for (size_t i = 0; i < sizeof list/sizeof *list && code == CLI_DONE; i++)
        code = cli_catalogue_folder(call, folder, list[i][0], list[i][1]);
    for (size_t i = 0; i < sizeof file/sizeof *file && code == CLI_DONE; i++)
        code = cli_may_write_in(call, folder, "%s", file[i]);
    if (code != CLI_DONE)
        return code;
    cli_catalogue_watch w = cli_catalogue_watch_begin(call, "release", "rows");
    lw_build_control control = { .jobs = call->common.jobs, .commit = s->commit, .seed = 1, .command = command,
                                 .goes_on = goes_on, .context = &w };
    lw_status status = lw_release_write(folder, &size, &control, &e);
    if (status == LW_STOPPED || status == LW_OK)
        code = cli_catalogue_watch_end(&w, CLI_DONE);
    else
        code = cli_catalogue_watch_end(&w, cli_fail(call, &e));
    if (status != LW_OK)
        cli_note(call, "what is in %s is only a part of the data set, without SHA256SUMS; the same command goes on from there", folder);
    else
        cli_note(call, "complete: check it with 'cd %s && sha256sum -c SHA256SUMS'", folder);
    return code;
}
