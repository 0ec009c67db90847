"""The process that measurements of a chip fix, and the die that it is.

From one die, V_T0 and the current factor are that die's. What no measurement reads, or what the fit leaves
as wide as it was before, is free. The area law A_VT comes from the spread of the ring's inputs with their
mirrors and readout, and the pair's offset; that of the current factor, and areas of their own, are free.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from circuits.extraction.coach.bench import process_of
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.joint import Fit
from circuits.extraction.coach.models import fit_all, matching
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Posterior
from circuits.extraction.extraction import rounded
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.edit import Edit
from circuits.silicon.process import Process

Data = Mapping[str, tuple[Condition, Table]]
_RING = ("ring-converters", "ring-inputs")  # what A_VT needs


@dataclass(frozen=True, slots=True, eq=False)
class Chip:
    """A process extracted from a chip's measurements.

    process: the process. fit: the fit of all unknowns, from which it comes. a_vt: A_VT of a pair and its
    standard error, V m; None where the measurements do not fix it. free: numbers of the process that the
    measurements do not fix: they stay as in the base.
    """

    process: Process
    fit: Fit
    a_vt: tuple[float, float] | None
    free: tuple[str, ...]


def extract_chip(data: Data, conditions: Mapping[str, Condition], base: Process, name: str) -> Chip:
    """Extract a process from a chip's measurements.

    Parameters
    ----------
    data
        Measurements by name.
    conditions
        What was set at all measurements, fitted or not.
    base
        What the fit begins with, and what it keeps where nothing is fixed.
    name
        Name of the process that is made.

    Raises
    ------
    DataError
        There are fewer points than numbers of the process, or the fit does not converge.
    """
    found, a_vt = fit_all(data, conditions, base), None
    if set(_RING) <= {condition.circuit for condition, _ in data.values()}:
        a_vt = matching(found.posterior.values())
        base = replace(base, pair_a_vt=a_vt[0])
        found = fit_all(data, conditions, base, found.posterior.values(), found.factors, rounds=1)
        a_vt = matching(found.posterior.values())
    free = [n for n in found.posterior.free() if n.startswith(("n.", "p."))]
    kept = {u.name: u.mean for u in found.posterior.unknowns if u.name in free}
    process = process_of({**found.posterior.values(), **kept}, base)
    process = replace(process, name=name, cards="", n=rounded(process.n), p=rounded(process.p))
    free += ["pair_a_beta", *(() if a_vt else ("pair_a_vt",))]
    return Chip(process, found, a_vt, tuple(free))


def identify_chip(data: Data, conditions: Mapping[str, Condition], process: Process) -> Fit:
    """Find how a chip deviates from its process, under the process's area law; as `extract_chip`."""
    return fit_all(data, conditions, process)


def die_of(posterior: Posterior) -> Die:
    """The nominal die with the deviations that were found of its devices."""
    edits = [
        Edit("set", (name.rpartition(".")[0],), name.rpartition(".")[2], float(mean))
        for name, mean, u in zip(posterior.names, posterior.mean, posterior.unknowns, strict=True)
        if u.kind == "device" and u.unit == "V" and name not in posterior.free()
    ]
    return replace(NOMINAL, edits=tuple(edits))
