/* base/status.h - the status that a function returns.
 *
 * One list defines the names, numbers and texts.  Numbers >= 0 are outcomes: the function did its work.  Numbers < 0 are
 * failures: nothing was done. */
#ifndef LW_BASE_STATUS_H
#define LW_BASE_STATUS_H

#include "linkwright.h"     /* LW_STATUS_LIST, lw_status */

/* Text of a status; never NULL, even for a number that is not a status. */
const char *lw_status_text(lw_status s);

/* Name of a status, "LW_OK" ...; "LW_?" for a number that is not a status. */
const char *lw_status_name(lw_status s);

#endif
