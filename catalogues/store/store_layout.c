#include "catalogues/store/store_layout.h"

#include <string.h>
#include "base/real.h"

static void put_byte(lw_bytes *b, int v)
{
    unsigned char c = (unsigned char)v;
    lw_bytes_add(b, &c, 1);
}

static void put_real(lw_bytes *b, double v)
{
    float f = (float)v;
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    for (int i = 0; i < 4; i++)
        put_byte(b, (int)(bits >> 8*i & 255));
}

void lw_layout_pack(const lw_chain_layout *l, int n_link, lw_bytes *out)
{
    put_byte(out, 1);
    put_byte(out, n_link);
    put_byte(out, l->n_joint);
    put_byte(out, l->planar);
    put_byte(out, l->n_cross < 255 ? l->n_cross : 255);
    put_byte(out, l->symmetry < 255 ? l->symmetry : 255);
    put_real(out, l->least_angle);
    put_real(out, l->least_gap);
    for (int i = 0; i < n_link; i++)
        put_byte(out, l->first[i + 1] - l->first[i]);
    lw_bytes_add(out, l->ring, (size_t)l->first[n_link]);
    for (int j = 0; j < l->n_joint; j++) {
        put_real(out, l->at[j].x);
        put_real(out, l->at[j].y);
    }
    for (int i = 0; i < n_link; i++)
        if (l->first[i + 1] - l->first[i] == 1) {
            put_real(out, l->end[i].x);
            put_real(out, l->end[i].y);
        }
}
