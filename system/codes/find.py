"""Codes of a chip on a die: those that ship, those that were found before, else a calibration.

What a calibration finds is kept in the user's cache folder, by all that it depends on: the silicon, the kind
of the biases, the temperature of the bench, and the sources of circuits, chips and the calibration itself. So
a die is calibrated once, and anew after any of these has changed; of threads and processes that ask for it at
the same time one calibrates, and the others wait. A calibration is announced in a line on
stderr, since it takes seconds to minutes. Codes that ship for a die are refused where the law that they were
found by has changed since.
"""

from __future__ import annotations

import os
from collections.abc import Hashable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import replace
from functools import lru_cache
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from sys import modules

from chips.codes import Codes, Key, key_of
from chips.law_lattice import key_changed, law_key
from chips.record import record_key
from chips.record_file import cache_folder
from circuits.circuit import BiasKind
from circuits.errors import DataError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.silicon import Silicon
from system.codes.file import read_codes, write_codes
from system.files.claim import alone
from system.files.kept import sources_of
from system.notice import say
from system.registry import load_calibration

_KEPT = 512  # codes that a process keeps; ours
_quiet: ContextVar[bool] = ContextVar("quiet", default=False)


@contextmanager
def quietly() -> Iterator[None]:
    """Inside, a calibration is not announced: a study says once that it calibrates every die."""
    token = _quiet.set(True)
    try:
        yield
    finally:
        _quiet.reset(token)


def codes_on(name: str, silicon: Silicon, kind: BiasKind, setup: Hashable = None) -> Codes:
    """Return the codes of a chip that can be used, on a silicon, calibrated at its temperature, found once.

    Parameters
    ----------
    name
        Name of the calibration.
    silicon
        Process, temperature of the bench, and die.
    kind
        Kind of the chip's biases.
    setup
        What the chip is set up for; as its calibration states unless given.

    Raises
    ------
    UnknownNameError
        No calibration has the name.
    ParameterError
        The chip cannot be calibrated there; the text says which part and why.
    DataError
        The codes that ship are of another law.
    """
    found = codes_found(name, silicon, kind, setup)
    found.check(name, silicon, kind, setup_of(name, setup))
    return found


def setup_of(name: str, setup: Hashable = None) -> Hashable:
    """Return what a chip is set up for: `setup`, or as its calibration states where that is None."""
    return load_calibration(name).setup if setup is None else setup


def calibrated_anew(name: str, silicon: Silicon, kind: BiasKind, setup: Hashable = None) -> Codes:
    """Calibrate a chip on a silicon, whatever was found before; arguments and errors as of `codes_on`."""
    found = load_calibration(name).calibrate(silicon, kind, setup_of(name, setup))
    return found if found.law else replace(found, law=law_key(silicon.process))


def kept_anew(name: str, silicon: Silicon, kind: BiasKind, setup: Hashable = None) -> Codes:
    """As `calibrated_anew`; what it finds of a chip that can be used is kept for later."""
    codes = calibrated_anew(name, silicon, kind, setup)
    if not codes.failed:
        _keep(cached_file(name, key_of(silicon, kind, setup_of(name, setup)), silicon.temperature_c), codes)
    return codes


def codes_found(name: str, silicon: Silicon, kind: BiasKind, setup: Hashable = None) -> Codes:
    """Return what a calibration found, of a chip that cannot be used too; arguments as of `codes_on`.

    That a chip cannot be used is found anew each time: another answer to what is outside of a model's box
    (`chips.validity`) may make it work.
    """
    try:
        return _usable(name, silicon, kind, setup)
    except _FailedError as error:
        return error.codes


class _FailedError(Exception):
    """A chip that cannot be used, which no cache keeps."""

    def __init__(self, codes: Codes) -> None:
        super().__init__(codes.failed)
        self.codes = codes


@lru_cache(maxsize=_KEPT)
def _usable(name: str, silicon: Silicon, kind: BiasKind, setup: Hashable) -> Codes:
    key = key_of(silicon, kind, setup_of(name, setup))
    shipped = _shipped(name, silicon, key)
    other = "" if shipped is None else key_changed(shipped.law, silicon.process)
    if shipped is not None and not other:
        return shipped
    kept = cached_file(name, key, silicon.temperature_c)
    if kept.is_file():
        return read_codes(kept)
    if other:
        raise _stale(name, silicon.die, other)
    with alone(kept.with_suffix(".lock")):
        if kept.is_file():  # whoever was asked at the same time has found them
            return read_codes(kept)
        if not _quiet.get():
            say(f"calibrating {name} on {silicon.die} at {silicon.temperature_c:g} degC, once")
        codes = kept_anew(name, silicon, kind, setup)
    if codes.failed:
        raise _FailedError(codes)
    return codes


def _stale(name: str, die: Die, reason: str) -> DataError:
    """The error for codes of another law, with the command that finds them anew, its options as fields."""
    words = [f"run noctule calibrate {name}"]
    words += [] if die.number is None else [f"die={die.number}"]
    words += [] if die.lot == NOMINAL.lot else [f"lot={die.lot}"]
    return DataError(f"codes of {name}, {die}: of {reason}; {' '.join(words)}")


def _shipped(name: str, silicon: Silicon, key: Key) -> Codes | None:
    """The codes with a key that ship, at the silicon's temperature; None without such."""
    path = shipped_file(name, silicon)
    codes = read_codes(path) if path.is_file() else None
    if codes is None or codes.key != key or codes.calibrated_c != silicon.temperature_c:
        return None
    return codes


def shipped_file(name: str, silicon: Silicon) -> Path:
    """Return where the codes of a chip on a die would ship, at any temperature; it need not exist."""
    number = "nominal" if silicon.die.number is None else f"{silicon.die.lot}_{silicon.die.number}"
    if silicon.die.edits:
        number += f"_edited_{sha256(repr(silicon.die.edits).encode()).hexdigest()[:8]}"
    return Path(str(files("chips"))) / "calibrated" / f"{name.replace('-', '_')}_{number}.toml"


def cached_file(name: str, key: Key, calibrated_c: float) -> Path:
    """Return where codes with a key that were found at a temperature, degC, are kept; it need not exist."""
    digest = record_key(key, calibrated_c, _sources(name))
    return codes_folder() / f"{name}-{digest}.toml"


def codes_folder() -> Path:
    """Return the folder in which codes are kept; it need not exist."""
    return cache_folder() / "codes"


def _keep(path: Path, codes: Codes) -> None:
    """Keep codes for later; where no cache can be written (`noctule doctor` says so) none are kept."""
    with suppress(OSError, DataError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_codes(path, codes)


def _sources(name: str) -> str:
    """Hash of all sources and records that codes of a calibration follow from."""
    module = modules[load_calibration(name).calibrate.__module__]
    return sources_of(Path(module.__file__ or os.devnull).parent)
