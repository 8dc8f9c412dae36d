"""Models with masses, loads and springs, and their simulation."""
from __future__ import annotations

import os
from typing import Callable, Optional, Union

import numpy as np

from ._c import ffi, lib
from ._core import (Calls, Error, chars, check, interruptible, load, make, new_error, parse, plain, run_table, run_text, simulation_options,
                    take_bytes, text_of, write)
from .linkage import Linkage, inputs_of, joints_of, picture, tracers_of


class Simulation:
    """What a run gave: arrays whose first axis is the sample.

    t (n) [s]; link (n, links, 6): x, y, x velocity, y velocity of the centre of mass, angle since the drawn posture,
    angular velocity; acceleration (n, links, 3); reaction (n, joints, 3): force and moment on the joint's second
    link; input, drive (n, inputs); tracer (n, tracers, 2); state (n, states) in the order of Model.states; shaking
    (n, 3); energy (n, 3): kinetic, potential, work done; residual (n); node (n, nodes, 9) of elastic links: link, number
    along it, x, y, turn, tension, shear force, bending moment, stress.  report: how it was computed; notes: what was assumed, how accurate it is, its events.
    """

    t: np.ndarray
    link: np.ndarray
    acceleration: np.ndarray
    reaction: np.ndarray
    input: np.ndarray
    drive: np.ndarray
    tracer: np.ndarray
    state: np.ndarray
    shaking: np.ndarray
    energy: np.ndarray
    residual: np.ndarray
    node: np.ndarray
    report: dict
    notes: list[str]

    def __init__(self, samples, report, notes):
        names = ("t", "link", "acceleration", "reaction", "input", "drive", "tracer", "state", "shaking", "energy",
                 "residual", "node")
        for name, column in zip(names, zip(*samples)):
            setattr(self, name, np.array(column))
        self.report, self.notes = report, notes

    __repr__, _repr_html_ = run_text, run_table


def _copy(cdata, shape):
    """A copy of C doubles, or of structs of them, as an array."""
    count = int(np.prod(shape))
    if not count:
        return np.empty(shape)
    return np.frombuffer(ffi.buffer(cdata, 8*count), np.float64).reshape(shape).copy()


def _nodes(sample):
    """Nodes of elastic links as rows."""
    rows = [(p.link, p.number, p.at.x, p.at.y, p.turn, p.normal, p.shear, p.bending, p.stress)
            for p in (sample.node[i] for i in range(sample.n_node))]
    return np.array(rows).reshape(sample.n_node, 9)


class Model:
    """A linkage with masses, loads, springs, motions and clearances."""

    def __init__(self, linkage: Union[Linkage, "ffi.CData"]):
        if isinstance(linkage, Linkage):
            linkage = make("model", lib.lw_model_create, linkage._handle, has_error=False)
        self._handle = ffi.gc(linkage, lib.lw_model_destroy)

    @classmethod
    def load(cls, path: Union[str, os.PathLike]) -> "Model":
        """From a JSON file (docs/notation.md, "Model")."""
        return cls(load("model", path))

    @classmethod
    def from_dict(cls, data: dict) -> "Model":
        return cls(parse("model", data))

    @property
    def linkage(self) -> Linkage:
        """Error: the model has more than 32 links, 64 joints, 8 inputs or 16 tracers."""
        found = lib.lw_model_linkage(self._handle)
        if found == ffi.NULL:
            raise Error("the model has more parts than a Linkage holds (32 links, 64 joints, 8 inputs, 16 tracers): "
                        "use links, joints, inputs, tracers, export and picture of the model", "LW_E_KIND")
        return Linkage(ffi.cast("lw_linkage *", found), owner=self)

    @property
    def links(self) -> int:
        return lib.lw_model_n_link(self._handle)

    @property
    def link_names(self) -> list[str]:
        return [text_of(lib.lw_model_link_name(self._handle, i)) for i in range(self.links)]

    @property
    def joints(self) -> list[dict]:
        return joints_of("model", self._handle)

    @property
    def inputs(self) -> list[dict]:
        return inputs_of("model", self._handle)

    @property
    def tracers(self) -> list[dict]:
        return tracers_of("model", self._handle)

    def export(self, format: str) -> bytes:
        """As Linkage.export, with masses and loads where the format holds them; for models of any size."""
        return write(lib.lw_model_export, self._handle, format.encode(), ffi.NULL)

    def picture(self, kind: str = "svg", title: Optional[str] = None, width: int = 0, height: int = 0) -> bytes:
        """As Linkage.picture, for models of any size."""
        keep = []
        drawn = make("picture", lib.lw_picture_of_model, self._handle, ffi.NULL, chars(title, keep))
        return picture(drawn, kind, width, height)

    @property
    def states(self) -> list[str]:
        """Names of the first-order states (docs/notation.md, "States")."""
        return [text_of(lib.lw_model_state_name(self._handle, i)) for i in range(lib.lw_model_n_state(self._handle))]

    def drive(self, motion: str, input: int = 0) -> None:
        """Move an input by an expression of t: "0.5 + 10*t" [rad] or [m]."""
        error = new_error()
        check(lib.lw_model_drive(self._handle, input, motion.encode(), error), error)

    def set_speed(self, speed: float, input: int = 0) -> None:
        """Speed at the start [rad/s] or [m/s]; the input is free afterwards."""
        check(lib.lw_model_set_speed(self._handle, input, speed))

    def set_mass(self, link: int, mass: float, centre: tuple[float, float], inertia: float) -> None:
        """Mass [kg], its centre in the drawn posture [m], inertia about the centre [kg m^2]."""
        check(lib.lw_model_set_mass(self._handle, link, mass, {"x": centre[0], "y": centre[1]}, inertia))

    def set_gravity(self, x: float, y: float) -> None:
        """[m/s^2]"""
        lib.lw_model_set_gravity(self._handle, {"x": x, "y": y})

    def simulate(self, to: float = 1.0, n: int = 100, force: Optional[Callable] = None, **options) -> Simulation:
        """Run from 0 (or options' `from_`) to `to` [s] with n intervals: n + 1 samples.

        force(t, motion, load): your own loads; motion (links, 6) as in Simulation.link, load (links, 3): write force
        and torque into it.  Options: analysis ("transient", "static", "quasistatic", "kinematic", "dynamic"),
        formulation ("auto"), tolerance (1e-7 suits elastic links), max_steps, max_seconds, rigid (elastic links as
        rigid bars), once (no estimate of the error of contacts by a second run).  Ctrl-C ends it.
        """
        keep, error, stop, samples = [], new_error(), ffi.new("int *"), []
        what = simulation_options({**options, "to": to, "intervals": n}, keep)
        what.stop = stop
        links, joints, inputs, tracers = (getattr(lib, "lw_model_n_" + what)(self._handle)
                                          for what in ("link", "joint", "input", "tracer"))
        states = lib.lw_model_n_state(self._handle)

        def visit(s):
            samples.append((s.t, _copy(s.link, (links, 6)), _copy(s.acceleration, (links, 3)),
                            _copy(s.joint, (joints, 3)), _copy(s.input, (inputs,)), _copy(s.drive, (inputs,)),
                            _copy(s.tracer, (tracers, 2)), _copy(s.state, (states,)),
                            (s.shaking.force.x, s.shaking.force.y, s.shaking.moment),
                            (s.kinetic, s.potential, s.work), s.residual, _nodes(s)))

        def apply(t, link, load):
            force(t, np.frombuffer(ffi.buffer(link, 48*links), np.float64).reshape(links, 6),
                  np.frombuffer(ffi.buffer(load, 24*links), np.float64).reshape(links, 3))

        calls = Calls(visit, force=apply)
        what.note.context, what.note.say = calls.handle, lib.lw_py_note
        if force is not None:
            what.force.context, what.force.apply = calls.handle, lib.lw_py_force
        out, report = ffi.new("lw_simulation **"), ffi.new("lw_simulation_report *")
        calls.finish(lib.lw_simulation_create(self._handle, what, out, error), error)
        simulation = ffi.gc(out[0], lib.lw_simulation_destroy)
        status, interrupted = interruptible(
            lambda: lib.lw_simulation_run(simulation, lib.lw_py_sample, calls.handle, report, error), stop)
        if interrupted:
            raise KeyboardInterrupt
        calls.finish(status, error)
        return Simulation(samples, plain(report[0]), calls.notes)

    def vibrations(self, rest: bool = False, hold: bool = False) -> list[dict]:
        """Small vibrations about the drawn posture, or the equilibrium near it: re, im [1/s], frequency, natural [Hz],
        damping; hold: all inputs are held."""
        found, error = [], new_error()
        calls = Calls(lambda info: found.append(plain(info[0])))
        calls.finish(lib.lw_model_vibrations(self._handle, rest, hold, lib.lw_py_vibration, calls.handle, error), error)
        return found


class Stepper:
    """A simulation in pieces: advance(t), look at t, link, state, change loads and states, go on.

    link (links, 6) as in Simulation.link; state: a dict by name.  save() gives bytes; restore(bytes) goes back to that
    moment, and what follows then has the same bits.  Options: formulation, tolerance, from_ (start [s]).
    """

    def __init__(self, model: Model, **options):
        keep = []
        what = simulation_options(options, keep)
        self._model, self._names, self._calls = model, model.states, Calls()
        what.note.context, what.note.say = self._calls.handle, lib.lw_py_note
        self._links = model.links
        self._handle = ffi.gc(make("stepper", lib.lw_stepper_create, model._handle, what), lib.lw_stepper_destroy)

    def advance(self, t: float) -> "Stepper":
        """Go on to t [s]."""
        error = new_error()
        self._calls.notes.clear()
        check(lib.lw_stepper_advance(self._handle, t, error), error)
        return self

    @property
    def notes(self) -> list[str]:
        """What the program would print about the last advance."""
        return list(self._calls.notes)

    @property
    def t(self) -> float:
        return lib.lw_stepper_sample(self._handle).t

    @property
    def link(self) -> np.ndarray:
        return _copy(lib.lw_stepper_sample(self._handle).link, (self._links, 6))

    @property
    def state(self) -> dict:
        sample = lib.lw_stepper_sample(self._handle)
        return {name: sample.state[i] for i, name in enumerate(self._names)}

    @property
    def report(self) -> dict:
        """The report of all pieces so far, as Simulation.report: place_off and turn_off say how far a coarser run of contacts is."""
        out = ffi.new("lw_simulation_report *")
        lib.lw_stepper_report(self._handle, out)
        return plain(out[0])

    def set_load(self, link: int, fx: float = 0.0, fy: float = 0.0, torque: float = 0.0) -> None:
        """From now on this force [N] on the centre of mass and torque [N m] act on a link."""
        check(lib.lw_stepper_set_load(self._handle, link, {"force": {"x": fx, "y": fy}, "torque": torque}))

    def set_state(self, name: str, value: float) -> None:
        check(lib.lw_stepper_set_state(self._handle, lib.lw_model_find_state(self._model._handle, name.encode()), value))

    def save(self) -> bytes:
        out, size = ffi.new("char **"), ffi.new("size_t *")
        check(lib.lw_stepper_save(self._handle, out, size))
        return take_bytes(out[0], size[0])

    def restore(self, saved: bytes) -> "Stepper":
        error = new_error()
        check(lib.lw_stepper_restore(self._handle, saved, len(saved), error), error)
        return self
