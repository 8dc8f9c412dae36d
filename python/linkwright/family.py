"""Product families: master files whose parameters expand to models; servo axes."""
from __future__ import annotations

import os
from typing import Optional, Union

from ._c import ffi, lib
from ._core import check, load, make, new_error, plain, text_of
from .dynamics import Model


class Family:
    """A master file (docs/family.md)."""

    def __init__(self, path: Union[str, os.PathLike]):
        self._handle = ffi.gc(load("master", path), lib.lw_master_destroy)

    def _names(self, name_of) -> list[str]:
        names = []
        while name_of(self._handle, len(names)) != ffi.NULL:
            names.append(text_of(name_of(self._handle, len(names))))
        return names

    @property
    def parameters(self) -> list[str]:
        return self._names(lib.lw_master_parameter_name)

    @property
    def configurations(self) -> list[str]:
        return self._names(lib.lw_master_configuration)

    @property
    def views(self) -> list[str]:
        return self._names(lib.lw_master_view)

    def variant(self, configuration: Optional[str] = None, view: Optional[str] = None, **values) -> "Variant":
        """A choice of the parameters: a configuration, and values in the units of the master, or texts as "3.2 m"."""
        return Variant(self, configuration, view, values)


class Variant:
    """One choice of the parameters of a family."""

    def __init__(self, family, configuration, view, values):
        error, variant = new_error(), make("variant", lib.lw_variant_create, family._handle, has_error=False)
        self._family, self._handle = family, ffi.gc(variant, lib.lw_variant_destroy)
        for choose, name in ((lib.lw_variant_configure, configuration), (lib.lw_variant_look, view)):
            if name is not None:
                check(choose(self._handle, name.encode(), error), error)
        for name, value in values.items():
            text = str(value).lower() if isinstance(value, bool) else str(value)
            check(lib.lw_variant_set(self._handle, name.encode(), text.encode(), error), error)

    def number(self, formula: str) -> float:
        """A formula over parameters and derived values, in SI or in the unit after `as`: "2*reach as mm"."""
        out, error = ffi.new("double *"), new_error()
        check(lib.lw_variant_number(self._handle, formula.encode(), out, error), error)
        return out[0]

    def model(self) -> Model:
        """The planar model; raises Error with the place in the master when a check of the family does not hold."""
        error = new_error()
        check(lib.lw_variant_hold_checks(self._handle, error), error)
        return Model(make("model", lib.lw_variant_model, self._handle))


def simulate_servo(path: Union[str, os.PathLike], to: float = 0.0) -> dict:
    """Run the servo axis of a file (docs/drive.md) until `to` [s]; 0: its motion and half as long again.  The fields of
    lw_servo_report: greatest error, settling, overshoot, currents, energies."""
    error, servo = new_error(), ffi.gc(load("servo", path), lib.lw_servo_destroy)
    options = ffi.new("lw_servo_options *", lib.lw_servo_options_default())
    options.to = to
    report = ffi.new("lw_servo_report *")
    check(lib.lw_servo_run(servo, options, ffi.NULL, ffi.NULL, report, error), error)
    return plain(report[0])
