/* grammar/model/drive_parts.h - motors, gears and amplifiers, from tables (docs/drive.md, "Catalogue of parts").
 *
 * A table is CSV: a header with column names, each with its unit in brackets when it is not SI, as in "speed [rpm]";
 * one part in a line; lines that begin with # are comments.  The columns tell what the parts are. */
#ifndef LW_GRAMMAR_MODEL_DRIVE_PARTS_H
#define LW_GRAMMAR_MODEL_DRIVE_PARTS_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"

/* X(member, unit, needed): numbers of a part in SI units; 0 where they are left out. */
#define LW_MOTOR_COLUMN_LIST(X) \
    X(torque_constant, "N m/A", 1) X(resistance, "ohm", 1) X(inductance, "H", 0) X(inertia, "kg m^2", 1) \
    X(torque, "N m", 1) X(torque_peak, "N m", 0) X(speed, "rad/s", 1) X(mass, "kg", 0) X(price, "1", 0)
#define LW_GEAR_COLUMN_LIST(X) \
    X(ratio, "1", 1) X(radius, "m", 0) X(efficiency, "1", 0) X(inertia, "kg m^2", 0) X(torque, "N m", 0) \
    X(torque_peak, "N m", 0) X(speed, "rad/s", 0) X(mass, "kg", 0) X(price, "1", 0)
#define LW_AMPLIFIER_COLUMN_LIST(X) \
    X(voltage, "V", 1) X(current, "A", 1) X(current_peak, "A", 0) X(peak_time, "s", 0) X(mass, "kg", 0) X(price, "1", 0)

#define LW_PART_NAME 64
#define MEMBER(member, unit, needed) double member;
/* torque: continuous; torque_peak: 0 is 3 times the continuous one; speed: the greatest. */
typedef struct lw_motor_part { char name[LW_PART_NAME]; LW_MOTOR_COLUMN_LIST(MEMBER) } lw_motor_part;
/* ratio: motor turns per turn of the output; radius: of a pinion or wheel that moves a slider; torques at the output,
 * speed at the input; 0: no limit, no loss, no inertia. */
typedef struct lw_gear_part { char name[LW_PART_NAME]; LW_GEAR_COLUMN_LIST(MEMBER) } lw_gear_part;
/* current: continuous; current_peak for peak_time after a rest; 0: the continuous one. */
typedef struct lw_amplifier_part { char name[LW_PART_NAME]; LW_AMPLIFIER_COLUMN_LIST(MEMBER) } lw_amplifier_part;
#undef MEMBER

struct lw_drive_parts {
    int n_motor, n_gear, n_amplifier;
    lw_motor_part     *motor;
    lw_gear_part      *gear;
    lw_amplifier_part *amplifier;
};                              /* { 0 } is empty */

/* Does the text begin with the header of such a table? */
bool      lw_drive_parts_is(const char *text, size_t size);

/* Append the parts of a table.  LW_E_NOTATION with line and column; p is then unchanged. */
lw_status lw_drive_parts_read(const char *text, size_t size, const char *file, lw_drive_parts *p, lw_error *e);
void      lw_drive_parts_free(lw_drive_parts *p);

/* The columns of a kind: 0 motors, 1 gears, 2 amplifiers; NULL past the last one.  value: the member of a part. */
typedef struct lw_part_column { const char *name, *unit; int needed; size_t place; } lw_part_column;
const lw_part_column *lw_part_columns(int kind);
int lw_part_count(const lw_drive_parts *p, int kind);
const char *lw_part_name(const lw_drive_parts *p, int kind, int i);
double *lw_part_value(const lw_drive_parts *p, int kind, int i, const lw_part_column *c);
/* Append an empty part; NULL: out of memory. */
char *lw_part_add(lw_drive_parts *p, int kind);

#endif
