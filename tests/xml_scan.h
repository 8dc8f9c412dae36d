/* tests/xml_scan.h - a strict little XML reader for checking what we write: every tag closed in order,
 * attributes quoted and not repeated, entities known, no stray '<' or '&'.
 *
 *     n = xml_scan(text, size, visit, context);     number of elements, or -1: not well-formed */
#ifndef LW_TESTS_XML_SCAN_H
#define LW_TESTS_XML_SCAN_H

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define XML_DEPTH 32
#define XML_ATTRIBUTES 24

typedef struct xml_element {
    char name[32];
    int  n, depth;
    char key[XML_ATTRIBUTES][32];
    char *value[XML_ATTRIBUTES];          /* as written, entities and all; good during the visit    */
    const char *text;                     /* what follows the tag, up to the next '<'               */
    int  text_size;
} xml_element;

typedef void xml_visit(const xml_element *e, void *context);

static inline const char *xml_get(const xml_element *e, const char *key)
{
    for (int i = 0; i < e->n; i++)
        if (strcmp(e->key[i], key) == 0)
            return e->value[i];
    return NULL;
}

static inline double xml_number(const xml_element *e, const char *key)
{
    const char *v = xml_get(e, key);
    return v ? strtod(v, NULL) : -1e300;
}

/* Is `word` one of the words of the element's class? */
static inline bool xml_is(const xml_element *e, const char *word)
{
    const char *c = xml_get(e, "class");
    size_t n = strlen(word);
    while (c && *c) {
        size_t m = strcspn(c, " ");
        if (m == n && strncmp(c, word, n) == 0)
            return true;
        c += m + (c[m] == ' ');
    }
    return false;
}

static inline bool xml_entities(const char *s, const char *end)
{
    static const char *const known[] = { "&amp;", "&lt;", "&gt;", "&quot;", "&#39;" };
    for (; s < end; s++) {
        bool ok = *s != '&';
        for (int i = 0; i < 5; i++)
            ok = ok || strncmp(s, known[i], strlen(known[i])) == 0;
        if (!ok || *s == '<')
            return false;
    }
    return true;
}

static inline bool xml_name_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-'
        || c == ':' || c == '_';
}

static inline const char *xml_name(const char *s, char name[32])
{
    int n = 0;
    while (xml_name_letter(*s) && n < 31)
        name[n++] = *s++;
    name[n] = 0;
    return n ? s : NULL;
}

/* Attributes of a tag from s on; returns the '>' or '/', NULL when malformed. */
static inline const char *xml_attributes(const char *s, xml_element *e)
{
    while (s && *s == ' ') {
        while (*s == ' ')
            s++;
        if (e->n == XML_ATTRIBUTES || !(s = xml_name(s, e->key[e->n])) || s[0] != '=' || s[1] != '"')
            return NULL;
        const char *end = strchr(s + 2, '"');
        if (!end || !xml_entities(s + 2, end))
            return NULL;
        for (int i = 0; i < e->n; i++)
            if (strcmp(e->key[i], e->key[e->n]) == 0)
                return NULL;
        e->value[e->n++] = strndup(s + 2, (size_t)(end - s - 2));
        s = end + 1;
    }
    return s;
}

static inline const char *xml_tag(const char *s, xml_element *e, bool *empty)
{
    s = xml_attributes(xml_name(s, e->name), e);
    *empty = s && *s == '/';
    s = *empty ? s + 1 : s;
    return s && *s == '>' ? s + 1 : NULL;
}

static inline int xml_scan(const char *s, xml_visit *visit, void *context)
{
    char open[XML_DEPTH][32];
    int depth = 0, n = 0;
    if (strncmp(s, "<?xml ", 6) == 0)
        s = strstr(s, "?>") ? strstr(s, "?>") + 2 : s;
    while (*s) {
        const char *next = strchr(s, '<');
        const char *end = next ? next : s + strlen(s);
        if (!xml_entities(s, end) || (depth == 0 && n > 0 && !next && strspn(s, " \n") != strlen(s)))
            return -1;
        if (!next)
            break;
        s = next + 1;
        if (*s == '/') {
            char name[32];
            s = xml_name(s + 1, name);
            if (!s || *s != '>' || depth == 0 || strcmp(open[--depth], name) != 0)
                return -1;
            s++;
            continue;
        }
        xml_element e = { .depth = depth };
        bool empty;
        s = depth < XML_DEPTH && (depth > 0 || n == 0) ? xml_tag(s, &e, &empty) : NULL;
        if (s) {
            e.text = s;
            e.text_size = (int)strcspn(s, "<");
            n++;
            if (visit)
                visit(&e, context);
            if (!empty)
                strcpy(open[depth++], e.name);
        }
        for (int i = 0; i < e.n; i++)
            free(e.value[i]);
        if (!s)
            return -1;
    }
    return depth == 0 ? n : -1;
}
#endif
