"""What every module of the package uses: errors, texts, structs, callbacks, work that Ctrl-C may end."""
import json
import os
import threading

from ._c import ffi, lib


def version():
    """Version of the C library, "0.2.0"."""
    return ffi.string(lib.lw_version()).decode()


class Error(Exception):
    """A call of the library failed.  str() is its text: what is wrong and what to do.

    status: name of the status, "LW_E_NOTATION"; file, line, column: where, or None.
    """

    def __init__(self, text, status, file=None, line=None, column=None):
        super().__init__(text)
        self.status, self.file, self.line, self.column = status, file, line, column


class Stopped(KeyboardInterrupt):
    """Ctrl-C ended a search.  results: what was found until then."""

    def __init__(self, results):
        super().__init__("stopped; .results holds what was found")
        self.results = results


def new_error():
    return ffi.new("lw_error *")


def raise_for(status, error=None):
    """Raise what a status below 0, or one that the caller does not expect, stands for."""
    text, file, line, column = "", None, None, None
    if error is not None and error.text[0] != b"\0":
        buffer = ffi.new("char[1100]")
        lib.lw_error_print(error, buffer, 1100)
        text = ffi.string(buffer).decode(errors="replace")
        file = ffi.string(error.file).decode(errors="replace") or None
        line, column = error.line or None, error.column or None
    if status == lib.LW_E_MEMORY:
        raise MemoryError(text or "out of memory")
    name = ffi.string(lib.lw_status_name(status)).decode()
    raise Error(text or ffi.string(lib.lw_status_text(status)).decode(), name, file, line, column)


def check(status, error=None, allowed=()):
    """The status, if it is LW_OK or allowed; else the error is raised."""
    if status != lib.LW_OK and status not in allowed:
        raise_for(status, error)
    return status


def text_of(pointer):
    """A text that belongs to a handle, as str; NULL is None."""
    return None if pointer == ffi.NULL else ffi.string(pointer).decode(errors="replace")


def run_text(run):
    """A simulation in one line."""
    return (f"<linkwright.{type(run).__name__}: {len(run.t)} samples to {run.t[-1]:g} s, "
            f"{run.report['formulation']}, energy error {run.report['energy_error']:.2g} J>")


def run_table(run):
    """The report of a simulation for notebooks."""
    rows = "".join(f"<tr><th>{name}</th><td>{value}</td></tr>" for name, value in run.report.items())
    return f"<table>{rows}</table>"


def take_text(pointer):
    """A text that is the caller's, as str; it is freed."""
    try:
        return ffi.string(pointer).decode()
    finally:
        lib.lw_free(pointer)


def take_bytes(pointer, size):
    try:
        return bytes(ffi.buffer(pointer, size))
    finally:
        lib.lw_free(pointer)


def make(kind, function, *arguments, has_error=True):
    """The lw_`kind` that function(*arguments, out, error) makes for the caller; has_error=False: it takes no error."""
    out, error = ffi.new(f"lw_{kind} **"), [new_error()] if has_error else []
    check(function(*arguments, out, *error), *error)
    return out[0]


def load(kind, path):
    """What lw_`kind`_load reads from a file."""
    return make(kind, getattr(lib, f"lw_{kind}_load"), os.fsencode(path))


def parse(kind, data):
    """What lw_`kind`_parse reads from the text of a JSON file, given as Python values."""
    text = json.dumps(data).encode()
    return make(kind, getattr(lib, f"lw_{kind}_parse"), text, len(text), ffi.NULL)


def write(function, *arguments):
    """Bytes that function(*arguments, out, size, error) writes."""
    out, size, error = ffi.new("char **"), ffi.new("size_t *"), new_error()
    check(function(*arguments, out, size, error), error)
    return take_bytes(out[0], size[0])


def chars(text, keep):
    """char[] of a str or None, kept alive by the list `keep`."""
    if text is None:
        return ffi.NULL
    value = ffi.new("char[]", str(text).encode())
    keep.append(value)
    return value


def fill(struct, options, keep, special=()):
    """Set fields of a struct by name.  Texts are kept alive by `keep`; unknown names raise TypeError."""
    fields = dict(ffi.typeof(struct[0]).fields)
    for name, value in options.items():
        if name not in fields or name in special:
            known = ", ".join(sorted(set(fields) - set(special)))
            raise TypeError(f"no option {name!r}; there are: {known}")
        kind = fields[name].type
        if kind.kind == "pointer" and kind.item.cname == "char":
            setattr(struct, name, chars(value, keep))
        elif kind.kind == "array":
            array = getattr(struct, name)
            for i, item in enumerate(value):
                array[i] = item
        else:
            setattr(struct, name, value)
    return struct


def plain(value, kind=None):
    """A C value as Python values: structs become dicts, lw_vec2 pairs, arrays tuples, texts str."""
    kind = kind or ffi.typeof(value)
    if kind.kind == "primitive":
        return value
    if kind.kind == "pointer" and kind.item.cname == "char":
        return text_of(value)
    if kind.kind == "array":
        if kind.item.cname == "char":
            return ffi.string(value).decode(errors="replace")
        return tuple(plain(item, kind.item) for item in value)
    if kind.cname.endswith("lw_vec2"):
        return value.x, value.y
    if kind.kind == "struct":
        return {name: plain(getattr(value, name), field.type) for name, field in kind.fields
                if field.type.kind != "pointer" or field.type.item.cname == "char"}
    return value


def simulation_options(options, keep):
    """lw_simulation_options with these fields; "from_" stands for "from"."""
    named = {"from" if name == "from_" else name: value for name, value in options.items()}
    return fill(ffi.new("lw_simulation_options *", lib.lw_simulation_options_default()), named, keep, special=("stop", "force", "note"))


class Calls:
    """What the callbacks of one call do, and the exception that one of them raised.

    The library stops when a callback returns another status than LW_OK; `finish` raises the exception in the
    caller's thread then.
    """

    def __init__(self, visit=None, progress=None, force=None):
        self.visit, self.progress, self.force, self.failure = visit, progress, force, None
        self.stopped, self.notes = False, []
        self.handle = ffi.new_handle(self)

    def run_visit(self, *arguments):
        try:
            self.visit(*arguments)
            return lib.LW_STOPPED if self.stopped else lib.LW_OK
        except BaseException as failure:             # carried to the caller's thread
            self.failure = failure
            return lib.LW_STOPPED

    def finish(self, status, error=None, allowed=()):
        if self.failure is not None:
            raise self.failure
        return check(status, error, allowed)


def _visitor(name):
    @ffi.def_extern(name=name)
    def call(context, *arguments):
        return ffi.from_handle(context).run_visit(*arguments)


for _name in ("chain", "mechanism", "group", "range", "sample", "vibration", "row", "hit", "spatial_trace",
              "spatial_sample"):
    _visitor("lw_py_" + _name)


@ffi.def_extern(name="lw_py_progress", error=False)
def _progress(context, done, seconds, best):
    calls = ffi.from_handle(context)
    if calls.stopped or calls.failure is not None:
        return False
    if calls.progress is not None:
        try:
            return calls.progress(done, seconds, best) is not False
        except BaseException as failure:
            calls.failure = failure
            return False
    return True


@ffi.def_extern(name="lw_py_note")
def _note(context, text):
    ffi.from_handle(context).notes.append(text_of(text))


@ffi.def_extern(name="lw_py_force")
def _force(context, t, link, load):
    calls = ffi.from_handle(context)
    if calls.failure is None:
        try:
            calls.force(t, link, load)
        except BaseException as failure:
            calls.failure = failure


def interruptible(work, stop):
    """The result of work(), done in a thread so that Ctrl-C arrives.  It asks the work to end by stop(), or by the int to
    which stop points; the work is waited for.

    Returns (result, interrupted).
    """
    outcome, done = {}, threading.Event()

    def run():
        try:
            outcome["result"] = work()
        except BaseException as failure:
            outcome["failure"] = failure
        done.set()

    threading.Thread(target=run, daemon=True).start()
    interrupted = False
    while not done.is_set():
        try:
            done.wait(0.1)
        except KeyboardInterrupt:
            interrupted = True
            if isinstance(stop, ffi.CData):
                stop[0] = 1
            else:
                stop()
    if "failure" in outcome:
        raise outcome["failure"]
    return outcome["result"], interrupted
