/* catalogues/pages/page_head.c - the beginning of every page: policy, style sheet, title */
#include "catalogues/pages/page_head.h"

#include <stdio.h>

#include "catalogues/draw/drawing.h"
#include "catalogues/store/sha256.h"

void lw_page_text(lw_bytes *b, const char *open, const char *text, const char *close)
{
    lw_bytes_text(b, open);
    lw_bytes_xml(b, text ? text : "");
    lw_bytes_text(b, close);
}

static void lines(lw_bytes *b, const char *const *line)
{
    for (; *line; line++)
        lw_bytes_text(b, *line);
}

/* Write the inks as variables of the style sheet, light and dark, and the classes that use them. */
static void ink_styles(lw_bytes *b)
{
    char t[160];
    for (int dark = 0; dark < 2; dark++) {
        lw_bytes_text(b, dark ? "@media (prefers-color-scheme: dark) {\n:root {" : ":root {");
        for (int i = LW_INK_PAPER; i < LW_INK_COUNT; i++) {
            unsigned rgb = dark ? lw_ink_dark((lw_ink)i) : lw_ink_light((lw_ink)i);
            snprintf(t, sizeof t, " --%s: #%06x;", lw_ink_name((lw_ink)i), rgb);
            lw_bytes_text(b, t);
        }
        lw_bytes_text(b, dark ? " }\n}\n" : " }\n");
    }
    lw_bytes_text(b, "svg line, svg polyline, svg polygon, svg circle { fill: none; }\n");
    for (int i = LW_INK_PAPER; i < LW_INK_COUNT; i++) {
        const char *name = lw_ink_name((lw_ink)i);
        snprintf(t, sizeof t, ".f-%s { fill: var(--%s); }\n.s-%s { stroke: var(--%s); }\n", name,
                 name, name, name);
        lw_bytes_text(b, t);
    }
}

/* Write the content security policy: only this style sheet and this script, named by their hashes, are used, and nothing
 * is loaded but, with `loads`, scripts of the page's own folder. */
static void policy(lw_bytes *b, const lw_bytes *style, const lw_bytes *script, bool loads)
{
    char hash[LW_SHA256_TEXT];
    lw_bytes_text(b, "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
                     "base-uri 'none'; form-action 'none'; style-src 'sha256-");
    lw_sha256_base64(style->data, style->size, hash);
    lw_bytes_text(b, hash);
    lw_bytes_text(b, "'; script-src 'sha256-");
    lw_sha256_base64(script->data, script->size, hash);
    lw_bytes_text(b, hash);
    lw_bytes_text(b, loads ? "' 'self'\">\n" : "'\">\n");
}

void lw_page_number(lw_bytes *b, long n)
{
    lw_bytes_text(b, ",");
    lw_bytes_integer(b, n);
}

void lw_page_style(lw_bytes *out, const char *const *first, const char *const *second)
{
    lw_bytes_text(out, "\n");
    ink_styles(out);
    lines(out, first);
    if (second)
        lines(out, second);
}

void lw_page_script(lw_bytes *out, const char *const *text)
{
    lw_bytes_text(out, "\n");
    lines(out, text);
}

void lw_page_head(lw_bytes *b, const char *title, const lw_bytes *style, const lw_bytes *script, bool loads)
{
    lw_bytes_text(b, "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    policy(b, style, script, loads);
    lw_bytes_text(b, "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    lw_page_text(b, "<title>", title, "</title>\n<style>");
    lw_bytes_text(b, style->data);
    lw_bytes_text(b, "</style>\n</head>\n<body>\n");
}
