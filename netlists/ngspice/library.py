"""ngspice as a shared library in this process, through PySpice's binding.

What keeps PySpice 1.5's binding from running a simulation reliably is mended here. The library keeps all its
state in global variables of C. So a process has one such library, and a lock lets one run in at a time:
threads wait for each other, while worker processes run side by side. A process keeps the first library that
it loaded. The calls used here are described in ngspice's manual, chapter "ngspice as shared library or
dynamic link library".
"""

from __future__ import annotations

import ctypes.util
import functools
import importlib
import logging
import os
import re
import signal
import sysconfig
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from circuits.arrays import C128, F64
from circuits.errors import SimulatorError

_PATH_VARIABLE = "NGSPICE_LIBRARY_PATH"
_REMEDY = f"install Debian's libngspice0, or set {_PATH_VARIABLE} to the library's file"
_FAILURE = re.compile(r"error\b|doanalyses|netlist line|run simulation|fatal", re.IGNORECASE)
_ENDED_EARLY = re.compile(r"doanalyses|run simulation|fatal", re.IGNORECASE)
_AFTERMATH = re.compile(r"run simulation|.*cannot recover|please check your input", re.IGNORECASE)
_PROGRESS = re.compile(r"trying gmin|supplies reduced|note:|warning:", re.IGNORECASE)
_NO_POINT = re.compile(r"doanalyses.*(iteration|singular)", re.IGNORECASE)
# A search for the operating point that fails would end in a transient of 10 us, whose last point ngspice
# calls the operating point whether anything has come to rest by then or not.
_NO_PSEUDO_TRANSIENT = "optran 1 1 1 0 0 0"
MESSAGE_LIMIT = 400  # characters of ngspice's text in an error's one line

_lock = threading.Lock()


class NoOperatingPointError(SimulatorError):
    """Raised where ngspice's search for an operating point ends without one."""


def find_library() -> Path | None:
    """Return the path of the ngspice library, or None where there is none.

    The environment variable `NGSPICE_LIBRARY_PATH` comes first, then the file that the linker finds, then the
    place where Debian installs it.

    Raises
    ------
    SimulatorError
        `NGSPICE_LIBRARY_PATH` names no file.
    """
    chosen = os.environ.get(_PATH_VARIABLE)
    if not chosen:
        return _system_library()
    path = Path(chosen)
    if not path.is_file():
        raise SimulatorError(f"{_PATH_VARIABLE}: {chosen}, must be an existing file; {_REMEDY}, or unset it")
    return path


def version() -> str | None:
    """Return the library's version as it tells it itself (`39`), or None where there is no library.

    Raises
    ------
    SimulatorError
        The library is there but cannot be loaded.
    """
    path = find_library()
    if path is None:
        return None
    with _lock:
        library = _open(path)
        library.clear_output()
        library.command("version -f")
        found = re.search(r"ngspice-(\S+)", library.stdout)
    return found.group(1) if found else "unknown"


@contextmanager
def simulated(deck: str, deadline_s: float | None) -> Iterator[Any]:
    """Run a deck and give the library with the finished run in it, for the length of a `with` block.

    No other thread can use the library meanwhile. When the block ends, the run is removed from it.

    Parameters
    ----------
    deck
        Text of the deck, title line first.
    deadline_s
        Wall-clock time that the run may take, s; None for no limit.

    Raises
    ------
    SimulatorError
        There is no library, the run fails, or it takes longer than `deadline_s`.
    NoOperatingPointError
        The search for the operating point fails.
    """
    path = find_library()
    if path is None:
        raise SimulatorError(f"ngspice: no library found; {_REMEDY}")
    with _lock:
        library = _open(path)
        try:
            _simulate(library, deck, deadline_s)
            yield library
        finally:
            _clean(library)


@functools.cache
def _system_library() -> Path | None:
    folders = [Path("/usr/lib"), Path("/usr/local/lib")]
    multiarch = sysconfig.get_config_var("MULTIARCH")
    if multiarch:
        folders.insert(0, folders[0] / multiarch)
    name = ctypes.util.find_library("ngspice")
    for candidate in filter(None, (name, "libngspice.so", "libngspice.so.0")):
        for folder in folders:
            if (folder / candidate).is_file():
                return folder / candidate
    return Path(name) if name else None


@functools.cache
def _open(path: Path) -> Any:
    """Load the library once a process and set it up; `_clean` renews it in place."""
    # Imported here and nowhere else: PySpice is slow to import, and `noctule --help` must not wait for it.
    # Its old string escapes warn when first compiled. Its logging set-up, which would replace the root
    # logger's, is never called.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        shared: Any = importlib.import_module("PySpice.Spice.NgSpice.Shared")
    _probe(shared, path)
    kind = _library_class(shared, path)
    library = kind.new_instance()
    if not isinstance(library, kind):
        raise SimulatorError("ngspice: PySpice has already loaded it in this process; call run before it")
    library.command("set num_threads=1")  # with OpenMP's default, BSIM3 costs 4 to 6 times the CPU
    return library


def _probe(shared: Any, path: Path) -> None:
    """Raise if `path` is no ngspice library, before PySpice half-initialises itself with it."""
    ffi = shared.FFI()
    ffi.cdef("int ngSpice_Command(char *);")
    try:
        handle = ffi.dlopen(str(path))
        _ = handle.ngSpice_Command
    except (OSError, AttributeError) as error:
        raise SimulatorError(f"ngspice: {path}, cannot be loaded ({error}); {_REMEDY}") from error
    ffi.dlclose(handle)


def _library_class(shared: Any, path: Path) -> Any:  # noqa: C901 - the sum over short methods
    """Return PySpice's binding with its breaks mended; a factory, because the base class is imported late."""
    quiet = logging.getLogger(f"{__name__}.pyspice")
    quiet.disabled = True  # it warns "Unsupported Ngspice version", and repeats what we raise

    class Library(shared.NgSpiceShared):  # type: ignore[misc]
        """NgSpiceShared whose notes are not failures, and whose background run reports its end."""

        LIBRARY_PATH = str(path).replace("{", "{{").replace("}", "}}")  # PySpice formats it
        _logger = quiet
        _ngspice_shared: Any

        def __init__(self, **options: Any) -> None:
            self.finished = threading.Event()
            self.finished.set()
            self.broken = False
            self.worker: int | None = None
            super().__init__(**options)

        @staticmethod
        def _send_char(message: Any, _id: int, user_data: Any) -> int:
            self = shared.ffi.from_handle(user_data)
            text = shared.ffi.string(message).decode("utf-8", "replace")
            stream, _, content = text.partition(" ")
            if stream == "stderr":
                self._stderr.append(content)
                # For PySpice's own simulators, which share this instance; a run here reads the lines.
                self._error_in_stderr = bool(self._error_in_stderr or _FAILURE.match(content))
            else:
                self._stdout.append(content)
            return 0

        @staticmethod
        def _background_thread_running(not_running: int, _id: int, user_data: Any) -> int:
            self = shared.ffi.from_handle(user_data)
            self.worker = threading.get_native_id()
            if not_running:
                self.finished.set()
            return 0

        @staticmethod
        def _exit(status: int, _unload: int, _quit: int, _id: int, user_data: Any) -> int:
            shared.ffi.from_handle(user_data).broken = True
            return status

        def reload(self) -> None:
            """Renew the library: after an undefined parameter it refuses every deck until it is unloaded."""
            self._outlast_worker()
            shared.ffi.dlclose(self._ngspice_shared)
            self._ngspice_shared = shared.ffi.dlopen(str(path))
            self._ngspice_id = 0
            self._init_ngspice(send_data=False)
            self.broken = False

        def _outlast_worker(self) -> None:
            """Wait for the last run's thread: ngspice never joins it, and it returns through the library."""
            for _ in range(1000):
                if self.worker is None or not Path(f"/proc/self/task/{self.worker}").exists():
                    return
                time.sleep(0.001)

        def load(self, lines: list[str]) -> int:
            """Hand over a deck; PySpice's own method would drop an empty title and raise without a text."""
            kept = [shared.ffi.new("char[]", line.encode()) for line in lines]
            deck = shared.ffi.new("char *[]", [*kept, shared.ffi.NULL])
            return int(self._ngspice_shared.ngSpice_Circ(deck))

        @property
        def output(self) -> list[str]:
            """Lines on ngspice's stdout since `clear_output`."""
            return list(self._stdout)

        @property
        def errors(self) -> list[str]:
            """Lines on ngspice's stderr since `clear_output`: notes and warnings too."""
            return list(self._stderr)

        def command(self, text: str) -> None:
            with _interrupts_held():
                self._ngspice_shared.ngSpice_Command(text.encode())

        def forget_commands(self) -> None:
            """Free ngspice's history of commands, which else grows with every run."""
            self._ngspice_shared.ngSpice_Command(shared.ffi.NULL)

        def current_plot(self) -> str:
            return str(shared.ffi.string(self._ngspice_shared.ngSpice_CurPlot()).decode())

        def vector_names(self, plot: str) -> list[str]:
            return list(self._convert_string_array(self._ngspice_shared.ngSpice_AllVecs(plot.encode())))

        def copy_complex(self, plot: str, name: str) -> C128:
            """Copy a vector of an analysis over frequency; a real one gets no imaginary part."""
            info = self._ngspice_shared.ngGet_Vec_Info(f"{plot}.{name}".encode())
            if not info or not info.v_compdata:
                return self.copy_vector(plot, name).astype(np.complex128)
            raw = shared.ffi.buffer(info.v_compdata, 16 * info.v_length)
            return np.frombuffer(raw, np.complex128).copy()

        def copy_vector(self, plot: str, name: str) -> F64:
            """Copy a vector: the library reuses its memory."""
            info = self._ngspice_shared.ngGet_Vec_Info(f"{plot}.{name}".encode())
            if not info or not info.v_realdata or not info.v_length:
                return np.empty(0)
            return np.frombuffer(shared.ffi.buffer(info.v_realdata, 8 * info.v_length), np.float64).copy()

    return Library


def _simulate(library: Any, deck: str, deadline_s: float | None) -> None:
    """Load the deck and run it in ngspice's own thread.

    So Ctrl-C and the deadline reach this thread while ngspice computes.
    """
    library.clear_output()
    title, *rest = deck.splitlines()
    lines = [title.strip() or "*", *(line for line in rest if line.strip())]
    with _interrupts_held():
        refused = library.load(lines)
    if refused or _failure(library):
        raise SimulatorError(f"ngspice: {_failure(library) or 'deck refused'}; correct the deck")
    with _interrupts_held():
        library.finished.clear()
        library.command(_NO_PSEUDO_TRANSIENT)
        library.command("bg_run")
    if not library.finished.wait(deadline_s):
        raise SimulatorError(
            f"ngspice: not done after {deadline_s:g} s of wall clock, the deadline; give more by `deadline`"
            " (deadline_s), or a shorter run"
        )
    # "Error:" alone is no end: ngspice goes on after an expression out of range in one Newton iteration.
    if not library.broken and any(_NO_POINT.match(line) for line in library.errors):
        raise NoOperatingPointError(
            f"ngspice: {_failure(library)}; give start voltages near the state that is meant"
        )
    if library.broken or any(_ENDED_EARLY.match(line) for line in library.errors):
        raise SimulatorError(f"ngspice: {_failure(library)}; check the circuit, then reltol and tmax")


def _halt(library: Any) -> None:
    while not library.finished.wait(0.01):
        library.command("bg_halt")


def _clean(library: Any) -> None:
    """Make the library ready for the next run.

    What still runs is halted; plots, circuit and command history are freed. A library that cannot go on is
    loaded anew.
    """
    _halt(library)
    if library.broken:
        library.reload()
        library.command("set num_threads=1")
        return
    for text in ("destroy all", "remcirc"):
        library.command(text)
    library.forget_commands()


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold Ctrl-C back during a call: ngspice would jump out of it, and a callback swallow the exception.

    ngspice's thread is created inside such a call and inherits the mask, so it never sees the signal.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _failure(library: Any) -> str:
    """Return ngspice's own words on what went wrong, in one line; empty if nothing did."""
    lines = [line.strip() for line in library.errors if line.strip()]
    start = next((i for i, line in enumerate(lines) if _FAILURE.match(line)), None)
    if start is None:
        return ""
    singular = [line[line.index("singular") :] for line in lines if "singular matrix" in line]
    said = [line for line in lines[start:] if not _AFTERMATH.match(line) and not _PROGRESS.match(line)]
    return " ".join(" ".join([*singular[-1:], *(said or lines[start:])]).split())[:MESSAGE_LIMIT]
