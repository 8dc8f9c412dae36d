/* tests/kept_system.h - a system that is freed at the end of its block. */
#ifndef LW_TESTS_KEPT_SYSTEM_H
#define LW_TESTS_KEPT_SYSTEM_H

#include "mbs/constraints/system.h"

#define KEPT_SYSTEM __attribute__((cleanup(lw_system_free))) lw_system

#endif
