"""Runs of ngspice that are kept in pytest's cache, so that one whose deck is the same is not made again.

A run depends on its deck, on the library and on how it is read, which are all in its key; `pytest
--cache-clear` forgets what is kept, and without pytest's cache every run is made.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from netlists.ngspice import library
from netlists.ngspice import run as ngspice
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.run import Waveforms

UNUSED = 30 * 86_400.0  # s after which a run that no test asked for is dropped; ours


@dataclass(frozen=True, slots=True)
class KeptRuns:
    """Runs in a folder, and what makes those that are not there."""

    folder: Path
    make: Callable[..., Waveforms]

    def __call__(
        self, deck: str, *, vectors: tuple[str, ...] | None = None, deadline_s: float | None = DEADLINE
    ) -> Waveforms:
        """The run of a deck, as `netlists.ngspice.run.run` gives it; one that fails is not kept."""
        path = self.folder / f"{key_of(deck, vectors)}.npz"
        if path.is_file():
            path.touch()
            return loaded(path)
        found = self.make(deck, vectors=vectors, deadline_s=deadline_s)
        partial = path.with_name(f".{path.name}.{os.getpid()}.npz")  # another process may keep the same run
        save(found, partial)
        partial.replace(path)
        return found

    def drop_unused(self) -> None:
        """Drop runs that no test has asked for in a month."""
        for path in self.folder.glob("*.npz"):
            if time.time() - path.stat().st_mtime > UNUSED:
                path.unlink(missing_ok=True)


def key_of(deck: str, vectors: tuple[str, ...] | None) -> str:
    """Digest of all that a run's waveforms depend on."""
    path = library.find_library()
    assert path is not None
    # a bare name is one that only the linker finds
    state = (path.stat().st_size, path.stat().st_mtime_ns) if path.is_file() else library.version()
    digest = hashlib.sha256(repr((deck, vectors, str(path), state)).encode())
    for module in (ngspice, library):
        assert module.__file__ is not None
        digest.update(Path(module.__file__).read_bytes())
    return digest.hexdigest()


def save(found: Waveforms, path: Path) -> None:
    """Write waveforms to a file."""
    told = [found.analysis, found.axis_name, found.steps, found.messages, list(found.values)]
    np.savez(path, axis=found.axis, values=np.stack([*found.values.values()]), told=json.dumps(told))


def loaded(path: Path) -> Waveforms:
    """Waveforms of a file that `save` wrote."""
    with np.load(path) as kept:
        analysis, axis_name, steps, messages, names = json.loads(str(kept["told"]))
        values = dict(zip(names, kept["values"], strict=True))
        return Waveforms(analysis, axis_name, kept["axis"], values, steps, tuple(messages))
