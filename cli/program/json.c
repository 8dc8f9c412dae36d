#include "cli/program/json.h"

#include "base/bytes.h"
#include "base/number.h"
#include "base/real.h"
#include "cli/program/output.h"

cli_json cli_json_begin(FILE *f, int indent)
{
    return (cli_json){ .f = f, .indent = indent };
}

static void new_line(cli_json *j)
{
    if (j->indent > 0 && !(j->depth > 0 && j->flat[j->depth - 1]))
        fprintf(j->f, "\n%*s", j->indent*j->depth, "");
}

static void string(FILE *f, const char *text)
{
    fputc('"', f);
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        if (*c == '"' || *c == '\\')
            fprintf(f, "\\%c", *c);
        else if (*c < 0x20)
            fprintf(f, "\\u%04x", *c);
        else if (*c > 0x7f && lw_text_character((const char *)c) == 0)
            fputs("\\ufffd", f);                   /* a file's name may be any bytes */
        else
            for (int n = *c > 0x7f ? lw_text_character((const char *)c) : 1; n > 0; n--)
                fputc(n > 1 ? *c++ : *c, f);
    }
    fputc('"', f);
}

/* Print the comma, line end and key before a value. */
static void lead(cli_json *j, const char *key)
{
    if (j->depth == 0)
        return;
    if (j->any[j->depth - 1])
        fputs(j->indent > 0 && j->flat[j->depth - 1] ? ", " : ",", j->f);
    j->any[j->depth - 1] = true;
    new_line(j);
    if (key) {
        string(j->f, key);
        fputs(j->indent > 0 ? ": " : ":", j->f);
    }
}

static void open_level(cli_json *j, const char *key, char open, char close, bool flat)
{
    lead(j, key);
    fputc(open, j->f);
    j->close[j->depth] = close;
    j->any[j->depth] = false;
    j->flat[j->depth] = flat;
    j->depth++;
}

void cli_json_object(cli_json *j, const char *key) { open_level(j, key, '{', '}', false); }
void cli_json_array(cli_json *j, const char *key) { open_level(j, key, '[', ']', false); }

void cli_json_end(cli_json *j)
{
    j->depth--;
    if (j->any[j->depth] && !j->flat[j->depth])
        new_line(j);
    fputc(j->close[j->depth], j->f);
    if (j->depth == 0)
        fputc('\n', j->f);
}

void cli_json_text(cli_json *j, const char *key, const char *text)
{
    lead(j, key);
    if (text)
        string(j->f, text);
    else
        fputs("null", j->f);
}

void cli_json_real(cli_json *j, const char *key, double v)
{
    lead(j, key);
    char text[LW_NUMBER_SIZE];
    if (isfinite(v)) {
        lw_number_print(v, text);
        fputs(text, j->f);
    } else {
        fputs("null", j->f);
    }
}

void cli_json_int(cli_json *j, const char *key, long long v)
{
    lead(j, key);
    fprintf(j->f, "%lld", v);
}

void cli_json_seed(cli_json *j, const char *key, uint64_t v)
{
    lead(j, key);
    fprintf(j->f, "%llu", (unsigned long long)v);
}

void cli_json_bool(cli_json *j, const char *key, bool v)
{
    lead(j, key);
    fputs(v ? "true" : "false", j->f);
}

void cli_json_raw(cli_json *j, const char *key, const char *json)
{
    lead(j, key);
    if (!json)
        cli_lost();
    fputs(json ? json : "null", j->f);
}

void cli_json_reals(cli_json *j, const char *key, const double *v, size_t n)
{
    open_level(j, key, '[', ']', true);
    for (size_t i = 0; i < n; i++)
        cli_json_real(j, NULL, v[i]);
    cli_json_end(j);
}

void cli_json_head(cli_json *j, const char *command)
{
    cli_json_object(j, NULL);
    cli_json_text(j, "version", LW_VERSION);
    cli_json_text(j, "command", command);
}
