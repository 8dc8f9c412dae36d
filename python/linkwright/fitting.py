"""Dimensions that do a job: targets, fits, ranked results."""
from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Callable, Optional, Union

import numpy as np

from ._c import ffi, lib
from ._core import Calls, Stopped, check, fill, interruptible, make, new_error, plain, text_of, write
from .linkage import Linkage, doubles, pointer


class Target:
    """Stations that a point, or an output angle, has to meet.  Arrays [m], [rad]; closed: None by guess."""

    def __init__(self, x=None, y=None, theta=None, angle=None, weight=None, closed: Optional[bool] = None):
        given = [None if values is None else doubles(values) for values in (x, y, theta, angle, weight)]
        sizes = {values.size for values in given if values is not None}
        if len(sizes) != 1:
            raise ValueError("a target needs arrays of one length")
        pointers = [ffi.NULL if values is None else pointer(values) for values in given]
        target = make("target", lib.lw_target_create, sizes.pop(), *pointers, -1 if closed is None else int(closed))
        self._handle = ffi.gc(target, lib.lw_target_destroy)

    @classmethod
    def load(cls, path: Union[str, os.PathLike], **options) -> "Target":
        """From CSV, SVG or DXF.  Options: closed (1, 0, -1), length_unit, angle_unit, curve, stations, smooth."""
        keep = []
        what = fill(ffi.new("lw_target_options *", {"closed": -1}), options, keep)
        target = cls.__new__(cls)
        target._handle = ffi.gc(make("target", lib.lw_target_load, os.fsencode(path), what), lib.lw_target_destroy)
        return target

    def __len__(self):
        return lib.lw_target_n(self._handle)

    @property
    def note(self) -> str:
        """What was assumed when it was read: the curve of a drawing, a unit, how far smoothing moved the points."""
        return ffi.string(lib.lw_target_note(self._handle)).decode()

    @property
    def closed(self) -> bool:
        return lib.lw_target_closed(self._handle)

    @property
    def length(self) -> float:
        """Of the polygon through the stations [m]."""
        return lib.lw_target_length(self._handle)

    def _arrays(self):
        arrays = ffi.new("const double *[4]")
        lib.lw_target_stations(self._handle, arrays, arrays + 1, arrays + 2, arrays + 3)
        return [None if a == ffi.NULL else np.frombuffer(ffi.buffer(a, 8*len(self)), np.float64).copy() for a in arrays]

    x = property(lambda self: self._arrays()[0], doc="(n) [m], or None")
    y = property(lambda self: self._arrays()[1], doc="(n) [m], or None")
    theta = property(lambda self: self._arrays()[2], doc="(n) [rad], or None")
    angle = property(lambda self: self._arrays()[3], doc="(n) [rad], or None")


class Result:
    """One linkage that was found.  Attributes: those of lw_result_info in linkwright.h, such as title, links,
    error_mean, error_max [m], error_percent, transmission [rad], turns, verified."""

    def __init__(self, results, number):
        self._results, self._number = results, number
        info = ffi.new("lw_result_info *")
        check(lib.lw_results_info(results, number, info))
        self.info: dict = plain(info[0])

    def __getattr__(self, name):
        try:
            return self.__dict__["info"][name]
        except KeyError:
            raise AttributeError(name) from None

    @property
    def linkage(self) -> Linkage:
        """In the posture of the first station; tracer 0 is the point that was fitted."""
        return Linkage(make("linkage", lib.lw_results_linkage, self._results, self._number, has_error=False))

    @property
    def dimensions(self) -> dict[str, float]:
        found, value, i = {}, ffi.new("double *"), 0
        while (name := lib.lw_results_dimension(self._results, self._number, i, value)) != ffi.NULL:
            found[text_of(name)] = value[0]
            i += 1
        return found

    def __repr__(self):
        return f"<linkwright.Result {self.title}, mean error {self.error_mean:.3g} m>"

    def _repr_svg_(self):
        return self.linkage._repr_svg_()


class Results(Sequence):
    """Linkages that were found, best first."""

    def __init__(self, handle, target):
        self._handle, self._target = ffi.gc(handle, lib.lw_results_destroy), target

    def __len__(self):
        return lib.lw_results_count(self._handle)

    def __getitem__(self, i):
        if isinstance(i, slice):
            return [self[k] for k in range(*i.indices(len(self)))]
        if not -len(self) <= i < len(self):
            raise IndexError(i)
        return Result(self._handle, i % len(self))

    def inputs(self, i: int = 0) -> np.ndarray:
        """(stations): input of result i at each [rad] or [m], as Kinematics counts."""
        values = np.empty(len(self._target))
        check(lib.lw_results_inputs(self._handle, i, pointer(values)))
        return values

    def page(self, title: str = "linkwright") -> str:
        """All results with moving pictures as one HTML page."""
        return write(lib.lw_results_page, self._handle, title.encode()).decode()

    def _repr_html_(self):
        rows = "".join(
            f"<tr><td>{i}</td><td>{r.title}</td><td>{1000*r.error_mean:.4g}</td><td>{1000*r.error_max:.4g}</td>"
            f"<td>{np.degrees(r.transmission[0]):.0f}</td><td>{'turns' if r.turns else 'rocks'}</td></tr>"
            for i, r in enumerate(self))
        return ("<table><tr><th></th><th>mechanism</th><th>mean error [mm]</th><th>greatest [mm]</th>"
                f"<th>least transmission angle [&deg;]</th><th>input</th></tr>{rows}</table>")


def _search(function, target, progress, options):
    keep, error, stop, out = [], new_error(), ffi.new("int *"), ffi.new("lw_results **")
    what = ffi.new("lw_fit_request *", lib.lw_fit_request_default())
    for name, kind in (("bound", "lw_bound[]"), ("zone", "lw_zone[]")):
        rows = options.pop(name, ())
        keep.append(ffi.new(kind, len(rows)))
        for row, values in zip(keep[-1], rows):
            for field, value in values.items():
                setattr(row, field, value.encode() if isinstance(value, str) else value)
        setattr(what, name, keep[-1])
        setattr(what, "n_" + name, len(rows))
    start = [linkage._handle for linkage in options.pop("start", ())]
    keep.append(ffi.new("lw_linkage *[]", start))
    what.start, what.n_start = keep[-1], len(start)
    fill(what, options, keep, special=("stop", "progress", "context", "n_start", "n_bound", "n_zone"))
    calls = Calls(progress=progress)
    what.stop, what.progress, what.context = stop, lib.lw_py_progress, calls.handle
    status, interrupted = interruptible(lambda: function(target._handle, what, out, error), stop)
    results = Results(out[0], target) if out[0] != ffi.NULL else []
    if interrupted:
        raise Stopped(results)
    calls.finish(status, error, allowed=(lib.LW_STOPPED, lib.LW_NOTHING))
    return results


def fit(target: Target, progress: Optional[Callable[[float, float, float], Optional[bool]]] = None, **request):
    """Ranked linkages for a path, function or motion: Results, empty when no linkage meets the conditions.

    progress(done, seconds, best): called during the search; return False to end it.  Ctrl-C raises Stopped with what
    was found.  request: fields of lw_fit_request in linkwright.h, such as types="fourbar,slidercrank", links=6,
    crank_only=True, min_transmission=0.5 [rad], length_range=(0.01, 0.3) [m], max_seconds=5, seed=1, results=10;
    bound=[{"name": "r1", "lo": 0.1, "hi": 0.1}]; start=[linkages].
    """
    return _search(lib.lw_fit_target, target, progress, request)


def precision_points(target: Target, progress: Optional[Callable[[float, float, float], Optional[bool]]] = None, **request):
    """Linkages that pass through every station exactly: 2 to 5 poses, 3 to 5 pairs of a function, 2 to 9 points."""
    return _search(lib.lw_fit_precision_points, target, progress, request)
