"""Chains and mechanisms: links and joints without dimensions."""
from __future__ import annotations

import queue
import threading
from typing import Iterator, Optional

import numpy as np

from ._c import ffi, lib
from ._core import Calls, chars, check, fill, make, new_error, take_text, text_of


class _Topology:
    """What a chain and a mechanism have in common; _name is that of its C functions."""

    _name = ""

    def __init__(self, handle):
        self._handle = ffi.gc(handle, getattr(lib, f"lw_{self._name}_destroy"))

    @classmethod
    def from_text(cls, text: str, notation: Optional[str] = None):
        """Read "graph6", "lam", "sentence", "franke", "edges" or "json"; None: found from how it begins."""
        keep, data = [], text.encode()
        return cls(make(cls._name, getattr(lib, f"lw_{cls._name}_from_text"), data, len(data), chars(notation, keep)))

    def to_text(self, notation: str = "graph6") -> str:
        """Write "graph6", "lam", "sentence", "franke", "edges", "json", "dot" or "graphml"."""
        out, error = ffi.new("char **"), new_error()
        check(getattr(lib, f"lw_{self._name}_to_text")(self._handle, notation.encode(), out, error), error)
        return take_text(out[0])

    def _get(self, what):
        return getattr(lib, f"lw_{self._name}_{what}")(self._handle)

    @property
    def links(self) -> int:
        """Number of links."""
        return self._get("n_link")

    @property
    def mobility(self) -> int:
        """F = 3 (P - 1) - 2 n1 - n2: a count, no proof."""
        return self._get("mobility")

    def is_isomorphic(self, other) -> bool:
        """The same but for the numbers of the links?"""
        same = ffi.new("bool *")
        check(getattr(lib, f"lw_{self._name}_is_isomorphic")(self._handle, other._handle, same))
        return same[0]

    def __str__(self):
        return self.to_text("sentence")


class Chain(_Topology):
    """Links and joints, nothing fixed.  Two chains are equal when they are isomorphic."""

    _name = "chain"

    @classmethod
    def from_joints(cls, links: int, joints) -> "Chain":
        """Chain of so many links (1 to 32); joints: pairs of links (i, k), or (i, k, freedom) with 1 or 2."""
        chain = cls(make("chain", lib.lw_chain_create, links, has_error=False))
        for i, k, *freedom in joints:
            check(lib.lw_chain_join(chain._handle, i, k, freedom[0] if freedom else 1))
        return chain

    @property
    def joints(self) -> list[tuple[int, int, int]]:
        """(i, k, freedom) of each joint, i < k."""
        pairs = ((i, k) for i in range(self.links) for k in range(i + 1, self.links))
        joined = ((i, k, lib.lw_chain_joint_freedom(self._handle, i, k)) for i, k in pairs)
        return [joint for joint in joined if joint[2]]

    @property
    def graph6(self) -> str:
        return self.to_text("graph6").strip()

    @property
    def loops(self) -> int:
        """L = n1 + n2 - P + 1."""
        return self._get("loops")

    @property
    def is_planar(self) -> bool:
        """Can its graph be drawn without crossings?"""
        planar = ffi.new("bool *")
        check(lib.lw_chain_is_planar(self._handle, planar))
        return planar[0]

    @property
    def is_fractionated(self) -> bool:
        """Does it fall apart at one link?"""
        return self._get("is_fractionated")

    @property
    def symmetries(self) -> int:
        """Order of the symmetry group."""
        order = ffi.new("uint64_t *")
        check(lib.lw_chain_symmetries(self._handle, order))
        return order[0]

    def orbits(self) -> np.ndarray:
        """(links): the lowest link that symmetry makes alike to each link."""
        lowest = np.empty(self.links, np.uint8)
        check(lib.lw_chain_orbits(self._handle, ffi.from_buffer("uint8_t[]", lowest), ffi.NULL))
        return lowest

    def canonical(self) -> "Chain":
        """The same chain with its links in canonical order; isomorphic chains give equal texts."""
        form = Chain(make("chain", lib.lw_chain_create, self.links, has_error=False))
        check(lib.lw_chain_canonical(self._handle, form._handle))
        return form

    def check(self) -> None:
        """Raise Error when it cannot move: a part is rigid, or a link has fewer than two joints."""
        error = new_error()
        check(lib.lw_chain_check(self._handle, error), error)

    def mechanism(self) -> "Mechanism":
        """As a mechanism with nothing chosen: joints r and p."""
        return Mechanism(make("mechanism", lib.lw_mechanism_of_chain, self._handle, has_error=False))

    def mechanisms(self, **choices) -> list["Mechanism"]:
        """See Mechanism.mechanisms."""
        return self.mechanism().mechanisms(**choices)

    def __eq__(self, other):
        return isinstance(other, Chain) and self.is_isomorphic(other)

    def __hash__(self):
        return hash(self.canonical().to_text("graph6"))

    def __repr__(self):
        return f"Chain.from_text({self.graph6!r})"

    def _repr_svg_(self):
        return self.mechanism()._repr_svg_()


class Mechanism(_Topology):
    """A chain with kinds of joints, ground, inputs, output link."""

    _name = "mechanism"

    @property
    def joints(self) -> list[tuple[int, int, str]]:
        """(i, k, kind) of each joint; kinds: r pin, t slider, p pin in a slot, g gear pair."""
        link, joints = ffi.new("int[2]"), []
        for joint in range(self._get("n_joint")):
            kind = lib.lw_mechanism_joint_kind(self._handle, joint, link)
            joints.append((link[0], link[1], kind.decode()))
        return joints

    @property
    def ground(self) -> Optional[int]:
        """The fixed link; None: not chosen."""
        ground = self._get("ground")
        return None if ground < 0 else ground

    @property
    def output(self) -> Optional[int]:
        """The output link; None: not chosen."""
        output = self._get("output")
        return None if output < 0 else output

    @property
    def inputs(self) -> list[int]:
        """Numbers of the driven joints."""
        return [lib.lw_mechanism_input(self._handle, i) for i in range(self._get("n_input"))]

    def chain(self) -> Chain:
        """Its chain: kinds and choices are forgotten."""
        chain = Chain(make("chain", lib.lw_chain_create, self.links, has_error=False))
        lib.lw_mechanism_chain(self._handle, chain._handle)
        return chain

    def choose(self, ground: Optional[int] = None, inputs=(), output: Optional[int] = None) -> None:
        """Choose ground, driven joints (of one freedom, rising) and output link; None: leave open."""
        inputs = list(inputs)
        check(lib.lw_mechanism_choose(self._handle, -1 if ground is None else ground, len(inputs), inputs,
                                      -1 if output is None else output))

    def mechanisms(self, **choices) -> list["Mechanism"]:
        """Every choice up to symmetry.  ground=True: a ground link; kinds="rt": kinds of joints; inputs: 0 none,
        1 at the ground, 2 anywhere; output=True: an output link."""
        keep, found, error = [], [], new_error()
        what = ffi.new("lw_choices *", lib.lw_choices_default())
        fill(what, choices, keep)

        def visit(mechanism):
            found.append(Mechanism(make("mechanism", lib.lw_mechanism_copy, mechanism, has_error=False)))

        calls = Calls(visit)
        calls.finish(lib.lw_enumerate_mechanisms(self._handle, what, lib.lw_py_mechanism, calls.handle, ffi.NULL, error),
                     error)
        return found

    def groups(self) -> list[dict]:
        """Assur groups in the order of solution: group_class, order, assembly_modes (0: unknown), links."""
        found, error = [], new_error()
        calls = Calls(lambda group: found.append({
            "group_class": group.group_class, "order": group.order, "assembly_modes": group.assembly_modes,
            "links": [group.link[i] for i in range(group.n_link)]}))
        calls.finish(lib.lw_mechanism_groups(self._handle, lib.lw_py_group, calls.handle, error), error)
        return found

    def moves(self) -> Optional[str]:
        """None when the count F says rightly how it moves at general dimensions, else why not."""
        text = ffi.new("char[512]")
        status = check(lib.lw_mechanism_moves(self._handle, text, 512), allowed=(lib.LW_NOTHING,))
        return text_of(text) if status == lib.LW_NOTHING else None

    def linkage(self, seed: int = 1):
        """A linkage of this topology with dimensions drawn by `seed`; ground, inputs and output must be chosen."""
        from .linkage import Linkage
        return Linkage(make("linkage", lib.lw_linkage_of_mechanism, self._handle, seed))

    def __repr__(self):
        return f"Mechanism.from_text({self.to_text('sentence').strip()!r})"

    def _repr_svg_(self):
        from .linkage import picture
        one = ffi.new("lw_mechanism *[1]", [self._handle])
        drawn = make("picture", lib.lw_picture_of_mechanisms, 1, one, ffi.NULL, 1, ffi.NULL)
        return picture(drawn, "svg", 240, 240).decode()


def _enumeration(links, dof, options, keep):
    what = ffi.new("lw_enumeration *", lib.lw_enumeration_default(links, dof))
    return fill(what, options, keep, special=("links", "dof", "progress", "context"))


def chains(links: int, dof: int = 1, **options) -> Iterator[Chain]:
    """Every chain with so many links and freedoms, once, in an order that does not change.

    Options: joints2, fractionated, filter ("planar", "nonplanar"), part and parts, skip, jobs.  The search runs
    while its results are read, a few thousand chains ahead, and ends when the iterator is closed.
    """
    keep, error, ahead, end = [], new_error(), queue.Queue(64), object()
    what, batch = _enumeration(links, dof, options, keep), []

    def visit(chain):
        batch.append(Chain(make("chain", lib.lw_chain_copy, chain, has_error=False)))
        if len(batch) == 64:
            put(batch.copy())
            batch.clear()

    def put(item):
        while not calls.stopped:
            try:
                return ahead.put(item, timeout=0.1)
            except queue.Full:
                pass

    def work():
        status = lib.lw_enumerate_chains(what, lib.lw_py_chain, calls.handle, error)
        put(batch)
        put((end, status))

    calls = Calls(visit)
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    try:
        while True:
            item = ahead.get()
            if isinstance(item, tuple):
                calls.finish(item[1], error)
                return
            yield from item
    finally:
        calls.stopped = True
        thread.join()


def count_chains(links: int, dof: int = 1, **options) -> tuple[int, Optional[int]]:
    """(chains, choices of a ground link up to symmetry).  Options as of chains(); quicker than listing.

    Grounds are not counted for joints2 and fractionated: None.
    """
    keep, error, found = [], new_error(), ffi.new("uint64_t[2]")
    grounds = not options.get("joints2") and not options.get("fractionated")
    check(lib.lw_enumerate_count(_enumeration(links, dof, options, keep), found, found + 1 if grounds else ffi.NULL,
                                 error), error)
    return found[0], found[1] if grounds else None
