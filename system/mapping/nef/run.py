"""A mapped network of values on a die, beside the equations that were asked for and ideal neurons.

    asked   y' = (T f(x) - y) / tau,  x = sum of y: no neurons, so that what is missing is their price
    ideal   leaky integrate-and-fire neurons that are drawn alike, as `chips.nef` has them for an ideal die
    chip    the die

All three take steps of 1 ms, in which inputs stand still; an input has the value of its last row until then.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from chips.nef.network.kernel import DT
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.errors import DataError, ParameterError
from circuits.silicon.silicon import Silicon
from system.mapping.distance import apart
from system.mapping.nef.equations import Equations
from system.mapping.nef.mapped import MappedValues, ideal_of
from system.mapping.nef.network import ValueNetwork
from system.option import option, required
from system.rows import read_rows

SETTLING = 0.1  # s, before outputs are compared; ours
AFTER = 0.5  # s of a run behind the last row of its inputs; ours
Outputs = Mapping[str, F64]  # float64[steps, numbers] of each probe


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a file of inputs: the value of a channel from a time on."""

    time: float = required("From when on", unit="s", name="time_s", least=0.0)
    value: float = required("The value", unit="")
    channel: int = option(0, "Its number, one input after the other", least=0)


@dataclass(frozen=True, slots=True)
class ValueRun:
    """What a run leaves.

    asked, ideal, chip : outputs of each probe, float64[steps, numbers]; from_asked, from_ideal,
    ideal_from_asked : root mean square of the difference of each output over its largest value, of the die
    or of ideal neurons; begin, duration : when comparing begins, and the end, s; counters : what the chip
    counts; later : rows of the inputs for times after the end, of which nothing came.
    """

    asked: Outputs
    ideal: Outputs
    chip: Outputs
    from_asked: dict[str, float]
    from_ideal: dict[str, float]
    ideal_from_asked: dict[str, float]
    begin: float
    duration: float
    counters: dict[str, int]
    later: int


def read_values(path: str, network: ValueNetwork) -> tuple[Row, ...]:
    """Read the inputs of a run; raises `DataError` for a channel that no input has, or times that go back."""
    found, before = [], 0.0
    for line, row in read_rows(path, Row):
        if row.channel not in range(network.channels):
            most, names = network.channels - 1, ", ".join(p.name for p in network.inputs) or "no input"
            raise DataError(f"{path}:{line}: channel {row.channel:g}, must be 0 to {most}, those of {names}")
        if row.time < before:
            raise DataError(f"{path}:{line}: {row.time:g} s, must not be before the row above; sort the rows")
        found.append(replace(row, channel=int(row.channel)))
        before = row.time
    return tuple(found)


def run_values(
    mapped: MappedValues, rows: tuple[Row, ...], silicon: Silicon, duration: float | None = None, *,
    kind: BiasKind = "generator", codes: Literal["calibrated", "default"] = "calibrated",
) -> ValueRun:  # fmt: skip
    """Run a mapped network of values.

    Parameters
    ----------
    mapped
        The network on its chip.
    rows
        Values of its inputs, in order of their times.
    silicon
        Process, temperature and die, whose biases are calibrated there.
    duration
        Of the run, s; until a little after the last row unless given.
    kind
        Kind of the biases.
    codes
        Whether neurons are measured and decoders solved on the die, or the program's own codes stay.

    Raises
    ------
    ParameterError
        The run is not longer than what it takes to settle.
    """
    last = rows[-1].time if rows else 0.0
    steps = math.ceil((last + AFTER if duration is None else duration) / DT - 1e-9)
    if not steps * DT > SETTLING:
        raise ParameterError(
            f"duration: {steps * DT:g} s, must be > {SETTLING:g} s, after which outputs are compared"
        )
    given = _given(mapped.network, rows, steps)
    simulation = Simulation(mapped.on(silicon, kind, solved=codes == "calibrated"))
    chip = simulated(simulation, mapped.network, given, steps)
    ideal = simulated(Simulation(ideal_of(mapped.network)), mapped.network, given, steps)
    exact = equations(mapped.network, given, steps)
    pairs = ((chip, exact), (chip, ideal), (ideal, exact))
    off = [{name: _apart(one[name], other[name]) for name in chip} for one, other in pairs]
    later = sum(round(row.time / DT) >= steps for row in rows)
    return ValueRun(
        exact, ideal, chip, off[0], off[1], off[2], SETTLING, steps * DT, simulation.counters, later
    )


def simulated(run: Simulation, network: ValueNetwork, given: Mapping[str, F64], steps: int) -> Outputs:
    """Return what probes show at the end of each step, with inputs float64[steps, size] by name."""
    seen: dict[str, list[F64]] = {probe.name: [] for probe in network.probes}
    for k in range(steps):
        for name, values in given.items():
            run.set(name, values[k])
        run.advance(DT)
        for name, shown in seen.items():
            shown.append(run.read(name))
    return {name: np.array(shown) for name, shown in seen.items()}


def equations(network: ValueNetwork, given: Mapping[str, F64], steps: int) -> Outputs:
    """Return likewise what the equations do that were asked for, without neurons."""
    run = Equations(network)
    seen: dict[str, list[F64]] = {probe.name: [] for probe in network.probes}
    for k in range(steps):
        for name, values in given.items():
            run.set(name, values[k])
        run.step()
        for name, shown in seen.items():
            shown.append(run.read(name))
    return {name: np.array(shown) for name, shown in seen.items()}


def _given(network: ValueNetwork, rows: tuple[Row, ...], steps: int) -> dict[str, F64]:
    values = np.zeros((steps, network.channels))
    for row in rows:
        values[round(row.time / DT) :, row.channel] = row.value
    found, first = {}, 0
    for one in network.inputs:
        found[one.name] = values[:, first : first + one.size]
        first += one.size
    return found


def _apart(one: F64, other: F64) -> float:
    return apart(one, other, np.arange(1, len(one) + 1) * DT > SETTLING)
