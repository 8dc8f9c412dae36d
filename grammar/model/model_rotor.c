/* grammar/model/model_rotor.c - rotors of motors that are links of their own: they turn on the first link of the motor's joint, geared to the second.
 *
 * The file gives a rotor's inertia about its axis alone; its mass, and its inertia across the axis, are part of those of the carrier.  A small part of them is
 * put on the rotor, so that no formulation meets a massless link: the rotor's centre is that of the carrier, and across its axis it turns with the
 * carrier, so that both together are the body of the file in any motion. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "grammar/model/model_internal.h"

static const double share = 1e-3;                /* of the carrier's mass and inertia */

/* Room for more parts, zeroed. */
static bool grow(void *array, int n, int more, size_t size)
{
    void **at = array;
    char *grown = realloc(*at, (size_t)(n + more)*size + 1);
    if (!grown)
        return false;
    memset(grown + (size_t)n*size, 0, (size_t)more*size);
    *at = grown;
    return true;
}

#define GROW(array, n, more) grow(&(array), n, more, sizeof *(array))

static int count(const lw_states *z)
{
    int n = 0;
    for (int i = 0; i < z->n_rotor; i++)
        n += z->rotor[i].link < 0;
    return n;
}

/* Keep the others in the list. */
static void keep_others(lw_states *z)
{
    int n = 0;
    for (int i = 0; i < z->n_rotor; i++)
        if (z->rotor[i].link >= 0)
            z->rotor[n++] = z->rotor[i];
    z->n_rotor = n;
}

/* The name MOTOR.part, which none of n others may have. */
static lw_status put_name(const lw_json_node *root, const lw_rotor *r, const char *part, char name[LW_NAME_SIZE], const char *first, size_t stride, int n,
                          lw_error *e)
{
    snprintf(name, LW_NAME_SIZE, "%.*s%s", (int)(LW_NAME_SIZE - sizeof LW_ROTOR_LINK), r->name, part);
    return lw_read_find(NULL, name, first, stride, n) < 0 ? LW_OK
         : lw_json_fault(root, e, "the rotor of motor \"%s\" gets a part \"%s\", and the file has one of that name; rename one of them", r->name, name);
}

/* An elastic link has no mass of its own to share, and carries no gear. */
static lw_status refuse_elastic(const lw_json_node *root, const lw_rotor *r, const char *link, const char *joint, lw_error *e)
{
    return lw_json_fault(root, e, "the rotor of motor \"%s\" is geared at joint \"%s\" of the elastic link \"%s\", which is not supported: weld a rigid link "
                         "to it for this joint", r->name, joint, link);
}

/* A place for a pin where no other is: links on one pin could all carry the gear. */
static lw_vec2 free_place(const lw_assembly *a, lw_vec2 at)
{
    for (int j = 0; j < a->n_joint; j++)
        if (a->joint[j].at.x == at.x && a->joint[j].at.y == at.y) {
            at.x = nextafter(at.x, INFINITY);
            j = -1;
        }
    return at;
}

static lw_status add_planar(const lw_json_node *root, lw_model *m, const lw_rotor *r, lw_error *e)
{
    lw_assembly *a = &m->linkage;
    const lw_joint driven = a->joint[r->joint];
    lw_joint *pin = &a->joint[a->n_joint], *gear = pin + 1;
    int link = a->n_link;
    for (int end = 0; end < 2; end++)
        if (m->elastic[driven.link[end]].given)
            return refuse_elastic(root, r, a->link_name[driven.link[end]], driven.name, e);
    lw_status s = put_name(root, r, LW_ROTOR_LINK, a->link_name[link], (const char *)a->link_name, sizeof *a->link_name, link, e);
    if (s == LW_OK)
        s = put_name(root, r, LW_ROTOR_LINK, pin->name, a->joint->name, sizeof *a->joint, a->n_joint, e);
    if (s == LW_OK)
        s = put_name(root, r, LW_ROTOR_GEAR, gear->name, a->joint->name, sizeof *a->joint, a->n_joint, e);
    if (s != LW_OK)
        return s;
    pin->kind = LW_JOINT_REVOLUTE;
    pin->link[0] = driven.link[0], pin->link[1] = link;
    lw_body *carrier = &m->body[driven.link[0]];
    pin->at = free_place(a, carrier->mass > 0 ? carrier->centre : driven.at);
    gear->kind = LW_JOINT_GEAR;
    gear->link[0] = driven.link[1], gear->link[1] = link;
    gear->at = pin->at;
    gear->ratio = r->ratio;
    m->body[link] = (lw_body){ .given = true, .mass = share*carrier->mass, .centre = pin->at, .inertia = r->inertia };
    carrier->mass -= share*carrier->mass;
    a->n_link++;
    a->n_joint += 2;
    return LW_OK;
}

lw_status lw_model_add_rotors(const lw_json_node *root, lw_model *m, lw_error *e)
{
    int k = count(&m->states), links = m->linkage.n_link, joints = m->linkage.n_joint;
    lw_status s = LW_OK;
    if (k > 0 && !(GROW(m->linkage.link_name, links, k) && GROW(m->body, links, k) && GROW(m->elastic, links, k) && GROW(m->linkage.joint, joints, 2*k) &&
                   GROW(m->friction, joints, 2*k) && GROW(m->stop, joints, 2*k) && GROW(m->clearance, joints, 2*k)))
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < m->states.n_rotor; i++)
        if (m->states.rotor[i].link < 0)
            s = add_planar(root, m, &m->states.rotor[i], e);
    keep_others(&m->states);
    return s;
}

/* A part of the inertia of a body that it has about all axes: 4 det/trace^2 is no more than the least principal value. */
static double common_inertia(const double i[6])
{
    double trace = i[0] + i[1] + i[2];
    double det = i[0]*(i[1]*i[2] - i[5]*i[5]) - i[3]*(i[3]*i[2] - i[5]*i[4]) + i[4]*(i[3]*i[5] - i[1]*i[4]);
    return trace > 0 && det > 0 ? 4*share*det/(trace*trace) : 0;
}

static lw_status add_spatial(const lw_json_node *root, lw_spatial *m, const lw_rotor *r, lw_error *e)
{
    const lw_spatial_joint driven = m->joint[r->joint];
    lw_spatial_joint *shaft = &m->joint[m->n_joint];
    lw_spatial_coupling *c = &m->coupling[m->n_coupling];
    int link = m->n_link;
    lw_vec3 n = driven.axis;
    const double along[6] = { n.x*n.x, n.y*n.y, n.z*n.z, n.x*n.y, n.x*n.z, n.y*n.z };
    if (m->elastic[driven.link[0]].given)
        return refuse_elastic(root, r, m->body[driven.link[0]].name, driven.name, e);
    lw_status s = put_name(root, r, LW_ROTOR_LINK, m->body[link].name, m->body->name, sizeof *m->body, link, e);
    if (s == LW_OK)
        s = put_name(root, r, LW_ROTOR_LINK, shaft->name, m->joint->name, sizeof *m->joint, m->n_joint, e);
    if (s == LW_OK)
        s = put_name(root, r, LW_ROTOR_GEAR, c->name, m->coupling->name, sizeof *m->coupling, m->n_coupling, e);
    if (s != LW_OK)
        return s;
    c->of = calloc(2, sizeof *c->of);
    c->factor = calloc(2, sizeof *c->factor);
    m->n_coupling++;
    if (!c->of || !c->factor)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    c->n = 2;
    bool turns = driven.kind == LW_SPATIAL_REVOLUTE;
    c->of[0] = (lw_spatial_measure){ turns ? LW_OF_TURN : LW_OF_SLIDE, r->joint };
    c->of[1] = (lw_spatial_measure){ LW_OF_TURN, m->n_joint };
    c->factor[0] = turns ? -r->ratio : -1;
    c->factor[1] = turns ? 1 : 1/r->ratio;       /* a sum with a slide is a length */
    shaft->kind = LW_SPATIAL_REVOLUTE;
    shaft->link[0] = driven.link[0], shaft->link[1] = link;
    shaft->at = m->body[driven.link[0]].mass > 0 ? m->body[driven.link[0]].centre : driven.at;
    shaft->axis = n;
    lw_spatial_body *carrier = &m->body[driven.link[0]], *rotor = &m->body[link];
    double common = common_inertia(carrier->inertia);
    rotor->given = true;
    rotor->mass = share*carrier->mass;
    rotor->centre = carrier->mass > 0 ? carrier->centre : driven.at;
    carrier->mass -= rotor->mass;
    for (int i = 0; i < 6; i++) {
        double across = common*((i < 3) - along[i]);
        rotor->inertia[i] = r->inertia*along[i] + across;
        carrier->inertia[i] -= across;
    }
    m->n_link++;
    m->n_joint++;
    return LW_OK;
}

lw_status lw_spatial_add_rotors(const lw_json_node *root, lw_spatial *m, lw_error *e)
{
    int k = count(&m->states);
    lw_status s = LW_OK;
    if (k > 0 && !(GROW(m->body, m->n_link, k) && GROW(m->elastic, m->n_link, k) && GROW(m->joint, m->n_joint, k) && GROW(m->coupling, m->n_coupling, k)))
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < m->states.n_rotor; i++)
        if (m->states.rotor[i].link < 0)
            s = add_spatial(root, m, &m->states.rotor[i], e);
    keep_others(&m->states);
    return s;
}
