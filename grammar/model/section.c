#include "grammar/model/section.h"

#include <string.h>
#include "base/real.h"
#include "base/vec2.h"
#include "grammar/linkage/read_internal.h"

/* ---- shapes ---------------------------------------------------------------------------------------- */

enum { WIDTH, HEIGHT, DIAMETER, WALL, WEB, FLANGE, AREA, IY, IZ, IT, ZETA, GYRATION_Y, GYRATION_Z, N_SIZE };

static const struct { const char *key; double power; } size_of[N_SIZE] = {
    { "width", 1 }, { "height", 1 }, { "diameter", 1 }, { "wall", 1 }, { "web", 1 }, { "flange", 1 },
    { "area", 2 }, { "Iy", 4 }, { "Iz", 4 }, { "It", 4 }, { "zeta", 0 }, { "gyration_y", 1 }, { "gyration_z", 1 }
};

static const char *const shapes[] = { "rectangle", "box", "round", "tube", "I", "general" };
enum { RECTANGLE, BOX, ROUND, TUBE, I_PROFILE, GENERAL, N_SHAPE };

#define BIT(i) (1u << (i))
static const unsigned needed[N_SHAPE] = {
    BIT(WIDTH) | BIT(HEIGHT), BIT(WIDTH) | BIT(HEIGHT) | BIT(WALL), BIT(DIAMETER), BIT(DIAMETER) | BIT(WALL),
    BIT(WIDTH) | BIT(HEIGHT) | BIT(WEB) | BIT(FLANGE), BIT(AREA) | BIT(IZ)
};
static const unsigned allowed[N_SHAPE] = {
    BIT(WIDTH) | BIT(HEIGHT), BIT(WIDTH) | BIT(HEIGHT) | BIT(WALL), BIT(DIAMETER), BIT(DIAMETER) | BIT(WALL),
    BIT(WIDTH) | BIT(HEIGHT) | BIT(WEB) | BIT(FLANGE),
    BIT(AREA) | BIT(IZ) | BIT(IY) | BIT(IT) | BIT(ZETA) | BIT(HEIGHT) | BIT(WIDTH) | BIT(GYRATION_Y) | BIT(GYRATION_Z)
};

/* Torsion constant of a rectangle a >= b (Timoshenko & Goodier 1951, section 109: the series, summed). */
static double rectangle_torsion(double a, double b)
{
    double sum = 0;
    for (int n = 1; n < 200; n += 2)
        sum += tanh(n*LW_PI*a/(2*b))/((double)n*n*n*n*n);
    return a*b*b*b/3*(1 - 192*b/(pow(LW_PI, 5)*a)*sum);
}

/* Shear factor of a ring with m the ratio of its radii: 10/9 of the circle and 2 of the thin tube, between them in the form of
 * Cowper's solution (1966). */
static double ring_shear(double m) { return (10 + 32*m*m/((1 + m*m)*(1 + m*m)))/9; }

static void hollow(lw_section *s, double b, double h, double inner_b, double inner_h, double web_y, double web_z)
{
    s->area = b*h - inner_b*inner_h;
    s->iz = (b*h*h*h - inner_b*inner_h*inner_h*inner_h)/12;
    s->zeta_y = s->area/web_y;
    s->zeta_z = s->area/web_z;
    s->y = h/2;
    s->z = b/2;
}

static void fill(int shape, const double *v, lw_section *s)
{
    double b = v[WIDTH], h = v[HEIGHT], t = v[WALL], r = v[DIAMETER]/2, web = v[WEB], flange = v[FLANGE];
    switch (shape) {
    case RECTANGLE:
        *s = (lw_section){ b*h, h*b*b*b/12, b*h*h*h/12, rectangle_torsion(fmax(b, h), fmin(b, h)), 1.2, 1.2, .y = h/2, .z = b/2 };
        return;
    case BOX:                                        /* torsion: Bredt's formula for a thin closed wall */
        hollow(s, b, h, b - 2*t, h - 2*t, 2*(h - 2*t)*t, 2*(b - 2*t)*t);
        s->iy = (h*b*b*b - (h - 2*t)*pow(b - 2*t, 3))/12;
        s->it = 2*t*pow((b - t)*(h - t), 2)/(b + h - 2*t);
        return;
    case ROUND: case TUBE: {
        double in = shape == TUBE ? r - t : 0, i = LW_PI/4*(pow(r, 4) - pow(in, 4)), zeta = ring_shear(in/r);
        *s = (lw_section){ LW_PI*(r*r - in*in), i, i, 2*i, zeta, zeta, .y = r, .z = r, .round = true };
        return;
    }
    case I_PROFILE:                                  /* torsion: sum of thin strips */
        hollow(s, b, h, b - web, h - 2*flange, web*(h - 2*flange), 2*b*flange/1.2);
        s->iy = (2*flange*b*b*b + (h - 2*flange)*web*web*web)/12;
        s->it = (2*b*flange*flange*flange + (h - 2*flange)*web*web*web)/3;
        return;
    default:
        *s = (lw_section){ v[AREA], v[IY] > 0 ? v[IY] : v[IZ], v[IZ], v[IT] > 0 ? v[IT] : 2*v[IZ], v[ZETA], v[ZETA], .y = h/2, .z = b/2 };
    }
}

/* Is a wall thicker than the section? Names the key. */
static const char *too_thick(int shape, const double *v)
{
    if (shape == BOX && !(2*v[WALL] < fmin(v[WIDTH], v[HEIGHT])))
        return "wall";
    if (shape == TUBE && !(2*v[WALL] <= v[DIAMETER]))
        return "wall";
    if (shape == I_PROFILE)
        return !(v[WEB] < v[WIDTH]) ? "web" : !(2*v[FLANGE] < v[HEIGHT]) ? "flange" : NULL;
    return NULL;
}

lw_status lw_section_read(const lw_json_node *n, double metre, lw_section *s, lw_error *e)
{
    double v[N_SIZE] = { 0 };
    const char *known[N_SIZE + 1] = { "shape" };
    lw_json_node at;
    int shape, keys = 1;
    lw_status st = lw_json_expect(n, LW_JSON_OBJECT, e);
    if (st == LW_OK && (st = lw_read_need(n, "shape", &at, e)) == LW_OK)
        st = lw_read_look_up(&at, "section shape", shapes, N_SHAPE, &shape, e);
    if (st != LW_OK)
        return st;
    for (int i = 0; i < N_SIZE; i++)
        if (allowed[shape] & BIT(i))
            known[keys++] = size_of[i].key;
    if ((st = lw_json_known_keys(n, known, keys, e)) != LW_OK)
        return st;
    v[ZETA] = 1.2;
    for (int i = 0; i < N_SIZE; i++) {
        bool given = false;
        if (!(allowed[shape] & BIT(i)))
            continue;
        if ((needed[shape] & BIT(i)) && (st = lw_read_need(n, size_of[i].key, &at, e)) != LW_OK)
            return st;
        if ((st = lw_read_optional(n, size_of[i].key, pow(metre, size_of[i].power), &v[i], &given, e)) != LW_OK)
            return st;
        if (given && !(v[i] > 0) && !(i == ZETA && v[i] == 0)) {
            lw_json_member(n, size_of[i].key, &at);
            return lw_json_fault(&at, e, "\"%s\" of a section must be greater than 0", size_of[i].key);
        }
    }
    const char *thick = too_thick(shape, v);
    if (thick) {
        lw_json_member(n, thick, &at);
        return lw_json_fault(&at, e, "this \"%s\" is too thick: it leaves no hollow in the section", thick);
    }
    fill(shape, v, s);
    s->gyration_y = v[GYRATION_Y], s->gyration_z = v[GYRATION_Z];
    s->whole = shape != GENERAL || (v[IY] > 0 && v[IT] > 0);
    return LW_OK;
}

double lw_section_mass_y(const lw_section *s) { return s->gyration_y > 0 ? s->gyration_y*s->gyration_y : s->iy/s->area; }
double lw_section_mass_z(const lw_section *s) { return s->gyration_z > 0 ? s->gyration_z*s->gyration_z : s->iz/s->area; }

/* ---- materials -------------------------------------------------------------------------------------- */

/* Common values at room temperature; those of the two fibre composites are Makkonen's (1999, table 1). */
static const struct { const char *name; lw_material m; } materials[] = {
    { "steel",           { 210e9, 210e9/2.6, 7850 } },
    { "stainless steel", { 195e9, 195e9/2.6, 7900 } },
    { "aluminium",       { 70e9, 26e9, 2700 } },
    { "titanium",        { 114e9, 43e9, 4430 } },
    { "magnesium",       { 45e9, 17e9, 1770 } },
    { "copper",          { 120e9, 45e9, 8930 } },
    { "brass",           { 105e9, 39e9, 8500 } },
    { "cast iron",       { 110e9, 44e9, 7200 } },
    { "carbon fibre 45", { 100e9, 40e9, 1600 } },
    { "carbon fibre 0",  { 250e9, 3e9, 1600 } },
    { "spruce",          { 11e9, 0.7e9, 430 } },
    { "polyamide",       { 2.8e9, 1e9, 1140 } },
};

lw_status lw_material_read(const lw_json_node *n, lw_material *m, lw_error *e)
{
    static const char *const known[] = { "E", "G", "nu", "density" };
    const char *names[COUNT(materials)];
    double nu = 0;
    bool has[4];
    int which;
    for (int i = 0; i < COUNT(materials); i++)
        names[i] = materials[i].name;
    if (lw_json_kind_of(n) == LW_JSON_TEXT) {
        lw_status s = lw_read_look_up(n, "material", names, COUNT(names), &which, e);
        *m = s == LW_OK ? materials[which].m : (lw_material){ 0 };
        return s;
    }
    if (lw_json_kind_of(n) != LW_JSON_OBJECT)
        return lw_json_fault(n, e, "a material is a name such as \"steel\", or {\"E\", \"G\" or \"nu\", \"density\"} in N/m^2 and kg/m^3");
    double *to[] = { &m->e, &m->g, &nu, &m->density };
    lw_status s = lw_json_known_keys(n, known, COUNT(known), e);
    for (int i = 0; s == LW_OK && i < 4; i++)
        s = lw_read_optional(n, known[i], 1, to[i], &has[i], e);
    if (s != LW_OK)
        return s;
    if (!has[0] || !has[3] || has[1] == has[2])
        return lw_json_fault(n, e, "a material needs \"E\" [N/m^2], \"density\" [kg/m^3] and either \"G\" [N/m^2] or \"nu\"");
    if (!(m->e > 0 && m->density > 0 && (has[1] ? m->g > 0 : nu > -1 && nu <= 0.5)))
        return lw_json_fault(n, e, "\"E\", \"G\" and \"density\" of a material are greater than 0, and \"nu\" lies between -1 and 0.5");
    if (has[2])
        m->g = m->e/(2*(1 + nu));
    return LW_OK;
}
