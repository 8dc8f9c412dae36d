#include "catalogues/build/release.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/bytes.h"
#include "base/file.h"
#include "catalogues/build/build_internal.h"
#include "catalogues/store/sha256.h"
#include "enumerate/assur.h"
#include "enumerate/invert.h"
#include "grammar/topology/graph6.h"

/* Chains of as many freedoms are listed; there is one more file for each. */
#define DOF_MAX LW_DOF_MAX

typedef struct job {
    const char             *folder;
    const lw_build_control *control;
    const lw_release_size  *size;
    lw_bytes                sums, counts;     /* SHA256SUMS and counts.csv as they grow            */
    lw_output               chains, list;     /* the file of chains; of mechanisms or Assur groups */
    bool                    mechanisms;       /* list the mechanisms of these chains, too          */
    uint64_t                n_chain, n_list;
    double                  done;             /* rows written so far, for control->goes_on         */
    lw_error                e;
} job;

/* ---- files ----------------------------------------------------------------------------------------------- */

static lw_status path_of(job *j, const char *name, char path[LW_PATH_SIZE])
{
    if ((size_t)snprintf(path, LW_PATH_SIZE, "%s/%s", j->folder, name) >= LW_PATH_SIZE)
        return lw_error_set(&j->e, LW_E_IO, "the path of '%s' in this folder is too long", name);
    return LW_OK;
}

static lw_status make_folder(job *j, const char *name)
{
    char path[LW_PATH_SIZE];
    lw_status s = path_of(j, name, path);
    if (s == LW_OK && mkdir(path, 0777) != 0 && errno != EEXIST)
        s = lw_file_failed(&j->e, "made", path, errno);
    return s;
}

static lw_status open_file(job *j, const char *name, lw_output *o)
{
    char path[LW_PATH_SIZE];
    lw_status s = path_of(j, name, path);
    return s == LW_OK ? lw_output_open(o, path, &j->e) : s;
}

/* Add the sum of a file that is complete, as `sha256sum -c` reads it. */
static lw_status add_sum(job *j, const char *name)
{
    char path[LW_PATH_SIZE], sum[LW_SHA256_HEX], *data;
    size_t size;
    lw_status s = path_of(j, name, path);
    if (s == LW_OK)
        s = lw_file_read_bytes(path, &data, &size, &j->e);
    if (s != LW_OK)
        return s;
    lw_sha256_hex(data, size, sum);
    free(data);
    lw_bytes_text(&j->sums, sum);
    lw_bytes_text(&j->sums, "  ");
    lw_bytes_text(&j->sums, name);
    lw_bytes_text(&j->sums, "\n");
    return LW_OK;
}

/* Commit a list of n rows, or abandon it if something failed before; note its sum and its number of rows. */
static lw_status close_list(job *j, lw_status s, lw_output *o, const char *name, int links, int dof, uint64_t n)
{
    char row[200];
    if (s != LW_OK) {
        lw_output_abandon(o);
        return s;
    }
    s = lw_output_commit(o, &j->e);
    if (s == LW_OK)
        s = add_sum(j, name);
    snprintf(row, sizeof row, "%.*s,%d,%d,%llu,%s\n", (int)strcspn(name, "/"), name, links, dof, (unsigned long long)n, name);
    lw_bytes_text(&j->counts, row);
    return s;
}

/* Write a file whose text is known. */
static lw_status write_text(job *j, const char *name, const lw_bytes *text)
{
    char path[LW_PATH_SIZE];
    lw_status s = path_of(j, name, path);
    if (s == LW_OK)
        s = lw_file_write(path, text->data, text->size, &j->e);
    return s == LW_OK ? add_sum(j, name) : s;
}

/* ---- chains and mechanisms ------------------------------------------------------------------------------- */

static lw_status write_chain(void *context, const lw_chain_item *item)
{
    job *j = context;
    char text[LW_GRAPH6_SIZE];
    uint8_t lowest[LW_LINK_MAX], ground[LW_LINK_MAX];
    int links = item->chain->n_link;
    lw_graph6_print(item->chain, text, sizeof text);
    fprintf(j->chains.f, "%s\n", text);
    j->n_chain++;
    if (j->mechanisms) {
        lw_chain_item_orbits(item, lowest);
        int n = lw_ground_choices(lowest, links, ground);
        for (int i = 0; i < n; i++) {
            int alike = 0;
            for (int k = 0; k < links; k++)
                alike += lowest[k] == ground[i];
            fprintf(j->list.f, "%s,%d,%d\n", text, ground[i] + 1, alike);
        }
        j->n_list += (uint64_t)n;
    }
    return lw_build_goes_on(j->control, ++j->done, 0) ? LW_OK : LW_STOPPED;
}

static lw_status write_chains(job *j, int links, int dof)
{
    char name[64], list[64];
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    how.n_thread = j->control->jobs;
    snprintf(name, sizeof name, "chains/links-%02d-dof-%d.g6", links, dof);
    snprintf(list, sizeof list, "mechanisms/links-%02d-dof-%d.csv", links, dof);
    j->n_chain = j->n_list = 0;
    j->mechanisms = links <= j->size->mechanisms && dof > 0;
    lw_status s = lw_chains_create(links, dof, how.n_thread, &chains, &j->e);
    if (s != LW_OK)
        return s;
    s = open_file(j, name, &j->chains);
    if (s == LW_OK && j->mechanisms && (s = open_file(j, list, &j->list)) != LW_OK)
        lw_output_abandon(&j->chains);
    if (s == LW_OK) {
        if (j->mechanisms)
            fputs("chain,ground,equivalent\n", j->list.f);
        s = lw_chains_each(chains, &how, write_chain, j);
        s = close_list(j, s, &j->chains, name, links, dof, j->n_chain);
        if (j->mechanisms)
            s = close_list(j, s, &j->list, list, links, dof, j->n_list);
    }
    lw_chains_free(chains);
    return s;
}

/* ---- Assur groups ---------------------------------------------------------------------------------------- */

static lw_status write_group(void *context, const lw_chain *truss, int lost, const lw_assur_group *g)
{
    job *j = context;
    char text[LW_GRAPH6_SIZE], modes[16] = "";
    lw_graph6_print(truss, text, sizeof text);
    if (g->n_mode > 0)
        snprintf(modes, sizeof modes, "%d", g->n_mode);
    fprintf(j->list.f, "%s,%d,%d,%d,%s\n", text, lost + 1, g->n_class, g->order, modes);
    j->n_list++;
    return lw_build_goes_on(j->control, ++j->done, 0) ? LW_OK : LW_STOPPED;
}

static lw_status write_groups(job *j, int links)
{
    char name[64];
    snprintf(name, sizeof name, "assur-groups/links-%02d.csv", links);
    j->n_list = 0;
    lw_status s = open_file(j, name, &j->list);
    if (s != LW_OK)
        return s;
    fputs("truss,removed_link,class,order,assembly_modes\n", j->list.f);
    s = lw_assur_each(links, j->control->jobs, write_group, j, &j->e);
    return close_list(j, s, &j->list, name, links, 0, j->n_list);
}

/* ---- the catalogue --------------------------------------------------------------------------------------- */

static lw_status build_all(job *j, lw_store *store)
{
    static const lw_build_topologies what = { .kinds = "r", .pictures = true };
    lw_status s = LW_OK;
    for (int links = 3; links <= j->size->mechanisms && s == LW_OK; links++)
        for (int dof = 1; dof <= DOF_MAX && s == LW_OK; dof++) {
            lw_numbers numbers;
            lw_build_counts counts;
            lw_chains *chains;
            if (lw_numbers_for_links(links, dof, 0, &numbers, NULL) != LW_OK)
                continue;
            s = lw_chains_create(links, dof, j->control->jobs, &chains, &j->e);
            if (s != LW_OK)
                break;
            s = lw_build_chains(store, chains, &what, j->control, &counts, &j->e);
            lw_chains_free(chains);
        }
    return s;
}

/* The catalogue is built beside its place, so that a build that was stopped continues, and then copied without the times
 * of its runs.  The copy depends on the rows alone, the file it was built in also on when they were committed. */
static lw_status write_atlas(job *j)
{
    static const char name[] = "atlas.sqlite", partial[] = "atlas.sqlite.partial";
    char path[LW_PATH_SIZE], built[LW_PATH_SIZE];
    lw_store *store = NULL;
    lw_store_options o = { .write = true, .create = true, .command = lw_build_command(j->control) };
    lw_status s = path_of(j, name, path);
    if (s == LW_OK)
        s = path_of(j, partial, built);
    if (s == LW_OK)
        s = lw_store_open(built, &o, &store, &j->e);
    if (s == LW_OK)
        s = build_all(j, store);
    if (s == LW_OK)
        s = lw_store_copy_undated(store, path, &j->e);
    lw_store_close(store);
    if (s != LW_OK)
        return s;
    unlink(built);
    return add_sum(j, name);
}

/* ---- texts ----------------------------------------------------------------------------------------------- */

static void format(lw_bytes *b, const char *text, const char *command, const lw_release_size *size)
{
    for (; *text; text++) {
        char c[2] = { *text, 0 };
        if (*text != '@') {
            lw_bytes_text(b, c);
            continue;
        }
        switch (*++text) {
        case 'v': lw_bytes_text(b, LW_VERSION); break;
        case 'c': lw_bytes_text(b, command); break;
        case 'n': lw_bytes_integer(b, size->chains); break;
        case 'm': lw_bytes_integer(b, size->mechanisms); break;
        case 'g': lw_bytes_integer(b, size->groups); break;
        }
    }
}

static const char readme[] =
    "# Kinematic chains, mechanisms and Assur groups\n"
    "\n"
    "Written by linkwright @v. The same version writes the same files again:\n"
    "\n"
    "    @c -o FOLDER\n"
    "    cd FOLDER && sha256sum -c SHA256SUMS\n"
    "\n"
    "| file | content |\n"
    "|---|---|\n"
    "| chains/links-P-dof-F.g6 | every planar kinematic chain with P links (up to @n), F degrees of freedom and joints of"
    " one freedom each, as graph6: links are vertices, joints are edges. No chain is fractionated (none falls apart at a"
    " link or a joint), and none has a rigid part of several links. F = 0 are the Baranov trusses: rigid, without a smaller rigid part |\n"
    "| mechanisms/links-P-dof-F.csv | every choice of a ground link up to symmetry, for chains up to @m links: the chain"
    " (graph6), the ground link (vertices count from 1), and how many links of the chain are equivalent to it |\n"
    "| assur-groups/links-N.csv | every Assur group of pins with N links, up to @g: the Baranov truss (graph6), the link"
    " that is removed from it, class and order after Artobolevsky, and the number of assembly modes over the complex"
    " numbers where it is known |\n"
    "| atlas.sqlite | the chains and mechanisms up to @m links as a catalogue of linkwright: structures, symmetry, planarity,"
    " notations, inputs, Assur groups, and where to draw the joints. Its bytes also depend on the version of SQLite |\n"
    "| counts.csv | the number of rows of each file |\n"
    "| SHA256SUMS | checksums of all other files |\n"
    "\n"
    "No two lines of a file are isomorphic, and none is missing: docs/theory.md of linkwright explains how the chains are"
    " generated, and `linkwright catalogue check` compares their numbers with every published count.\n"
    "\n"
    "Licence: LICENSE.txt. To cite: CITATION.cff.\n";

static const char licence[] =
    "Copyright the linkwright contributors.\n"
    "\n"
    "This data set is licensed under the Creative Commons Attribution 4.0 International licence (CC BY 4.0):\n"
    "https://creativecommons.org/licenses/by/4.0/legalcode\n"
    "\n"
    "You may copy, change and share it for any purpose if you name its source (CITATION.cff) and say what you changed.\n"
    "The program that wrote it has a licence of its own, GPL-3.0-or-later.\n";

static const char citation[] =
    "cff-version: 1.2.0\n"
    "message: If you use this data set, please cite it as below.\n"
    "type: dataset\n"
    "title: Kinematic chains to @n links, mechanisms to @m links and Assur groups to @g links\n"
    "version: @v\n"
    "license: CC-BY-4.0\n"
    "authors:\n"
    "  - name: The linkwright contributors\n"
    "keywords:\n"
    "  - kinematic chains\n"
    "  - mechanisms\n"
    "  - Assur groups\n"
    "  - type synthesis\n";

static lw_status write_texts(job *j)
{
    static const struct { const char *name, *text; } file[] = {
        { "README.md", readme }, { "LICENSE.txt", licence }, { "CITATION.cff", citation }
    };
    lw_status s = write_text(j, "counts.csv", &j->counts);
    for (size_t i = 0; i < sizeof file/sizeof *file && s == LW_OK; i++) {
        lw_bytes text = { 0 };
        format(&text, file[i].text, lw_build_command(j->control), j->size);
        s = lw_bytes_end(&text, &j->e);
        if (s == LW_OK)
            s = write_text(j, file[i].name, &text);
        lw_bytes_free(&text);
    }
    return s;
}

/* ---- the whole ------------------------------------------------------------------------------------------- */

static lw_status write_lists(job *j)
{
    lw_numbers numbers;
    lw_status s = LW_OK;
    for (int links = 3; links <= j->size->chains && s == LW_OK; links++)
        for (int dof = 0; dof <= DOF_MAX && s == LW_OK; dof++)
            if (lw_numbers_for_links(links, dof, 0, &numbers, NULL) == LW_OK)
                s = write_chains(j, links, dof);
    for (int links = 2; links <= j->size->groups && s == LW_OK; links += 2)
        s = write_groups(j, links);
    return s;
}

lw_release_size lw_release_sizes(int links, char command[LW_RELEASE_COMMAND])
{
    snprintf(command, LW_RELEASE_COMMAND, "linkwright catalogue release --links %d", links);
    return (lw_release_size){ .chains = links, .mechanisms = links - 4, .groups = (links - 2)/2*2 };
}

lw_status lw_release_write(const char *folder, const lw_release_size *size, const lw_build_control *control, lw_error *e)
{
    char sums[LW_PATH_SIZE];
    if (size->chains < 3 || size->mechanisms < 3 || size->groups < 2 || size->chains > LW_LINK_MAX
        || size->mechanisms > size->chains || size->groups >= LW_LINK_MAX)
        return lw_error_set(e, LW_E_ARG, "a data set has chains and mechanisms with 3 links or more, no mechanisms "
                                         "with more links than its chains, and Assur groups with 2 links or more");
    job *j = calloc(1, sizeof *j);
    if (!j)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    *j = (job){ .folder = folder, .control = control, .size = size };
    lw_bytes_text(&j->counts, "list,links,dof,rows,file\n");
    lw_status s = path_of(j, "SHA256SUMS", sums);
    if (s == LW_OK)
        unlink(sums);                 /* of an older data set: until it is written again, this one is not complete */
    if (s == LW_OK && (s = make_folder(j, "chains")) == LW_OK && (s = make_folder(j, "mechanisms")) == LW_OK
        && (s = make_folder(j, "assur-groups")) == LW_OK && (s = write_lists(j)) == LW_OK
        && (s = write_atlas(j)) == LW_OK && (s = lw_bytes_end(&j->counts, &j->e)) == LW_OK
        && (s = write_texts(j)) == LW_OK && (s = lw_bytes_end(&j->sums, &j->e)) == LW_OK)
        s = lw_file_write(sums, j->sums.data, j->sums.size, &j->e);
    lw_bytes_free(&j->sums);
    lw_bytes_free(&j->counts);
    s = lw_build_fault(s, &j->e, e);
    free(j);
    return s;
}
