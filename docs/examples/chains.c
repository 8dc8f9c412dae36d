/* Kinematic chains by a callback: those with eight links and one degree of freedom whose links are all different, as
 * graph6 words that nauty's tools read.
 *
 *     cc chains.c $(pkg-config --cflags --libs linkwright) -o chains
 *     ./chains                                                                                            */
#include <linkwright.h>
#include <stdio.h>

typedef struct count { int all, asymmetric; } count;

static lw_status see(void *context, const lw_chain *chain)
{
    count *n = context;
    uint64_t symmetries;
    char *word;
    lw_status status = lw_chain_symmetries(chain, &symmetries);
    n->all++;
    if (status != LW_OK || symmetries > 1)
        return status;
    n->asymmetric++;
    status = lw_chain_to_text(chain, "graph6", &word, NULL);
    if (status == LW_OK)
        puts(word);
    lw_free(word);
    return status;
}

int main(void)
{
    lw_enumeration eight = lw_enumeration_default(8, 1);
    count n = { 0 };
    uint64_t chains, grounds;
    lw_error error;
    if (lw_enumerate_chains(&eight, see, &n, &error) != LW_OK
        || lw_enumerate_count(&eight, &chains, &grounds, &error) != LW_OK) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    fprintf(stderr, "%d of %d chains without symmetry; %d mechanisms by their ground link\n", n.asymmetric, n.all,
            (int)grounds);
    return n.all == 16 && chains == 16 && grounds == 71 ? 0 : 1;
}
