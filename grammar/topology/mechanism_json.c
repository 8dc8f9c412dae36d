#include "grammar/topology/mechanism_json.h"

#include "base/real.h"
#include "grammar/text/json_internal.h"
#include "grammar/text/text_internal.h"

size_t lw_mechanism_write(const lw_mechanism *m, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    lw_text_add(&t, "{\"linkwright\": 1, \"links\": %d, \"joints\": [", m->n_link);
    for (int j = 0; j < m->n_joint; j++)
        lw_text_add(&t, "%s[%d, %d, \"%c\"]", j > 0 ? ", " : "", lw_mechanism_printed(m, j, 0) + 1,
                    lw_mechanism_printed(m, j, 1) + 1, m->kind[j]);
    lw_text_byte(&t, ']');
    if (m->ground != LW_NONE)
        lw_text_add(&t, ", \"ground\": %d", m->ground + 1);
    for (int i = 0; i < m->n_input; i++)
        lw_text_add(&t, "%s[%d, %d]", i > 0 ? ", " : ", \"inputs\": [", m->link[m->input[i]][0] + 1, m->link[m->input[i]][1] + 1);
    if (m->n_input > 0)
        lw_text_byte(&t, ']');
    if (m->output != LW_NONE)
        lw_text_add(&t, ", \"output\": %d", m->output + 1);
    lw_text_byte(&t, '}');
    return t.length;
}

/* A whole number from least to most. */
static lw_status read_whole(const lw_json_node *n, int least, int most, const char *what, int *out, lw_error *e)
{
    double v;
    lw_status s = lw_json_number(n, &v, e);
    if (s == LW_OK && (v != floor(v) || v < least || v > most))
        return lw_json_fault(n, e, "%s is a whole number from %d to %d", what, least, most);
    if (s == LW_OK)
        *out = (int)v;
    return s;
}

/* Two different links at the beginning of a list of at least two elements. */
static lw_status read_pair(const lw_json_node *list, int n_link, int pair[2], lw_error *e)
{
    lw_status s = lw_json_expect(list, LW_JSON_ARRAY, e);
    if (s == LW_OK && lw_json_count(list) < 2)
        s = lw_json_fault(list, e, "a joint names its two links");
    for (int i = 0; i < 2 && s == LW_OK; i++) {
        lw_json_node n = lw_json_element(list, (size_t)i);
        s = read_whole(&n, 1, n_link, "a link", &pair[i], e);
        pair[i]--;
    }
    if (s == LW_OK && pair[0] == pair[1])
        s = lw_json_fault(list, e, "link %d is joined to itself", pair[0] + 1);
    return s;
}

static lw_status read_joint(const lw_json_node *n, lw_mechanism *m, lw_error *e)
{
    int pair[2];
    char kind[2] = "r";
    lw_status s = read_pair(n, m->n_link, pair, e);
    if (s == LW_OK && lw_json_count(n) > 3)
        s = lw_json_fault(n, e, "a joint is two links and a letter");
    if (s == LW_OK && lw_json_count(n) == 3) {
        lw_json_node letter = lw_json_element(n, 2);
        s = lw_json_name(&letter, kind, sizeof kind, NULL);
        if (s != LW_OK || !lw_joint_freedoms(kind[0]))
            return lw_json_fault(&letter, e, "a joint is \"r\" (pin), \"t\" (slider), \"p\" (pin in slot) or \"g\" (gear or cam)");
    }
    if (s != LW_OK)
        return s;
    if (lw_mechanism_joint(m, pair[0], pair[1]) != LW_NONE)
        return lw_json_fault(n, e, "links %d and %d are joined twice", pair[0] + 1, pair[1] + 1);
    if (lw_mechanism_join(m, pair[0], pair[1], kind[0]) != LW_OK)
        return lw_json_fault(n, e, "more than %d joints", LW_JOINT_MAX);
    return LW_OK;
}

static lw_status read_joints(const lw_json_node *root, lw_mechanism *m, lw_error *e)
{
    lw_json_node list;
    if (!lw_json_member(root, "joints", &list))
        return lw_json_fault(root, e, "\"joints\" is missing");
    lw_status s = lw_json_expect(&list, LW_JSON_ARRAY, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&list); i++) {
        lw_json_node n = lw_json_element(&list, i);
        s = read_joint(&n, m, e);
    }
    return s;
}

/* Driven joints may come in any order; they are stored in rising order. */
static lw_status read_inputs(const lw_json_node *root, lw_mechanism *m, lw_error *e)
{
    lw_json_node list;
    uint64_t driven = 0;
    if (!lw_json_member(root, "inputs", &list))
        return LW_OK;
    lw_status s = lw_json_expect(&list, LW_JSON_ARRAY, e);
    for (size_t i = 0; s == LW_OK && i < lw_json_count(&list); i++) {
        lw_json_node n = lw_json_element(&list, i);
        int pair[2], j;
        s = read_pair(&n, m->n_link, pair, e);
        if (s != LW_OK)
            return s;
        j = lw_mechanism_joint(m, pair[0], pair[1]);
        if (j == LW_NONE || lw_joint_freedoms(m->kind[j]) != 1 || lw_json_count(&n) != 2)
            return lw_json_fault(&n, e, "an input is a joint of one freedom, given by its two links");
        if (driven >> j & 1)
            return lw_json_fault(&n, e, "this joint is driven already");
        driven |= (uint64_t)1 << j;
        if (__builtin_popcountll(driven) > LW_INPUT_MAX)
            return lw_json_fault(&n, e, "more than %d inputs", LW_INPUT_MAX);
    }
    for (; driven; driven &= driven - 1)
        m->input[m->n_input++] = (uint8_t)__builtin_ctzll(driven);
    return s;
}

static lw_status read_choice(const lw_json_node *root, const char *key, int n_link, int *link, lw_error *e)
{
    lw_json_node n;
    if (!lw_json_member(root, key, &n))
        return LW_OK;
    lw_status s = read_whole(&n, 1, n_link, "a link", link, e);
    *link -= s == LW_OK;
    return s;
}

static lw_status read_root(const lw_json_node *root, lw_mechanism *m, lw_error *e)
{
    static const char *const known[] = { "linkwright", "links", "joints", "ground", "inputs",
                                         "output" };
    lw_json_node n;
    int version, n_link = 1;
    lw_status s = lw_json_expect(root, LW_JSON_OBJECT, e);
    if (s == LW_OK)
        s = lw_json_known_keys(root, known, 6, e);
    if (s == LW_OK && lw_json_member(root, "linkwright", &n))
        s = read_whole(&n, 1, 1, "the version", &version, e);
    if (s == LW_OK && !lw_json_member(root, "links", &n))
        s = lw_json_fault(root, e, "\"links\", their number, is missing");
    if (s == LW_OK && lw_json_kind_of(&n) == LW_JSON_ARRAY)
        s = lw_json_fault(&n, e, "a list of links belongs to a linkage; a chain has their number");
    if (s == LW_OK)
        s = read_whole(&n, 1, LW_LINK_MAX, "the number of links", &n_link, e);
    if (s != LW_OK)
        return s;
    lw_mechanism_clear(m, n_link);
    s = read_joints(root, m, e);
    if (s == LW_OK)
        s = read_inputs(root, m, e);
    if (s == LW_OK)
        s = read_choice(root, "ground", n_link, &m->ground, e);
    return s == LW_OK ? read_choice(root, "output", n_link, &m->output, e) : s;
}

lw_status lw_mechanism_read(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e)
{
    lw_json json;
    lw_mechanism out;
    lw_status s = lw_json_open(text, size, file, &json, e);
    if (s != LW_OK)
        return s;
    lw_json_node root = lw_json_root(&json);
    s = read_root(&root, &out, e);
    if (s == LW_OK)
        *m = out;
    lw_json_close(&json);
    return s;
}
