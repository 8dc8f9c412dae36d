"""Models in space: bodies, joints, and how they move and what they carry."""
from __future__ import annotations

import os
from typing import NamedTuple, Optional, Union

import numpy as np

from ._c import ffi, lib
from ._core import Calls, check, interruptible, load, new_error, parse, plain, run_table, run_text, simulation_options, text_of, write


class Frames(NamedTuple):
    """How k points with axes move: arrays whose first axis is the sample, in ground axes; views of one array.

    Rates are by time, or in a trace over an input by that input [1/rad] or [1/m].
    """

    place: np.ndarray                    #: (n, k, 3) [m]
    velocity: np.ndarray                 #: (n, k, 3) [m/s]
    acceleration: np.ndarray             #: (n, k, 3) [m/s^2]
    turn: np.ndarray                     #: (n, k, 4) quaternion w, x, y, z; of a link since the posture of the file
    angular_velocity: np.ndarray         #: (n, k, 3) [rad/s]
    angular_acceleration: np.ndarray     #: (n, k, 3) [rad/s^2]


class SpatialTrace(NamedTuple):
    """What SpatialModel.trace gave."""

    at: np.ndarray                       #: (n) first input [rad] or [m], or time [s]
    input: np.ndarray                    #: (n, inputs) [rad] or [m]
    tracer: Frames                       #: of the tracers


class SpatialSimulation(NamedTuple):
    """What a run gave: arrays whose first axis is the sample."""

    t: np.ndarray                        #: (n) [s]
    link: Frames                         #: of the centres of mass; 0 for the ground
    tracer: Frames
    reaction: np.ndarray                 #: (n, joints, 6) force [N], moment [N m] on the joint's second link
    input: np.ndarray                    #: (n, inputs) [rad] or [m]
    rate: np.ndarray                     #: (n, inputs) [rad/s] or [m/s]
    drive: np.ndarray                    #: (n, drives, or inputs without drives) torque [N m] or force [N]
    energy: np.ndarray                   #: (n, 3) kinetic, potential, work done [J]; work NaN: every freedom is driven
    residual: np.ndarray                 #: (n) of the constraints, over the size of the model
    report: dict                         #: how it was computed
    coupling: np.ndarray                 #: (n, couplings) times a factor: torque [N m] or force [N] on the second link
    notes: list                          #: what was assumed, how accurate it is, its events

    __repr__, _repr_html_ = run_text, run_table


def _frames(rows, k):
    """Bytes of lw_frame_motion (k) of each sample as Frames."""
    numbers = np.frombuffer(b"".join(rows), np.float64).reshape(len(rows), k, ffi.sizeof("lw_frame_motion")//8)
    return Frames(*np.split(numbers, (3, 6, 9, 13, 16), axis=2))


def _numbers(rows, *shape):
    return np.frombuffer(b"".join(rows), np.float64).reshape(len(rows), *shape)


def _bytes(pointer, size):
    return bytes(ffi.buffer(pointer, size)) if size else b""


class SpatialModel:
    """Bodies and joints in space (docs/notation.md, "Spatial model")."""

    def __init__(self, handle):
        self._handle = ffi.gc(handle, lib.lw_spatial_destroy)

    @classmethod
    def load(cls, path: Union[str, os.PathLike]) -> "SpatialModel":
        """From a JSON file."""
        return cls(load("spatial", path))

    @classmethod
    def from_dict(cls, data: dict) -> "SpatialModel":
        """From what such a file holds."""
        return cls(parse("spatial", data))

    def _count(self, what):
        return lib.lw_spatial_count(self._handle, what)

    def _names(self, what):
        return [text_of(lib.lw_spatial_name(self._handle, what, i)) for i in range(self._count(what))]

    links = property(lambda self: self._names(b"l"), doc="names, the ground's too")
    joints = property(lambda self: self._names(b"j"), doc="names")
    tracers = property(lambda self: self._names(b"t"), doc="names")
    inputs = property(lambda self: self._names(b"i"), doc="names of their joints or tracers")
    drives = property(lambda self: self._names(b"d"), doc="names of their joints or tracers")

    def __repr__(self):
        return f"<linkwright.SpatialModel: {len(self.links)} links, {len(self.joints)} joints>"

    def drive(self, motion: str, input: int = 0) -> None:
        """Move an input by an expression of t: "0.5 + 10*t" [rad] or [m]."""
        error = new_error()
        check(lib.lw_spatial_set_motion(self._handle, input, motion.encode(), error), error)

    def export(self, format: str) -> bytes:
        """As "mjcf" (MuJoCo), "adams" or "acf"."""
        return write(lib.lw_spatial_export, self._handle, format.encode())

    def analyse_mobility(self, tolerance: float = 1e-12, seed: int = 1) -> dict:
        """How freely it moves, found by moving it: kind ("rigid", "shaky", "moves"), freedom, idle, redundant, ..."""
        info, error = ffi.new("lw_mobility_info *"), new_error()
        check(lib.lw_spatial_analyse_mobility(self._handle, tolerance, seed, info, error), error)
        return plain(info[0])

    def trace(self, n: int = 360, over: Optional[tuple[float, float]] = None,
              time: Optional[tuple[float, float]] = None) -> SpatialTrace:
        """Follow the tracers with n intervals: n + 1 rows.

        over: first and last value of the first input [rad] or [m] while the others stand still, None: its range in
        the file, or as far as it goes; or time: begin and end [s], by the motions of all inputs.  Error with status
        LW_OPEN where a limit or a singular posture lies before the end.
        """
        if over is not None and time is not None:
            raise ValueError("a trace goes over an input or over time, not both")
        begin, end = time or over or (0.0, 0.0)
        at, inputs, tracers = [], [], []
        n_input, n_tracer = self._count(b"i"), self._count(b"t")
        size = n_tracer*ffi.sizeof("lw_frame_motion")

        def visit(where, input, tracer):
            at.append(where)
            inputs.append(_bytes(input, 8*n_input))
            tracers.append(_bytes(tracer, size))

        self._run(lambda calls, error: lib.lw_spatial_trace(self._handle, time is not None, begin, end, n,
                                                            lib.lw_py_spatial_trace, calls.handle, error), visit)
        return SpatialTrace(np.array(at), _numbers(inputs, n_input), _frames(tracers, n_tracer))

    def simulate(self, to: float = 1.0, n: int = 100, **options) -> SpatialSimulation:
        """Run from 0 (or options' `from_`) to `to` [s] with n intervals: n + 1 samples; one of analysis="static".

        Options: analysis ("transient", "static", "quasistatic", "kinematic", "dynamic"), formulation ("auto",
        "driven", "index1", "cvode"), tolerance, max_steps, max_seconds, rigid.  Ctrl-C ends it.
        """
        keep, stop, report = [], ffi.new("int *"), ffi.new("lw_simulation_report *")
        what = simulation_options({**options, "to": to, "intervals": n}, keep)
        what.stop = stop
        links, tracers, joints, inputs, couplings = (self._count(k) for k in (b"l", b"t", b"j", b"i", b"c"))
        drives, frame = self._count(b"d") or inputs, ffi.sizeof("lw_frame_motion")
        samples = []

        def visit(s):
            samples.append((s.t, _bytes(s.link, links*frame), _bytes(s.tracer, tracers*frame), _bytes(s.joint, 48*joints),
                            _bytes(s.input, 8*inputs), _bytes(s.rate, 8*inputs), _bytes(s.drive, 8*drives),
                            (s.kinetic, s.potential, s.work), s.residual, _bytes(s.coupling, 8*couplings)))

        def work(calls, error):
            what.note.context, what.note.say = calls.handle, lib.lw_py_note
            return lib.lw_spatial_simulate(self._handle, what, lib.lw_py_spatial_sample, calls.handle, report, error)

        notes = self._run(work, visit, stop).notes
        t, link, tracer, joint, place, rate, drive, energy, residual, coupling = zip(*samples)
        return SpatialSimulation(np.array(t), _frames(link, links), _frames(tracer, tracers), _numbers(joint, joints, 6),
                                 _numbers(place, inputs), _numbers(rate, inputs), _numbers(drive, drives),
                                 np.array(energy), np.array(residual), plain(report[0]),
                                 _numbers(coupling, couplings), notes)

    @staticmethod
    def _run(work, visit, end=None):
        """Do work(calls, error), which calls visit; Ctrl-C ends it by the int at end, or at the next visit.  Returns calls."""
        calls, error = Calls(visit), new_error()

        def stop():
            calls.stopped = True
            if end:
                end[0] = 1

        status, interrupted = interruptible(lambda: work(calls, error), stop)
        if interrupted:
            raise KeyboardInterrupt
        calls.finish(status, error)
        return calls
