/* catalogues/store/sha256.c - see sha256.h.  Section numbers are those of FIPS 180-4. */
#include "catalogues/store/sha256.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* First 32 bits of the fractional parts of the cube roots of the first 64 primes (4.2.2). */
static const uint32_t K[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2,
};

static uint32_t rotate(uint32_t x, int n)
{
    return x >> n | x << (32 - n);
}

/* Add one block to the hash (6.2.2). */
static void absorb(uint32_t hash[8], const unsigned char block[64])
{
    uint32_t w[64], v[8];
    for (int t = 0; t < 16; t++)
        w[t] = (uint32_t)block[4*t] << 24 | (uint32_t)block[4*t + 1] << 16
             | (uint32_t)block[4*t + 2] << 8 | block[4*t + 3];
    for (int t = 16; t < 64; t++) {
        uint32_t a = w[t - 15], b = w[t - 2];
        w[t] = w[t - 16] + w[t - 7] + (rotate(a, 7) ^ rotate(a, 18) ^ a >> 3)
             + (rotate(b, 17) ^ rotate(b, 19) ^ b >> 10);
    }
    memcpy(v, hash, sizeof v);                                       /* a b c d e f g h */
    for (int t = 0; t < 64; t++) {
        uint32_t a = v[0], e = v[4];
        uint32_t t1 = v[7] + (rotate(e, 6) ^ rotate(e, 11) ^ rotate(e, 25))
                    + ((e & v[5]) ^ (~e & v[6])) + K[t] + w[t];
        uint32_t t2 = (rotate(a, 2) ^ rotate(a, 13) ^ rotate(a, 22))
                    + ((a & v[1]) ^ (a & v[2]) ^ (v[1] & v[2]));
        memmove(v + 1, v, 7*sizeof *v);
        v[4] += t1;
        v[0] = t1 + t2;
    }
    for (int i = 0; i < 8; i++)
        hash[i] += v[i];
}

/* Base 64 (RFC 4648) of 32 bytes: ten groups of three bytes, one of two. */
static void spell(const unsigned char *bytes, char text[LW_SHA256_TEXT])
{
    static const char letter[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (int i = 0, o = 0; i < 33; i += 3, o += 4) {
        uint32_t v = (uint32_t)bytes[i] << 16 | (uint32_t)bytes[i + 1] << 8 | (i < 30 ? bytes[i + 2] : 0u);
        for (int k = 0; k < 4; k++)
            text[o + k] = letter[v >> (18 - 6*k) & 63];
    }
    text[43] = '=';
    text[44] = 0;
}

static void compute(const void *data, size_t size, unsigned char bytes[33])
{
    uint32_t hash[8] = { 0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,             /* 5.3.3 */
                         0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19 };
    const unsigned char *p = data;
    size_t left = size;
    for (; left >= 64; left -= 64, p += 64)
        absorb(hash, p);
    unsigned char last[128] = { 0 };                     /* the remaining bytes, a 1 bit, zeros, the length (5.1.1) */
    size_t end = left < 56 ? 64 : 128;
    if (left)
        memcpy(last, p, left);
    last[left] = 0x80;
    for (int i = 0; i < 8; i++)
        last[end - 1 - (size_t)i] = (unsigned char)((uint64_t)size*8 >> 8*i);
    for (size_t i = 0; i < end; i += 64)
        absorb(hash, last + i);
    for (int i = 0; i < 32; i++)
        bytes[i] = (unsigned char)(hash[i/4] >> (24 - 8*(i % 4)));
}

void lw_sha256_base64(const void *data, size_t size, char text[LW_SHA256_TEXT])
{
    unsigned char bytes[33] = { 0 };
    compute(data, size, bytes);
    spell(bytes, text);
}

void lw_sha256_hex(const void *data, size_t size, char text[LW_SHA256_HEX])
{
    unsigned char bytes[33];
    compute(data, size, bytes);
    for (int i = 0; i < 32; i++)
        snprintf(text + 2*i, 3, "%02x", bytes[i]);
}
