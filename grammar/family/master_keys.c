/* grammar/family/master_keys.c - what the expander of master files knows of the keys of a model. */
#include "grammar/family/master_internal.h"

#include <string.h>

#define PLACE   LW_KEY_POINT, true
#define POSTURE LW_KEY_PLAIN, true
#define SI      LW_KEY_PLAIN, false

static const lw_key keys[] = {           /* rows with a parent before those without */
    { "damping", "at", SI, { "Hz", "rad/s" } }, { "damping", "ratio", SI, { "1" } },
    { "elastic", "axis", PLACE, { "m" } },
    { "cone", "angle", POSTURE, { "rad" } },
    { "frame", "x", LW_KEY_DIRECTION, false, { "1", "m" } }, { "frame", "y", LW_KEY_DIRECTION, false, { "1", "m" } },
    { "frame", "z", LW_KEY_DIRECTION, false, { "1", "m" } },
    { NULL, "at", PLACE, { "m" } }, { NULL, "centre", PLACE, { "m" } },
    { NULL, "along", LW_KEY_DIRECTION, true, { "1", "m" } }, { NULL, "axis", LW_KEY_DIRECTION, true, { "1", "m" } },
    { NULL, "second_axis", LW_KEY_DIRECTION, true, { "1", "m" } },
    { NULL, "angle", LW_KEY_ANGLE, true, { "rad" } },
    { NULL, "value", POSTURE, { "rad", "m" } }, { NULL, "first", POSTURE, { "rad", "m" } },
    { NULL, "last", POSTURE, { "rad", "m" } }, { NULL, "least", POSTURE, { "rad", "m" } },
    { NULL, "greatest", POSTURE, { "rad", "m" } }, { NULL, "free", POSTURE, { "m", "rad" } },
    { NULL, "radius", POSTURE, { "m" } }, { NULL, "gap", POSTURE, { "m" } }, { NULL, "depth", POSTURE, { "m" } },
    { NULL, "lead", POSTURE, { "m", "m/rad" } }, { NULL, "ratio", POSTURE, { "1", "m/rad", "rad/m" } },
    { NULL, "mass", SI, { "kg" } }, { NULL, "inertia", LW_KEY_TENSOR, false, { "kg m^2" } },
    { NULL, "gravity", LW_KEY_DIRECTION, false, { "m/s^2" } },
    { NULL, "velocity", LW_KEY_DIRECTION, false, { "m/s" } },
    { NULL, "angular_velocity", LW_KEY_DIRECTION, false, { "rad/s" } },
    { NULL, "speed", SI, { "m/s", "rad/s" } }, { NULL, "friction_speed", SI, { "m/s" } },
    { NULL, "free_speed", SI, { "rad/s", "m/s" } }, { NULL, "stall", SI, { "N m", "N" } },
    { NULL, "stiffness", SI, { "N/m", "N m/rad", "N/m^2" } }, { NULL, "damping", SI, { "N s/m", "N m s/rad", "s" } },
    { NULL, "coefficient", SI, { "1" } }, { NULL, "restitution", SI, { "1" } }, { NULL, "exponent", SI, { "1" } },
    { NULL, "friction", SI, { "1", "N" } },
    { NULL, "bore", POSTURE, { "m" } }, { NULL, "rod", POSTURE, { "m" } }, { NULL, "retracted", POSTURE, { "m" } },
    { NULL, "stroke", POSTURE, { "m" } }, { NULL, "dead_volume", SI, { "m^3" } }, { NULL, "bulk_modulus", SI, {
         "Pa" } },
    { NULL, "pressures", SI, { "Pa" } }, { NULL, "drop", SI, { "Pa" } }, { NULL, "supply", SI, { "Pa" } },
    { NULL, "tank", SI, { "Pa" } }, { NULL, "relief", SI, { "Pa" } }, { NULL, "flow", SI, { "m^3/s" } },
    { NULL, "stop_stiffness", SI, { "N/m" } }, { NULL, "stop_damping", SI, { "N s/m" } },
    { NULL, "resistance", SI, { "ohm" } }, { NULL, "inductance", SI, { "H" } },
    { NULL, "torque_constant", SI, { "N m/A" } }, { NULL, "current", SI, { "A" } }, { NULL, "voltage", SI, { "V" } },
    { NULL, "filter", SI, { "s" } }, { NULL, "unwind", SI, { "s" } },
    { NULL, "fx", LW_KEY_FORCE, false, { "N" } }, { NULL, "fy", LW_KEY_FORCE, false, { "N" } },
    { NULL, "fz", LW_KEY_FORCE, false, { "N" } }, { NULL, "tx", LW_KEY_FORCE, false, { "N m" } },
    { NULL, "ty", LW_KEY_FORCE, false, { "N m" } }, { NULL, "tz", LW_KEY_FORCE, false, { "N m" } },
    { NULL, "torque", SI, { "N m" } }, { NULL, "motion", SI, { "rad", "m" } },
    { NULL, "width", POSTURE, { "m" } }, { NULL, "height", POSTURE, { "m" } }, { NULL, "diameter", POSTURE, { "m" } },
    { NULL, "wall", POSTURE, { "m" } }, { NULL, "web", POSTURE, { "m" } }, { NULL, "flange", POSTURE, { "m" } },
    { NULL, "area", POSTURE, { "m^2" } }, { NULL, "Iy", POSTURE, { "m^4" } }, { NULL, "Iz", POSTURE, { "m^4" } },
    { NULL, "It", POSTURE, { "m^4" } }, { NULL, "zeta", SI, { "1" } }, { NULL, "E", SI, { "Pa" } },
    { NULL, "G", SI, { "Pa" } }, { NULL, "nu", SI, { "1" } }, { NULL, "density", SI, { "kg/m^3" } },
    { NULL, "segments", SI, { "1" } }, { NULL, "frequency", SI, { "Hz", "rad/s" } },
};

const lw_key *lw_key_find(const char *parent, const char *key)
{
    for (size_t i = 0; i < sizeof keys/sizeof *keys; i++)
        if (strcmp(keys[i].key, key) == 0 && (!keys[i].parent || (parent && strcmp(keys[i].parent, parent) == 0)))
            return &keys[i];
    return NULL;
}
