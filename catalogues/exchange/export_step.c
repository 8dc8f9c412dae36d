/* catalogues/exchange/export_step.c - plates and pins as an assembly of solids: STEP AP214 (ISO 10303-21, -42, -214).
 *
 * Each plate is a boundary representation: two planes with the outline and the holes as bounds, and a plane or a
 * cylinder for each side. Edges of a loop run counter-clockwise seen from above. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/real.h"
#include "catalogues/exchange/plates.h"

#define MM     1000.0
#define DIGITS 15

/* Instances 1 to 9 are those of put_head. */
enum { PRODUCT_CONTEXT = 3, DEFINITION_CONTEXT = 4, CONTEXT = 9 };

typedef struct writer { lw_bytes *out; int id; } writer;

/* Write instance #id = text; %d in the format are numbers of instances. Returns its number. */
__attribute__((format(printf, 2, 3))) static int put(writer *w, const char *format, ...)
{
    char line[512];
    va_list list;
    va_start(list, format);
    int n = snprintf(line, sizeof line, "#%d=", ++w->id);
    vsnprintf(line + n, sizeof line - (size_t)n, format, list);
    va_end(list);
    lw_bytes_text(w->out, line);
    lw_bytes_text(w->out, ";\n");
    return w->id;
}

/* Write KIND(#1,#2,...). */
static int put_list(writer *w, const char *before, const int *item, int n, const char *after)
{
    char text[24];
    snprintf(text, sizeof text, "#%d=", ++w->id);
    lw_bytes_text(w->out, text);
    lw_bytes_text(w->out, before);
    for (int i = 0; i < n; i++) {
        snprintf(text, sizeof text, "%s#%d", i ? "," : "", item[i]);
        lw_bytes_text(w->out, text);
    }
    lw_bytes_text(w->out, after);
    lw_bytes_text(w->out, ";\n");
    return w->id;
}

/* A number needs a decimal point. */
static void number(double v, char text[32])
{
    lw_number_text(text, fabs(v) < 1e-12 ? 0 : v, DIGITS);
    char *e = text;
    while (*e && *e != 'e' && *e != '.')
        e++;
    if (*e == '.')
        return;
    char tail[32];
    snprintf(tail, sizeof tail, "%s", e);
    snprintf(e, (size_t)(text + 32 - e), ".%s", tail);
}

static int put_triple(writer *w, const char *kind, double x, double y, double z)
{
    char a[32], b[32], c[32];
    number(x, a);
    number(y, b);
    number(z, c);
    return put(w, "%s('',(%s,%s,%s))", kind, a, b, c);
}

static int put_point(writer *w, lw_vec2 p, double z) { return put_triple(w, "CARTESIAN_POINT", MM*p.x, MM*p.y, MM*z); }

/* Axes at a point: z along (zx, zy, zz), x along (xx, xy, 0). */
static int put_axes(writer *w, lw_vec2 at, double height, double zx, double zy, double zz, double xx, double xy)
{
    int point = put_point(w, at, height), z = put_triple(w, "DIRECTION", zx, zy, zz);
    int x = zz == 0 ? put_triple(w, "DIRECTION", 0, 0, 1) : put_triple(w, "DIRECTION", xx, xy, 0);
    return put(w, "AXIS2_PLACEMENT_3D('',#%d,#%d,#%d)", point, z, x);
}

/* A text as STEP writes it: printable ASCII, quotes doubled. */
static void clean(const char *name, char *out, size_t size)
{
    size_t n = 0;
    for (; *name && n + 3 < size; name++) {
        unsigned char c = (unsigned char)*name;
        if (c == '\'')
            out[n++] = '\'';
        out[n++] = c >= ' ' && c < 127 && c != '\\' ? (char)c : '_';
    }
    out[n] = 0;
}

/* ---- solids ---------------------------------------------------------------------------------------------------- */

/* The edges of a loop: below, above, and upright at the beginning of each side. */
typedef struct edges { int n, *low, *high, *up; } edges;

static int put_line(writer *w, lw_vec2 a, double z, double dx, double dy, double dz)
{
    int point = put_point(w, a, z), direction = put_triple(w, "DIRECTION", dx, dy, dz);
    int vector = put(w, "VECTOR('',#%d,1.)", direction);
    return put(w, "LINE('',#%d,#%d)", point, vector);
}

static int put_side_curve(writer *w, const lw_plate_loop *l, int i, double z)
{
    const lw_plate_side *a = &l->side[i], *b = &l->side[(i + 1) % l->n];
    char radius[32];
    if (a->arc) {
        int axes = put_axes(w, a->centre, z, 0, 0, 1, 1, 0);
        number(MM*l->radius, radius);
        return put(w, "CIRCLE('',#%d,%s)", axes, radius);
    }
    lw_vec2 d = lw_v2_sub(b->from, a->from);
    double length = lw_v2_norm(d);
    return put_line(w, a->from, z, d.x/length, d.y/length, 0);
}

/* e has its arrays; vertex: room for 2 n. */
static void put_edges(writer *w, const lw_plate_loop *l, double low, double high, int *vertex, edges *e)
{
    for (int i = 0; i < l->n; i++)
        for (int k = 0; k < 2; k++) {
            int point = put_point(w, l->side[i].from, k ? high : low);
            vertex[2*i + k] = put(w, "VERTEX_POINT('',#%d)", point);
        }
    for (int i = 0; i < l->n; i++) {
        int next = (i + 1) % l->n;
        for (int k = 0; k < 2; k++) {
            int curve = put_side_curve(w, l, i, k ? high : low);
            (k ? e->high : e->low)[i] = put(w, "EDGE_CURVE('',#%d,#%d,#%d,.T.)", vertex[2*i + k], vertex[2*next + k], curve);
        }
        int curve = put_line(w, l->side[i].from, low, 0, 0, 1);
        e->up[i] = put(w, "EDGE_CURVE('',#%d,#%d,#%d,.T.)", vertex[2*i], vertex[2*i + 1], curve);
    }
}

static int oriented(writer *w, int edge, bool forward)
{
    return put(w, "ORIENTED_EDGE('',*,*,#%d,%s)", edge, forward ? ".T." : ".F.");
}

/* The face of side i. The material is inside an outline and outside a hole, and the edges run round the face
 * counter-clockwise, seen from where there is no material. */
static int put_side_face(writer *w, const lw_plate_loop *l, const edges *e, int i, double low, bool hole)
{
    int next = (i + 1) % l->n, edge[4];
    const lw_plate_side *a = &l->side[i];
    edge[0] = oriented(w, hole ? e->up[i] : e->low[i], true);
    edge[1] = oriented(w, hole ? e->high[i] : e->up[next], true);
    edge[2] = oriented(w, hole ? e->up[next] : e->high[i], false);
    edge[3] = oriented(w, hole ? e->low[i] : e->up[i], false);
    int loop = put_list(w, "EDGE_LOOP('',(", edge, 4, "))");
    int bound = put(w, "FACE_OUTER_BOUND('',#%d,.T.)", loop);
    if (a->arc) {
        char radius[32];
        number(MM*l->radius, radius);
        int axes = put_axes(w, a->centre, low, 0, 0, 1, 1, 0);
        int surface = put(w, "CYLINDRICAL_SURFACE('',#%d,%s)", axes, radius);
        return put(w, "ADVANCED_FACE('',(#%d),#%d,%s)", bound, surface, hole ? ".F." : ".T.");
    }
    lw_vec2 d = lw_v2_sub(l->side[next].from, a->from), out = lw_v2_scale(lw_v2_perp(d), (hole ? 1 : -1)/lw_v2_norm(d));
    int axes = put_axes(w, a->from, low, out.x, out.y, 0, 0, 0);
    int plane = put(w, "PLANE('',#%d)", axes);
    return put(w, "ADVANCED_FACE('',(#%d),#%d,.T.)", bound, plane);
}

/* The face above or below: the outline, and the holes the other way round. */
static int put_flat_face(writer *w, const lw_slab *s, const edges *all, bool above, int *bound, int *edge)
{
    for (int k = 0; k <= s->n_hole; k++) {
        const edges *e = &all[k];
        bool forward = above == (k == 0);
        for (int i = 0; i < e->n; i++) {
            int at = forward ? i : e->n - 1 - i;
            edge[i] = oriented(w, above ? e->high[at] : e->low[at], forward);
        }
        int loop = put_list(w, "EDGE_LOOP('',(", edge, e->n, "))");
        bound[k] = put(w, "FACE_%sBOUND('',#%d,.T.)", k ? "" : "OUTER_", loop);
    }
    int axes = put_axes(w, s->outline.side[0].from, above ? s->high : s->low, 0, 0, above ? 1 : -1, 1, 0);
    int plane = put(w, "PLANE('',#%d)", axes);
    char after[32];
    snprintf(after, sizeof after, "),#%d,.T.)", plane);
    return put_list(w, "ADVANCED_FACE('',(", bound, s->n_hole + 1, after);
}

/* Returns the number of the solid; 0: out of memory. */
static int put_solid(writer *w, const lw_slab *s, const char *name)
{
    size_t loops = (size_t)s->n_hole + 1, sides = (size_t)s->outline.n;
    for (int k = 0; k < s->n_hole; k++)
        sides += (size_t)s->hole[k].n;
    edges *all = malloc(loops*sizeof *all);
    int *memory = malloc((7*sides + 2 + loops)*sizeof *memory), n = 0;
    if (!all || !memory) {
        free(all);
        free(memory);
        return 0;
    }
    int *part = memory, *face = memory + 3*sides, *bound = face + sides + 2, *room = bound + loops;
    for (int k = 0; k <= s->n_hole; k++) {
        const lw_plate_loop *l = k ? &s->hole[k-1] : &s->outline;
        all[k] = (edges){ .n = l->n, .low = part, .high = part + l->n, .up = part + 2*l->n };
        part += 3*l->n;
        put_edges(w, l, s->low, s->high, room, &all[k]);
        for (int i = 0; i < l->n; i++)
            face[n++] = put_side_face(w, l, &all[k], i, s->low, k > 0);
    }
    face[n++] = put_flat_face(w, s, all, false, bound, room);
    face[n++] = put_flat_face(w, s, all, true, bound, room);
    int shell = put_list(w, "CLOSED_SHELL('',(", face, n, "))");
    int solid = put(w, "MANIFOLD_SOLID_BREP('%s',#%d)", name, shell);
    free(all);
    free(memory);
    return solid;
}

/* ---- the assembly ---------------------------------------------------------------------------------------------- */

typedef struct product { int definition, shape, axes; } product;

/* A product with its shape: `items` are axes and a solid, or the axes of the parts. */
static product put_product(writer *w, const char *name, const int *items, int n, bool solid)
{
    product p = { 0, 0, items[0] };
    char before[160], after[16];
    int made = put(w, "PRODUCT('%s','%s','',(#%d))", name, name, PRODUCT_CONTEXT);
    put(w, "PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#%d))", made);
    int formation = put(w, "PRODUCT_DEFINITION_FORMATION('','',#%d)", made);
    p.definition = put(w, "PRODUCT_DEFINITION('design','',#%d,#%d)", formation, DEFINITION_CONTEXT);
    int about = put(w, "PRODUCT_DEFINITION_SHAPE('','',#%d)", p.definition);
    snprintf(before, sizeof before, "%s('%s',(", solid ? "ADVANCED_BREP_SHAPE_REPRESENTATION" : "SHAPE_REPRESENTATION", name);
    snprintf(after, sizeof after, "),#%d)", CONTEXT);
    p.shape = put_list(w, before, items, n, after);
    put(w, "SHAPE_DEFINITION_REPRESENTATION(#%d,#%d)", about, p.shape);
    return p;
}

/* Put a part into the assembly, at the place where it is drawn. */
static void put_use(writer *w, const product *whole, const product *part, int axes, int number_of, const char *name)
{
    int use = put(w, "NEXT_ASSEMBLY_USAGE_OCCURRENCE('%d','%s','',#%d,#%d,$)", number_of, name, whole->definition, part->definition);
    int about = put(w, "PRODUCT_DEFINITION_SHAPE('placement','',#%d)", use);
    int move = put(w, "ITEM_DEFINED_TRANSFORMATION('','',#%d,#%d)", part->axes, axes);
    int relation = put(w, "(REPRESENTATION_RELATIONSHIP('','',#%d,#%d)REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#%d)"
                       "SHAPE_REPRESENTATION_RELATIONSHIP())", part->shape, whole->shape, move);
    put(w, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#%d,#%d)", relation, about);
}

static void put_head(writer *w, const char *name, const char *note)
{
    lw_bytes_text(w->out, "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('plates and pins of a linkage; ");
    lw_bytes_text(w->out, note);
    lw_bytes_text(w->out, "'),'2;1');\nFILE_NAME('");
    lw_bytes_text(w->out, name);
    lw_bytes_text(w->out, "','2000-01-01T00:00:00',(''),(''),'linkwright','linkwright','');\n"
                  "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n");
    put(w, "APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
    put(w, "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#1)");
    put(w, "PRODUCT_CONTEXT('',#1,'mechanical')");
    put(w, "PRODUCT_DEFINITION_CONTEXT('part definition',#1,'design')");
    put(w, "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    put(w, "(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    put(w, "(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
    put(w, "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-06),#5,'distance_accuracy_value','')");
    put(w, "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#8))"
        "GLOBAL_UNIT_ASSIGNED_CONTEXT((#5,#6,#7))REPRESENTATION_CONTEXT('',''))");
}

lw_status lw_export_step(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    writer w = { .out = out };
    lw_plates *plates;
    char name[2*LW_NAME_SIZE + 32], note[120];
    lw_status s = lw_plates_make(linkage, o, &plates, e);
    if (s != LW_OK)
        return s;
    if ((s = lw_plates_check_holes(plates, e)) != LW_OK) {
        lw_plates_free(plates);
        return s;
    }
    int n = lw_plates_count(plates);
    lw_slab slab;
    product *part = malloc((size_t)n*sizeof *part);
    int *axes = malloc((size_t)(n + 1)*sizeof *axes);
    bool ok = part && axes;
    lw_plates_room(plates, note, sizeof note);
    clean(linkage->name[0] ? linkage->name : "linkage", name, sizeof name);
    if (ok)
        put_head(&w, name, note);
    for (int i = 0; ok && i < n; i++) {
        lw_plates_slab(plates, i, &slab);
        clean(slab.name, name, sizeof name);
        int item[2] = { put_axes(&w, lw_v2(0, 0), 0, 0, 0, 1, 1, 0), 0 };
        ok = (item[1] = put_solid(&w, &slab, name)) > 0;
        part[i] = put_product(&w, name, item, 2, true);
    }
    for (int i = 0; ok && i <= n; i++)
        axes[i] = put_axes(&w, lw_v2(0, 0), 0, 0, 0, 1, 1, 0);
    clean(linkage->name[0] ? linkage->name : "linkage", name, sizeof name);
    product whole = { 0 };
    if (ok)
        whole = put_product(&w, name, axes, n + 1, false);
    for (int i = 0; ok && i < n; i++) {
        lw_plates_slab(plates, i, &slab);
        clean(slab.name, name, sizeof name);
        put_use(&w, &whole, &part[i], axes[i+1], i + 1, name);
    }
    lw_bytes_text(out, "ENDSEC;\nEND-ISO-10303-21;\n");
    lw_plates_free(plates);
    free(part);
    free(axes);
    if (!ok) {
        lw_bytes_free(out);
        return lw_error_set(e, LW_E_MEMORY, "out of memory for solids");
    }
    return lw_bytes_end(out, e);
}
