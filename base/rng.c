#include "base/rng.h"
#include "base/real.h"

static uint64_t rotate(uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }

/* The output function of splitmix64 (Steele, Lea & Flood 2014; constants: Stafford's mix 13).  It
 * sends 0 to 0, so that stream 0 is the seeding which Blackman & Vigna 2018 recommend. */
static uint64_t mix(uint64_t z)
{
    z = (z ^ (z >> 30))*0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27))*0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

void lw_rng_seed(lw_rng *r, uint64_t seed, uint64_t stream)
{
    uint64_t x = seed ^ mix(stream);
    for (int i = 0; i < 4; i++)
        r->s[i] = mix(x += 0x9e3779b97f4a7c15u);    /* four different numbers: never all zero */
}

uint64_t lw_rng_bits(lw_rng *r)
{
    uint64_t *s = r->s, out = rotate(s[1]*5, 7)*9, t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate(s[3], 45);
    return out;
}

double lw_rng_uniform(lw_rng *r)
{
    return (double)(lw_rng_bits(r) >> 11)*0x1p-53;
}

double lw_rng_range(lw_rng *r, double lo, double hi)
{
    double u = lw_rng_uniform(r), v = (1 - u)*lo + u*hi;    /* hi - lo may overflow, this does not */
    if (v >= hi)
        v = nextafter(hi, lo);                              /* rounded up to the open end          */
    return v < lo ? lo : v;
}

/* Marsaglia's polar method, the second number of each pair dropped so that the state stays four
 * words.  Equal on all machines as far as their log() is. */
double lw_rng_normal(lw_rng *r)
{
    double x, d2;
    do {
        double y;
        x = 2*lw_rng_uniform(r) - 1;
        y = 2*lw_rng_uniform(r) - 1;
        d2 = x*x + y*y;
    } while (d2 >= 1 || d2 == 0);
    return x*sqrt(-2*log(d2)/d2);
}
