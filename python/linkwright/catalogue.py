"""What was enumerated and found, kept in one SQLite file."""
from __future__ import annotations

import os
from typing import Callable, NamedTuple, Optional, Union

from ._c import ffi, lib
from ._core import Calls, chars, check, fill, interruptible, make, new_error, text_of
from .linkage import Linkage


class Hit(NamedTuple):
    """A coupler curve near a target."""

    distance: float            #: root mean square, over the size of the target
    distance_m: float          #: the same [m]
    family: str                #: "crank-rocker"; "": a linkage that was added
    linkage: Linkage           #: laid on the target; tracer 0 draws the curve, an open one over the range of its input
    turns: Optional[bool]      #: the input turns fully; None: not known
    transmission: float        #: least transmission angle on the curve [rad]; NaN: not known


def _value(value):
    if value.kind == lib.LW_VALUE_INTEGER:
        return value.integer
    if value.kind == lib.LW_VALUE_REAL:
        return value.real
    if value.kind == lib.LW_VALUE_NULL:
        return None
    data = bytes(ffi.buffer(value.text, value.size))
    return data.decode() if value.kind == lib.LW_VALUE_TEXT else data


class Catalogue:
    """One catalogue file; used by one thread.  One program writes at a time, any number may read."""

    def __init__(self, path: Union[str, os.PathLike], write: bool = False, wait: float = 5.0):
        catalogue = make("catalogue", lib.lw_catalogue_open, os.fsencode(path), write, wait)
        self._handle = ffi.gc(catalogue, lib.lw_catalogue_close)

    def close(self) -> None:
        ffi.release(self._handle)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _work(self, function, *arguments, count=True, progress=None, **options):
        keep, error, n, stop = [], new_error(), ffi.new("uint64_t *"), ffi.new("int *")
        calls = Calls(progress=progress)
        work = fill(ffi.new("lw_catalogue_work *"), options, keep, special=("progress", "context", "stop"))
        work.progress, work.context, work.stop = lib.lw_py_progress, calls.handle, stop
        status, interrupted = interruptible(
            lambda: function(self._handle, *arguments, work, *([n] if count else []), error), stop)
        if interrupted:
            raise KeyboardInterrupt
        calls.finish(status, error, allowed=(lib.LW_STOPPED,))
        return n[0]

    def add_chains(self, links: int, dof: int = 1, kinds: str = "r", progress: Optional[Callable] = None, **work) -> int:
        """Every chain with so many links; returns how many the catalogue holds.  A stopped call goes on later."""
        return self._work(lib.lw_catalogue_add_chains, links, dof, kinds.encode(), progress=progress, **work)

    def add_linkages(self, text: str) -> int:
        """Linkages as JSON text; returns how many were new."""
        n, error, data = ffi.new("uint64_t *"), new_error(), text.encode()
        check(lib.lw_catalogue_add_linkages(self._handle, data, len(data), ffi.NULL, n, error), error)
        return n[0]

    def add_curves(self, samples: int, types: Optional[str] = "fourbar", links: int = 4,
                   progress: Optional[Callable] = None, **work) -> None:
        """Coupler curves, until there are so many samples of this seed."""
        keep = []
        self._work(lib.lw_catalogue_add_curves, chars(types, keep), links, samples, count=False, progress=progress,
                   **work)

    def _rows(self, ask):
        found, error = [], new_error()

        def visit(n, names, values):
            found.append({text_of(names[i]): _value(values[i]) for i in range(n)})

        calls = Calls(visit)
        calls.finish(ask(calls, error), error, allowed=(lib.LW_NOTHING,))
        return found

    def query(self, question: Optional[str] = None, list: Optional[str] = None, columns: Optional[str] = None,
              sort: Optional[str] = None, limit: int = 0) -> "list[dict]":
        """Rows that answer a question such as "links=6 and sliders>=1" (docs/catalogue.md)."""
        keep = []
        return self._rows(lambda calls, error: lib.lw_catalogue_query(
            self._handle, chars(question, keep), chars(list, keep), chars(columns, keep), chars(sort, keep), limit,
            lib.lw_py_row, calls.handle, error))

    def sql(self, select: str) -> "list[dict]":
        """Rows of one SELECT of SQL; it may only read."""
        return self._rows(lambda calls, error: lib.lw_catalogue_sql(
            self._handle, select.encode(), lib.lw_py_row, calls.handle, error))

    def nearest(self, target, count: int = 10, turns: bool = False, min_transmission: float = 0,
                min_length: float = 0, max_length: float = 0) -> "list[Hit]":
        """The coupler curves nearest to the path of a target, nearest first, among linkages whose input turns fully,
        whose transmission angle is at least min_transmission [rad] and whose lengths between pins are within
        min_length..max_length [m] (0, 0: any)."""
        found, error = [], new_error()

        def visit(hit):
            linkage = Linkage(make("linkage", lib.lw_linkage_copy, hit.linkage, has_error=False))
            found.append(Hit(hit.distance, hit.distance_m, text_of(hit.family), linkage,
                             None if hit.turns < 0 else hit.turns == 1, hit.transmission))

        only = ffi.new("lw_catalogue_filter *", {"turns": turns, "min_transmission": min_transmission,
                                                 "min_length": min_length, "max_length": max_length})
        calls = Calls(visit)
        calls.finish(lib.lw_catalogue_nearest(self._handle, target._handle, only, count, lib.lw_py_hit, calls.handle,
                                              error), error, allowed=(lib.LW_NOTHING,))
        return found

    def check(self) -> None:
        """Check every page, reference and sum; Error with the first fault."""
        error = new_error()
        check(lib.lw_catalogue_check(self._handle, error), error)
