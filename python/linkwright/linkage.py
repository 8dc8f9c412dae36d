"""Linkages: mechanisms with dimensions, and how they move."""
from __future__ import annotations

import json
import os
from typing import NamedTuple, Optional, Union

import numpy as np

from ._c import ffi, lib
from ._core import Calls, chars, check, load, make, new_error, plain, take_text, text_of, write

FULL_TURN = 2*np.pi


def doubles(values) -> np.ndarray:
    """(n) contiguous doubles of any sequence; no copy where it is such an array already."""
    return np.ascontiguousarray(values, dtype=np.float64)


_DOUBLES, _POINTS = ffi.typeof("double[]"), ffi.typeof("lw_vec2[]")        # types by name cost more in every call


def pointer(array):
    """double * into a contiguous array of doubles, which must outlive its use."""
    return ffi.from_buffer(_DOUBLES, array)


def picture(handle, kind, width=0, height=0):
    """Bytes of a picture in a format; the picture is freed."""
    handle = ffi.gc(handle, lib.lw_picture_destroy)
    return write(lib.lw_picture_write, handle, kind.encode(), width, height)


def _parts(owner, what, handle):
    """Infos of all joints, inputs or tracers of a linkage or a model."""
    info, found = ffi.new(f"lw_{what}_info *"), []
    for i in range(getattr(lib, f"lw_{owner}_n_{what}")(handle)):
        check(getattr(lib, f"lw_{owner}_{what}")(handle, i, info))
        found.append(plain(info[0]))
    return found


def joints_of(owner, handle):
    joints = _parts(owner, "joint", handle)
    for joint in joints:
        joint["kind"] = joint["kind"].decode()
    return joints


def inputs_of(owner, handle):
    return _parts(owner, "input", handle)


def tracers_of(owner, handle):
    return _parts(owner, "tracer", handle)


class Trace(NamedTuple):
    """A tracer's path: arrays (n)."""

    input: np.ndarray          #: [rad] or [m]
    x: np.ndarray              #: [m]
    y: np.ndarray              #: [m]
    angle: np.ndarray          #: of the tracer's link [rad]
    margin: np.ndarray         #: squared sine of the least transmission angle; negative where it cannot close


class Posture(NamedTuple):
    """One posture with derivatives 0 to order by the input."""

    joint: np.ndarray          #: (joints, order + 1, 2) [m]
    link_angle: np.ndarray     #: (links, order + 1) [rad]
    tracer: np.ndarray         #: (tracers, order + 1, 2) [m]
    margin: float              #: squared sine of the least transmission angle; negative where it cannot close


class Curve(NamedTuple):
    """One circuit of a linkage, through all its assembly modes: n points evenly along it."""

    input: np.ndarray          #: (n) [rad] or [m]
    x: np.ndarray              #: (n) [m]
    y: np.ndarray              #: (n) [m]
    info: dict                 #: closed, input_turns, limits, crossings, residual


class Linkage:
    """Links, joints in one assembled posture, inputs, and tracers: points to watch."""

    def __init__(self, handle, owner=None):
        self._handle = handle if owner is not None else ffi.gc(handle, lib.lw_linkage_destroy)
        self._owner = owner

    @classmethod
    def load(cls, path: Union[str, os.PathLike]) -> "Linkage":
        """From a file: JSON, Pyslvs, PMKS or ADAMS."""
        return cls(load("linkage", path))

    @classmethod
    def from_text(cls, text: str, format: Optional[str] = None) -> "Linkage":
        """From "json", "pyslvs", "adams" or "pmks"; None: found from how the text begins."""
        keep, data = [], text.encode()
        return cls(make("linkage", lib.lw_linkage_parse, data, len(data), ffi.NULL, chars(format, keep)))

    @classmethod
    def from_dict(cls, data: dict) -> "Linkage":
        """From what a JSON file of a linkage holds (docs/notation.md, "Linkage")."""
        return cls.from_text(json.dumps(data), "json")

    def to_dict(self) -> dict:
        return json.loads(self.export("json"))

    def copy(self) -> "Linkage":
        return Linkage(make("linkage", lib.lw_linkage_copy, self._handle, has_error=False))

    def export(self, format: str) -> bytes:
        """As "json", "pyslvs", "pmks", "adams", "acf", "mjcf", "dxf", "scad", "slvs", "svg", "poses", "motiongen"."""
        return write(lib.lw_linkage_export, self._handle, format.encode())

    def save(self, path: Union[str, os.PathLike], format: Optional[str] = None) -> None:
        """Write a file; format None: by the end of its name."""
        error, keep = new_error(), []
        check(lib.lw_linkage_save(self._handle, chars(format, keep), os.fsencode(path), error), error)

    def picture(self, kind: str = "svg", target=None, title: Optional[str] = None, width: int = 0,
                height: int = 0) -> bytes:
        """Drawing with its curves as "svg", "pdf", "png", "gif" or "html"; the last two move."""
        keep = []
        stations = ffi.NULL if target is None else target._handle
        drawn = make("picture", lib.lw_picture_of_linkage, self._handle, stations, chars(title, keep))
        return picture(drawn, kind, width, height)

    @property
    def name(self) -> Optional[str]:
        return text_of(lib.lw_linkage_name(self._handle))

    @name.setter
    def name(self, name: str):
        lib.lw_linkage_set_name(self._handle, name.encode())

    @property
    def links(self) -> int:
        return lib.lw_linkage_n_link(self._handle)

    @property
    def ground(self) -> int:
        return lib.lw_linkage_ground(self._handle)

    @property
    def mobility(self) -> int:
        """Gruebler's count; analyse_mobility() tells what is true of these lengths."""
        return lib.lw_linkage_mobility(self._handle)

    @property
    def joints(self) -> list[dict]:
        """name, kind (r t p g f), link, at, along, ratio of each."""
        return joints_of("linkage", self._handle)

    @property
    def inputs(self) -> list[dict]:
        """joint, value, first, last, ratio of each."""
        return inputs_of("linkage", self._handle)

    @property
    def tracers(self) -> list[dict]:
        """name, link, at, angle of each."""
        return tracers_of("linkage", self._handle)

    def set_tracer(self, tracer: int, link: int, at: tuple[float, float], angle: float = 0,
                   name: Optional[str] = None) -> None:
        """Change tracer 0, 1, ..., or add one with the next number."""
        error, keep = new_error(), []
        info = ffi.new("lw_tracer_info *", {"name": chars(name, keep), "link": link,
                                            "at": {"x": at[0], "y": at[1]}, "angle": angle})
        check(lib.lw_linkage_set_tracer(self._handle, tracer, info, error), error)

    def mechanism(self):
        """Its topology."""
        from .topology import Mechanism
        return Mechanism(make("mechanism", lib.lw_linkage_mechanism, self._handle))

    def lay(self, turn: float = 0, size: float = 1, shift: tuple[float, float] = (0, 0), mirrored: bool = False) -> None:
        """Mirror in the x axis if so, then turn [rad], scale and move [m]."""
        lib.lw_linkage_lay(self._handle, mirrored, turn, size, {"x": shift[0], "y": shift[1]})

    def kinematics(self) -> "Kinematics":
        """Prepared for evaluation at many inputs, in the assembly mode of its posture."""
        return Kinematics(self)

    def trace(self, n: int = 360, tracer: int = 0) -> Trace:
        """Path of a tracer at n inputs over the range that the posture lies in."""
        return self.kinematics().trace(n, tracer)

    def curves(self, n: int = 360, tracer: int = 0, patience: int = 40, seed: int = 1) -> list[Curve]:
        """Every motion of a linkage with one free input, one for each circuit; the first holds the posture.

        Found from random postures; the search ends after `patience` of them without a new curve.
        """
        curves = make("motion_curves", lib.lw_motion_curves_create, self._handle, patience, seed)
        curves, found = ffi.gc(curves, lib.lw_motion_curves_destroy), []
        for i in range(lib.lw_motion_curves_count(curves)):
            info, arrays = ffi.new("lw_motion_curve_info *"), [np.empty(n) for _ in range(3)]
            check(lib.lw_motion_curves_info(curves, i, info))
            check(lib.lw_motion_curves_trace(curves, i, tracer, n, *map(pointer, arrays)))
            found.append(Curve(*arrays, plain(info[0])))
        return found

    def analyse_mobility(self, tolerance: float = 1e-12, seed: int = 1) -> dict:
        """How freely it moves, found by moving it: kind ("rigid", "shaky", "moves"), freedom, idle, redundant, ..."""
        info, error = ffi.new("lw_mobility_info *"), new_error()
        check(lib.lw_linkage_analyse_mobility(self._handle, tolerance, seed, info, error), error)
        return plain(info[0])

    def __repr__(self):
        return f"<linkwright.Linkage {self.name or ''!r} with {self.links} links>"

    def _repr_svg_(self):
        return self.picture("svg").decode()


class Kinematics:
    """A linkage prepared for many inputs.  Pins count from the x axis of the ground frame.

    One object belongs to one thread at a time.  dimensions: by name; setting one keeps topology and assembly mode.
    """

    def __init__(self, linkage: Linkage):
        self._handle = ffi.gc(make("kinematics", lib.lw_kinematics_create, linkage._handle), lib.lw_kinematics_destroy)
        self._count = (lib.lw_linkage_n_joint(linkage._handle), linkage.links,
                       lib.lw_linkage_n_tracer(linkage._handle))
        names = (lib.lw_kinematics_dimension_name(self._handle, i)
                 for i in range(lib.lw_kinematics_n_dimension(self._handle)))
        self._number = {text_of(name): i for i, name in enumerate(names)}

    @property
    def input(self) -> float:
        """Input of the posture [rad] or [m]."""
        return lib.lw_kinematics_input(self._handle)

    @property
    def turns(self) -> int:
        """Turns of the input in one period: more than 1 with gears of fractional ratio."""
        return lib.lw_kinematics_turns(self._handle)

    @property
    def dimensions(self) -> dict[str, float]:
        return {name: lib.lw_kinematics_dimension(self._handle, i) for name, i in self._number.items()}

    def set_dimensions(self, **dimensions: float) -> None:
        for name, value in dimensions.items():
            if name not in self._number:
                raise KeyError(f"no dimension {name!r}; there are: {', '.join(self._number)}")
            check(lib.lw_kinematics_set_dimension(self._handle, self._number[name], value))

    def ranges(self) -> list[dict]:
        """Where the input can stand, in every assembly mode: first, last, turns, limit, circuit, own, transmission."""
        found = []
        calls = Calls(lambda info: found.append(plain(info[0])))
        calls.finish(lib.lw_kinematics_ranges(self._handle, lib.lw_py_range, calls.handle))
        return found

    def own_range(self, n: int) -> np.ndarray:
        """n inputs over the range that holds the posture; a full turn begins at the posture and leaves out its end."""
        own = next(info for info in self.ranges() if info["own"])
        if own["turns"]:
            return self.input + np.arange(n)*(FULL_TURN*self.turns/n)
        return np.linspace(own["first"], own["last"], n)

    def trace(self, inputs, tracer: int = 0) -> Trace:
        """Path of a tracer at these inputs (an array, or how many over its own range)."""
        inputs = self.own_range(inputs) if isinstance(inputs, int) else doubles(inputs)
        n, found = inputs.size, np.empty((4, inputs.size))
        to = pointer(found)
        status = lib.lw_kinematics_trace(self._handle, tracer, n, pointer(inputs), to, to + n, to + 2*n, to + 3*n)
        if status:
            check(status)
        return Trace(inputs, found[0], found[1], found[2], found[3])      # *found costs 0.5 us more

    def trace_into(self, inputs: np.ndarray, x: np.ndarray, y: np.ndarray, tracer: int = 0) -> None:
        """The path into arrays that exist (contiguous doubles): no memory is allocated, inputs are not checked to
        close."""
        if not len(inputs) == len(x) == len(y):
            raise ValueError("inputs, x and y need one length")
        status = lib.lw_kinematics_trace(self._handle, tracer, len(inputs), pointer(inputs), pointer(x), pointer(y),
                                         ffi.NULL, ffi.NULL)
        if status:
            check(status)

    def posture(self, input: float, order: int = 0) -> Posture:
        """One posture with derivatives by the input up to order (at most 3); Error with status LW_OPEN where it cannot
        close."""
        n_joint, n_link, n_tracer = self._count
        joint, tracer = np.empty((n_joint, order + 1, 2)), np.empty((n_tracer, order + 1, 2))
        angle, margin = np.empty((n_link, order + 1)), ffi.new("double *")
        status = lib.lw_kinematics_posture(self._handle, input, order, ffi.from_buffer(_POINTS, joint), pointer(angle),
                                           ffi.from_buffer(_POINTS, tracer), margin)
        if status:
            check(status)
        return Posture(joint, angle, tracer, margin[0])

    def linkage(self, input: float) -> Linkage:
        """The linkage in the posture at this input."""
        return Linkage(make("linkage", lib.lw_kinematics_linkage, self._handle, input))

    def explain(self) -> str:
        """The Assur groups in the order of solution and how each is solved."""
        out = ffi.new("char **")
        check(lib.lw_kinematics_explain(self._handle, out))
        return take_text(out[0])


class FourBarClass(NamedTuple):
    """What the lengths of a four-bar say about its motion (Barker 1985); angles in rad."""

    number: int
    symbol: str
    name: str
    grashof: bool
    crank: bool
    rocker_turns: bool
    margin: float
    circuits: int
    limits: tuple
    dead: tuple
    transmission: tuple
    ranges: tuple


def classify(frame: float, input: float, coupler: float, output: float, tolerance: float = 1e-12) -> FourBarClass:
    """Class of a four-bar by its lengths, in any unit."""
    info, error = ffi.new("lw_fourbar_class *"), new_error()
    check(lib.lw_fourbar_classify([frame, input, coupler, output], tolerance, info, error), error)
    return FourBarClass(info.number, text_of(info.symbol), text_of(info.name), info.grashof, info.crank,
                        info.rocker_turns, info.margin, info.circuits, tuple(info.limit[0:info.n_limit]),
                        tuple(info.dead[0:info.n_dead]), tuple(info.transmission),
                        tuple(tuple(info.range[i]) for i in range(info.n_range)))
