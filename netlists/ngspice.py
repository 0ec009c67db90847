"""Running decks in ngspice, through PySpice's binding of the shared library.

A deck is text (title, elements, `.options`, one of `.op`, `.dc`, `.tran`, `.end`); the answer is arrays.

The library keeps all its state in C globals, so a process has one of it and a module lock lets one run in at
a time: threads queue, worker processes run side by side. The process keeps the first library that it loaded.
ngspice's manual, chapter "ngspice as shared library or dynamic link library", describes the calls used here.
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
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circuits.errors import SimulatorError, unknown_name

_PATH_VARIABLE = "NGSPICE_LIBRARY_PATH"
_REMEDY = f"install Debian's libngspice0, or set {_PATH_VARIABLE} to the library's file"
_READABLE = (".op", ".dc", ".tran")
_UNREADABLE = (".ac", ".noise", ".disto", ".pz", ".sens", ".tf", ".sp", ".pss", ".control")
_AXES = ("time", "v-sweep", "i-sweep", "res-sweep", "temp-sweep")
_SUFFIXES = {"t": 1e12, "g": 1e9, "meg": 1e6, "k": 1e3, "mil": 25.4e-6, "m": 1e-3, "u": 1e-6, "n": 1e-9,
             "p": 1e-12, "f": 1e-15, "a": 1e-18, "": 1.0}  # fmt: skip
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)(meg|mil|[tgkmunpfa]?)[a-z]*", re.IGNORECASE)
_FAILURE = re.compile(r"error\b|doanalyses|netlist line|run simulation|fatal", re.IGNORECASE)
_ENDED_EARLY = re.compile(r"doanalyses|run simulation|fatal", re.IGNORECASE)
_AFTERMATH = re.compile(r"run simulation|.*cannot recover|please check your input", re.IGNORECASE)
_PROGRESS = re.compile(r"trying gmin|supplies reduced|note:|warning:", re.IGNORECASE)
_STEPPING = re.compile(r"trying gmin|supplies reduced", re.IGNORECASE)
_MESSAGE_LIMIT = 400  # characters of ngspice's text in an error's one line

_lock = threading.Lock()


@dataclass(frozen=True, slots=True)
class Waveforms:
    """What one run left behind; T points.

    Attributes
    ----------
    analysis : str
        `op`, `dc` or `tran`.
    axis_name : str
        `time`, `v-sweep`, `i-sweep`, `res-sweep` or `temp-sweep`; empty for `op`.
    axis : float64[T]
        Time in s, or the swept quantity in its own unit; float64[0] for `op`.
    values : dict of str to float64[T]
        Lower-case node name to voltage in V, `name#branch` or `@device[i]` to current in A; T is 1 for `op`.
    steps : int
        Points stored: accepted time steps, sweep points, or 1.
    messages : tuple of str
        ngspice's notes and warnings, without the progress of its gmin and source stepping.
    """

    analysis: str
    axis_name: str
    axis: NDArray[np.float64]
    values: dict[str, NDArray[np.float64]]
    steps: int
    messages: tuple[str, ...]


def find_library() -> Path | None:
    """Return the ngspice library: `NGSPICE_LIBRARY_PATH`, else the linker's, else Debian's place, else None.

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
    """Return the version the library tells of itself (`39`), or None where there is no library.

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


def run(deck: str, *, vectors: tuple[str, ...] | None = None, deadline_s: float | None = None) -> Waveforms:
    """Run a deck of one analysis (`.op`, `.dc` or `.tran`) to its end and copy its vectors out.

    Parameters
    ----------
    deck : str
        A complete deck: the first line is the title, the last is `.end`, the stop time of `.tran` a number.
    vectors : tuple of str, optional
        Names to read, as in `Waveforms.values`; all that were saved by default.
    deadline_s : float, optional
        Wall-clock seconds after which the run is halted.

    Raises
    ------
    SimulatorError
        The library is missing, ngspice refuses the deck or gives up, the run stops before the stop time, a
        value is not finite, or the deadline passes. The library can be used again afterwards.
    UnknownNameError
        A name in `vectors` that the run did not save.
    """
    analysis, stop = _read_analysis(deck)
    with simulated(deck, deadline_s) as library:
        waveforms = _read_plot(library, analysis, vectors)
    _check_complete(waveforms, stop)
    return waveforms


def run_for_pyspice(deck: str, simulation: Any, *, deadline_s: float | None = None) -> Any:
    """Run a deck of any one analysis and return its results as PySpice's `Plot` of `simulation`.

    Raises
    ------
    SimulatorError
        As `run`; whether values are finite and the stop time was reached is not looked at.
    """
    with simulated(deck, deadline_s) as library:
        return library.plot(simulation, library.current_plot())


@contextmanager
def simulated(deck: str, deadline_s: float | None) -> Iterator[Any]:
    """Give the library with the finished run of `deck` in it; nobody else has it meanwhile."""
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


def _read_analysis(deck: str) -> tuple[str, float | None]:
    """Return the analysis' name and, of a transient, its stop time in s; refuse what cannot be checked."""
    cards = [card for card in _cards(deck) if card[0] in (*_READABLE, *_UNREADABLE)]
    if not deck.rstrip().lower().endswith("\n.end"):
        raise SimulatorError("deck: no .end, must be the last line; add it")
    if len(cards) != 1 or cards[0][0] not in _READABLE:
        names = ", ".join(card[0] for card in cards) or "none"
        raise SimulatorError(f"deck.analysis: {names}, must be one of .op, .dc, .tran; split the deck")
    name, *arguments = cards[0]
    if name != ".tran":
        return name[1:], None
    number = _NUMBER.fullmatch(arguments[1]) if len(arguments) > 1 else None
    if number is None:
        raise SimulatorError(f"deck.tran: {' '.join(cards[0])}, stop time must be a number; write its value")
    return name[1:], float(number.group(1)) * _SUFFIXES[number.group(2).lower()]


def _cards(deck: str) -> list[list[str]]:
    """Return the words of each card after the title, continuation lines folded in, comments dropped."""
    cards: list[list[str]] = []
    for line in deck.splitlines()[1:]:
        words = re.split(r";|\$ ", line, maxsplit=1)[0].lower().split()
        if not words or words[0].startswith("*"):
            continue
        if words[0].startswith("+") and cards:
            cards[-1] += " ".join(words)[1:].split()
        else:
            cards.append(words)
    return cards


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

        def copy_complex(self, plot: str, name: str) -> NDArray[np.complex128]:
            """Copy a vector of an analysis over frequency; a real one gets no imaginary part."""
            info = self._ngspice_shared.ngGet_Vec_Info(f"{plot}.{name}".encode())
            if not info or not info.v_compdata:
                return self.copy_vector(plot, name).astype(np.complex128)
            raw = shared.ffi.buffer(info.v_compdata, 16 * info.v_length)
            return np.frombuffer(raw, np.complex128).copy()

        def copy_vector(self, plot: str, name: str) -> NDArray[np.float64]:
            """Copy a vector: the library reuses its memory."""
            info = self._ngspice_shared.ngGet_Vec_Info(f"{plot}.{name}".encode())
            if not info or not info.v_realdata or not info.v_length:
                return np.empty(0)
            return np.frombuffer(shared.ffi.buffer(info.v_realdata, 8 * info.v_length), np.float64).copy()

    return Library


def _simulate(library: Any, deck: str, deadline_s: float | None) -> None:
    """Load the deck and run it in ngspice's own thread, so that Ctrl-C and the deadline reach us here."""
    library.clear_output()
    title, *rest = deck.splitlines()
    lines = [title.strip() or "*", *(line for line in rest if line.strip())]
    with _interrupts_held():
        refused = library.load(lines)
    if refused or _failure(library):
        raise SimulatorError(f"ngspice: {_failure(library) or 'deck refused'}; correct the deck")
    with _interrupts_held():
        library.finished.clear()
        library.command("bg_run")
    if not library.finished.wait(deadline_s):
        raise SimulatorError(f"ngspice: not done after {deadline_s} s; allow more or loosen the options")
    # "Error:" alone is no end: ngspice goes on after an expression out of range in one Newton iteration.
    if library.broken or any(_ENDED_EARLY.match(line) for line in library.errors):
        raise SimulatorError(f"ngspice: {_failure(library)}; check the circuit, then reltol and tmax")


def _halt(library: Any) -> None:
    while not library.finished.wait(0.01):
        library.command("bg_halt")


def _clean(library: Any) -> None:
    """Halt what still runs; free plots, circuit and command history, or renew a library that cannot go on."""
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
    return " ".join(" ".join([*singular[-1:], *(said or lines[start:])]).split())[:_MESSAGE_LIMIT]


def _read_plot(library: Any, analysis: str, vectors: tuple[str, ...] | None) -> Waveforms:
    plot = library.current_plot()
    if plot.rstrip("0123456789") != analysis:
        said = " ".join(" ".join(library.errors).split())[:_MESSAGE_LIMIT]
        raise SimulatorError(f"ngspice: no {analysis} result ({said}); check .save and the analysis line")
    names = {node_name(name): name for name in reversed(library.vector_names(plot))}
    axis_name = next((name for name in _AXES if name in names), "") if analysis != "op" else ""
    axis = library.copy_vector(plot, names.pop(axis_name)) if axis_name else np.empty(0)
    chosen = names if vectors is None else vectors
    missing = [name for name in chosen if name not in names]
    if missing:
        raise unknown_name("vector", missing[0], names)
    values = {name: library.copy_vector(plot, names[name]) for name in chosen}
    return Waveforms(analysis, axis_name, axis, values, len(axis) if axis_name else 1, _messages(library))


def node_name(name: str) -> str:
    """Return `x` of `V(x)`, which ngspice writes for nodes that begin with a digit."""
    found = re.fullmatch(r"v\((.+)\)", name.lower())
    return found.group(1) if found else name.lower()


def _messages(library: Any) -> tuple[str, ...]:
    noted = [line for line in library.output if line.startswith(("Note", "Warning"))]
    told = [line.strip() for line in [*noted, *library.errors]]
    return tuple(line for line in told if line and not _STEPPING.match(line))


def _check_complete(waveforms: Waveforms, stop: float | None) -> None:
    for name, values in waveforms.values.items():
        if len(values) != waveforms.steps or not np.isfinite(values).all():
            raise SimulatorError(f"ngspice.{name}: not finite or cut short; check what drives it")
    if stop is None:
        return
    reached = float(waveforms.axis[-1]) if len(waveforms.axis) else 0.0
    if reached < stop * (1 - 1e-9):
        raise SimulatorError(f"ngspice: stopped at {reached} s, must reach {stop} s; check reltol and tmax")
