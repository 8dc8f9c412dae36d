/* mbs/drives/servo_run.h - simulation of a servo axis. */
#ifndef LW_MBS_DRIVES_SERVO_RUN_H
#define LW_MBS_DRIVES_SERVO_RUN_H

#include "grammar/model/servo.h"      /* types and functions: linkwright.h */

#endif
