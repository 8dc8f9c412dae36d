/* Numbers and texts as bytes; the hash. */
#include "base/bytes.h"
#include "catalogues/store/sha256.h"
#include "tests/check.h"

TEST(numbers_as_people_write_them)
{
    static const struct { double v; int digits; const char *text; } known[] = {
        { 0, 4, "0" }, { -0.0, 4, "0" }, { 1, 4, "1" }, { 0.5, 4, "0.5" }, { -12.5, 4, "-12.5" },
        { 123.456, 4, "123.5" }, { 1234567, 4, "1.235e6" }, { 999999, 4, "1e6" }, { 120000, 4, "120000" },
        { 0.0001, 3, "0.0001" }, { 0.00001, 3, "1e-5" }, { 1.25e-9, 3, "1.25e-9" }, { NAN, 3, "nan" },
        { -INFINITY, 3, "-inf" }, { 1e300, 17, "1.0000000000000001e300" }, { 5e-324, 2, "4.9e-324" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        char t[32];
        lw_number_text(t, known[i].v, known[i].digits);
        CHECK_TEXT(t, known[i].text);
    }
}

/* A second opinion: the C library, asked for the same digits, reads as the same number. */
TEST(numbers_agree_with_the_library)
{
    lw_rng r = check_rng(1);
    for (int i = 0; i < 20000; i++) {
        double v = lw_rng_range(&r, -1, 1)*pow(10, lw_rng_range(&r, -30, 30));
        int digits = 1 + (int)(lw_rng_bits(&r) % 17);
        char ours[32], theirs[64];
        lw_number_text(ours, v, digits);
        snprintf(theirs, sizeof theirs, "%.*e", digits - 1, v);
        CHECK(strtod(ours, NULL) == strtod(theirs, NULL));
        lw_bytes b = { 0 };
        lw_bytes_fixed(&b, v, 2);
        if (fabs(v) < 1e6)
            CHECK_NEAR(strtod(b.data, NULL), v, 0.005000001, 0);
        lw_bytes_free(&b);
    }
}

TEST(fixed_decimals)
{
    static const struct { double v; int decimals; const char *text; } known[] = {
        { 1.5, 2, "1.5" }, { -0.001, 2, "0" }, { 100, 2, "100" }, { -1.05, 1, "-1.1" }, { 2.004, 2, "2" },
        { 1e12, 2, "0" }, { NAN, 2, "0" }, { 0.25, 0, "0" }, { 123456.789012, 6, "123456.789012" },
        { 3.07, 2, "3.07" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_bytes b = { 0 };
        lw_bytes_fixed(&b, known[i].v, known[i].decimals);
        CHECK_TEXT(b.data, known[i].text);
        lw_bytes_free(&b);
    }
}

TEST(xml_holds_no_mark_up)
{
    lw_bytes b = { 0 };
    lw_bytes_xml(&b, "a<b>&\"'\t\x01\x7f\xc3\xa9\xff\xe2\x82\xed\xa0\x80\xc0\xaf\xef\xbf\xbe");
    CHECK_TEXT(b.data, "a&lt;b&gt;&amp;&quot;&#39;\t\xef\xbf\xbd\xef\xbf\xbd\xc3\xa9\xef\xbf\xbd"
               "\xef\xbf\xbd\xef\xbf\xbd" "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd" "\xef\xbf\xbd\xef\xbf\xbd"
               "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd");
    lw_bytes_free(&b);
}

TEST(clean_text_is_cut_between_letters)
{
    char t[8];
    lw_text_clean(t, sizeof t, "abc\xc3\xa9\xc3\xa9\xc3\xa9");
    CHECK_TEXT(t, "abc\xc3\xa9\xc3\xa9");
    lw_text_clean(t, sizeof t, "abcde\xf0\x9f\x98\x80");
    CHECK_TEXT(t, "abcde");
    lw_text_clean(t, 1, "abc");
    CHECK_TEXT(t, "");
    lw_rng r = check_rng(2);
    for (int i = 0; i < 2000; i++) {                      /* cleaning what is clean changes nothing */
        char noise[40], once[128], twice[128];
        for (int k = 0; k < 39; k++)
            noise[k] = (char)(1 + lw_rng_bits(&r) % 255);
        noise[39] = 0;
        lw_text_clean(once, sizeof once, noise);
        lw_text_clean(twice, sizeof twice, once);
        CHECK_TEXT(twice, once);
    }
}

TEST(failure_is_kept_to_the_end)
{
    lw_bytes b = { 0 };
    lw_bytes_text(&b, "abc");
    lw_bytes_add(&b, "x", (size_t)-1/2);                                   /* no such room */
    lw_bytes_text(&b, "def");
    CHECK_TEXT(b.data, "abc");
    lw_error e;
    CHECK_INT(lw_bytes_end(&b, &e), LW_E_MEMORY);
    CHECK(b.data == NULL);
}

/* FIPS 180-4 examples and lengths around the block, by another implementation (OpenSSL). */
TEST(hash_of_known_texts)
{
    static const struct { int n; const char *hash; } a[] = {
        { 0, "47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=" },
        { 1, "ypeBEsobvcr6wjGzmiPcTaeG7/gUfE5yuYB3ha/uSLs=" },
        { 55, "n0OQ+NMMLdkuyfCVtl4rmumwqSWlJY4kHJ8ekQ9zQxg=" },
        { 56, "s1Q5pKxvCUi21vnjxq8PX1kM4g8b3nCQ73lwaG7Gc4o=" },
        { 57, "8TstckZZ6zv0fy3WrxrMyHuB8J9Z8rdeXAvtZYnf6MY=" },
        { 63, "fT50oF19sVvOStnsBljqmOPwbu7PFrTG//LaRX3cLzQ=" },
        { 64, "/+BU/nrgy23GXDr5th1SCfQ5hR20PQulmXM33xVGaOs=" },
        { 65, "Y1NhxIu56rFBmOduqKt/GkFoXWrWKqkUbTAdTxfrCuA=" },
        { 119, "MeulHDE6XAgiat8Y1KNZz9/Y0ugWsT9K+VL36mWE3Ps=" },
        { 120, "Lz0zVDLHC1gK8Ojhs2dKfAINaDql9zqq7f3FWvkEwhw=" },
        { 128, "aDbPE7rEAOkQUHHNavRwhN+srU5eMCyUv+0k4BOvtz4=" },
        { 200, "wqkI2Y9d+Yet5BtfziEwZ++8wh7yJAISpB5UtefCiuU=" },
    };
    char text[200], hash[LW_SHA256_TEXT];
    memset(text, 'a', sizeof text);
    for (size_t i = 0; i < sizeof a/sizeof *a; i++) {
        lw_sha256_base64(text, (size_t)a[i].n, hash);
        CHECK_TEXT(hash, a[i].hash);
    }
    lw_sha256_base64("abc", 3, hash);
    CHECK_TEXT(hash, "ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=");
}
