/* catalogues/exchange/export.h - a linkage as a file that another program runs.
 *
 * Every writer appends text to out in SI units (metres, radians), numbers with 15 digits; out is freed after a failure.
 * LW_E_KIND: the format cannot express the linkage; LW_E_MEMORY. */
#ifndef LW_CATALOGUES_EXCHANGE_EXPORT_H
#define LW_CATALOGUES_EXCHANGE_EXPORT_H

#include <signal.h>
#include "base/bytes.h"
#include "grammar/model/model.h"

/* Optional content of a file beside the linkage. A writer uses the parts that its format can hold; its text below names
 * them. NULL: the linkage alone, with plates of the usual size. */
typedef struct lw_export_options {
    const lw_model *model;             /* of the same linkage, with masses and loads; NULL: none             */
    double width, thickness, hole;     /* of plates: a bar's width, thickness, diameter of holes [m]; 0: usual */
    double clearance;                  /* a pin's diameter is smaller than its hole by this [m]; < 0: usual    */
    const volatile sig_atomic_t *stop; /* ends the motion of the plates and the search for layers: LW_STOPPED  */
} lw_export_options;

/* MuJoCo's MJCF. Bodies are the moving links, nested along a spanning tree of the joints, all parallel to the world
 * in the posture of the file. Pins are hinges about z, sliders slides, slots both. Equality constraints close the
 * other joints: connect for pins, weld for sliders and welds, joint for gears. The coordinate of a joint counts as
 * an lw_input does and has the same value in the posture. Tracers are sites with a position sensor.
 *   Without masses the links are steel rods that do not collide, there is no gravity, and every input has a drive. With
 * a model the file holds masses, gravity, springs and dampers, motors, constant forces, stops and ropes, and inputs without a
 * motion run freely. Velocities at the start are in the keyframe. A free body has two slides and a hinge. Drives, loops and the
 * step of time are chosen so that the file is stable when stepped. LW_E_KIND, naming it: a load that MJCF cannot hold, or a speed
 * beside a motion; failures of lw_export_start (catalogues/exchange/start.h). */
lw_status lw_export_mjcf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);

/* Robot descriptions. URDF: a tree of bodies; joints that close a loop are named in a comment and left out. SDF 1.7: a
 * model in which these are joints too; the engine must support loops. Bodies are steel rods, or have the masses of the
 * model with dampers (SDF: and springs) at joints. LW_E_KIND: gears, other loads. */
lw_status lw_export_urdf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);
lw_status lw_export_sdf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);

/* A dataset of ADAMS/Solver (.adm; catalogues/exchange/adams.h reads it): PART, MARKER, JOINT, JPRIM, COUPLER, MOTION,
 * REQUEST. A MOTION is the input's own, in the words of ADAMS; without one it turns its joint once in a second, or moves it there
 * and back over its range. Without masses the file is for kinematics. With a model it holds masses, gravity, springs and dampers,
 * motors at pins and constant forces, inputs without a motion run freely, and parts have velocities at the start. LW_E_KIND,
 * naming it: another load, a motion in other words, a speed beside a motion; failures of lw_export_start. _commands: the
 * command file (.acf) that runs <name>.adm for a second. */
lw_status lw_export_adams(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);
lw_status lw_export_adams_commands(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);

/* LW_E_KIND, naming the first: the model has variables of first order or values that stand on them (motors with a circuit, controllers,
 * hydraulic cylinders, integrals and lags of expressions), which no format here can hold. */
lw_status lw_export_states(const lw_states *z, const char *format, lw_error *e);

/* How far input `input` can move to either side of the posture [rad] or [m]: over its range; without one, as far as the linkage goes. *turns: a full turn;
 * *ends: limits of the linkage are known on both sides. m: the model of a linkage too large for an lw_linkage; else it may be NULL. LW_E_MEMORY. */
lw_status lw_export_way(const lw_assembly *linkage, const lw_model *m, int input, double *down, double *up, bool *turns, bool *ends);

/* The motion in time that a dataset gives an input: one turn in a second, or once there and back within 0.99 of its
 * range; it starts from the posture, where time and displacement u are 0.
 *     u = 2 pi t    or    u = half (sin(2 pi t + phase) - sin(phase))     [rad] or [m], t in [s] */
typedef struct lw_export_law { bool turns; double half, phase; } lw_export_law;
lw_status lw_export_law_of(const lw_assembly *linkage, const lw_model *m, int input, lw_export_law *law);     /* LW_E_MEMORY */

/* There and back within this part of the ways to either side of the posture [rad] or [m]. */
void lw_export_law_within(double down, double up, double part, lw_export_law *law);

/* Plates in millimetres, in layers in which they pass each other over the whole motion; failures as in layers.h. DXF
 * R12 for a cutter: outlines of lines and arcs, holes, slots, side by side, one DXF layer for each link. OpenSCAD:
 * the plates in their layers, on pins, moving with $t. */
lw_status lw_export_dxf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);
lw_status lw_export_openscad(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);

/* The same plates and pins as solids in the posture, in millimetres. STEP AP214: an assembly of one product for each
 * plate and pin, with planes and cylinders. STL: a closed mesh for each, circles with 48 sides. LW_E_KIND: holes of a
 * plate that meet. */
lw_status lw_export_step(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);
lw_status lw_export_stl(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);

/* A sketch of SolveSpace in millimetres: points and lines of each link, and constraints; it can be dragged as the
 * linkage moves. LW_E_KIND: gears, welds. */
lw_status lw_export_solvespace(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);

/* The motion in LW_EXPORT_FRAMES postures. CSV: frame, input, link, x and y of the link's reference point, and its
 * angle, a row for each link and posture, in the linkage's units. SVG: the coupler curves as paths in millimetres, y
 * down. JSON in the style of MotionGen: joints with coordinates, links as lists of joints, the actuator, tracers
 * with their curves. LW_E_KIND: no motion is known. */
#define LW_EXPORT_FRAMES 180
lw_status lw_export_poses(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);
lw_status lw_export_svg(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);
lw_status lw_export_joints(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e);

/* The two joints that a gear joint couples: pin or slider of side i on the carrier, and the sign with which the
 * joint's count enters the movement of side i against the carrier, so that
 *     sign[1] count(joint[1]) = ratio sign[0] count(joint[0]).
 * LW_E_KIND: a side is not itself joined to the carrier; failures of lw_linkage_gear. */
lw_status lw_export_gear(const lw_assembly *linkage, int gear, int joint[2], double sign[2], lw_error *e);

/* Value of an expression without variables; 0 of NULL.  Has it variables? */
double lw_export_constant(const lw_expression *x);
bool   lw_export_varies(const lw_expression *x);

/* Size of the linkage: the greatest distance of a joint or tracer from the first joint [m]. */
double lw_export_size(const lw_assembly *linkage);

#endif
