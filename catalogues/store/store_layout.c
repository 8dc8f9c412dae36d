#include "catalogues/store/store_layout.h"

#include <math.h>
#include <string.h>

#define HEAD 6

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

typedef struct reader { const unsigned char *at; size_t left; bool good; } reader;

static int get_byte(reader *r)
{
    r->good = r->good && r->left > 0;
    if (!r->good)
        return 0;
    r->left--;
    return *r->at++;
}

static double get_real(reader *r)
{
    uint32_t bits = 0;
    float f;
    for (int i = 0; i < 4; i++)
        bits |= (uint32_t)get_byte(r) << 8*i;
    memcpy(&f, &bits, sizeof f);
    r->good = r->good && isfinite(f);
    return r->good ? f : 0;
}

static lw_vec2 get_place(reader *r)
{
    double x = get_real(r);
    return lw_v2(x, get_real(r));
}

lw_status lw_layout_unpack(const void *bytes, size_t size, int n_link, lw_chain_layout *l)
{
    reader r = { bytes, size, size >= HEAD && n_link <= LW_LINK_MAX };
    *l = (lw_chain_layout){ 0 };
    r.good = r.good && get_byte(&r) == 1 && get_byte(&r) == n_link;
    l->n_joint = get_byte(&r);
    l->planar = get_byte(&r) & 1;
    l->n_cross = get_byte(&r);
    l->symmetry = get_byte(&r);
    l->least_angle = get_real(&r);
    l->least_gap = get_real(&r);
    r.good = r.good && l->n_joint <= LW_JOINT_MAX;
    for (int i = 0; i < n_link && r.good; i++) {
        l->first[i + 1] = l->first[i] + get_byte(&r);
        r.good = r.good && l->first[i + 1] <= 2*l->n_joint;
    }
    for (int i = 0; r.good && i < l->first[n_link]; i++) {
        l->ring[i] = (uint8_t)get_byte(&r);
        r.good = r.good && l->ring[i] < l->n_joint;
    }
    for (int j = 0; j < l->n_joint && r.good; j++)
        l->at[j] = get_place(&r);
    for (int i = 0; i < n_link && r.good; i++)
        if (l->first[i + 1] - l->first[i] == 1)
            l->end[i] = get_place(&r);
    return r.good && r.left == 0 ? LW_OK : LW_E_NOTATION;
}
