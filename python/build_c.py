"""Compile linkwright._c, the bridge to the C library, from linkwright.h by cffi.

Run by `make python`, which sets the environment, and by pip through setup.py:
    LINKWRIGHT_HEADER   linkwright.h                          (default: that of the tree this file stands in)
    LINKWRIGHT_LINK     how to link the library, with spaces  (default: pkg-config --libs linkwright)
"""
import os
import re
import shlex
import subprocess
from pathlib import Path

import cffi

HERE = Path(__file__).resolve().parent
HEADER = Path(os.environ.get("LINKWRIGHT_HEADER", HERE.parent / "linkwright.h"))

# Functions of Python that the library calls; `context` is a handle of the Python object concerned.
CALLBACKS = """
extern "Python" {
    bool      lw_py_progress(void *context, double done, double seconds, double best);
    lw_status lw_py_chain(void *context, const lw_chain *chain);
    lw_status lw_py_mechanism(void *context, const lw_mechanism *mechanism);
    lw_status lw_py_group(void *context, const lw_group_info *group);
    lw_status lw_py_range(void *context, const lw_input_range *range);
    lw_status lw_py_sample(void *context, const lw_simulation_sample *sample);
    lw_status lw_py_vibration(void *context, const lw_vibration_info *vibration);
    lw_status lw_py_spatial_trace(void *context, double at, const double *input, const lw_frame_motion *tracer);
    lw_status lw_py_spatial_sample(void *context, const lw_spatial_sample *sample);
    lw_status lw_py_row(void *context, int n_column, const char *const *name, const lw_value *value);
    lw_status lw_py_hit(void *context, const lw_catalogue_hit *hit);
    void      lw_py_note(void *context, const char *text);
    void      lw_py_force(void *context, double t, const lw_link_motion *link, lw_link_load *load);
}
"""


def declarations(header):
    """The declarations of the header without directives, as cffi reads them."""
    text = re.sub(r'^#include.*$|^#define LW_API.*$|\bLW_API\b', '', header.read_text(), flags=re.M)
    text = subprocess.run(["cc", "-E", "-P", "-x", "c", "-"], input=text, text=True, check=True,
                          stdout=subprocess.PIPE).stdout
    return text


def builder():
    ffi = cffi.FFI()
    ffi.cdef(declarations(HEADER) + CALLBACKS)
    link = os.environ.get("LINKWRIGHT_LINK")
    if link is None:
        link = subprocess.run(["pkg-config", "--libs", "linkwright"], text=True, check=True,
                              stdout=subprocess.PIPE).stdout
    ffi.set_source("linkwright._c", '#include "linkwright.h"', include_dirs=[str(HEADER.parent)],
                   extra_compile_args=["-O1", "-g0"],       # thin wrappers of the library; last, after the flags of the interpreter
                   extra_link_args=shlex.split(link))
    return ffi


if __name__ == "__main__":
    import sys
    builder().compile(tmpdir=sys.argv[1], verbose=False)
else:
    ffibuilder = builder()
