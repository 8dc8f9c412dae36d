#include "base/status.h"

const char *lw_status_text(lw_status s)
{
    switch (s) {
#define X(name, code, text) case name: return text;
    LW_STATUS_LIST(X)
#undef X
    }
    return "no such status";
}

const char *lw_status_name(lw_status s)
{
    switch (s) {
#define X(name, code, text) case name: return #name;
    LW_STATUS_LIST(X)
#undef X
    }
    return "LW_?";
}
