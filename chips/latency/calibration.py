"""Calibration of a latency chip: bias codes that bring its times on a die to those of its design.

What a tester can time, and what a bias line then corrects, `I -> I T / T_wanted`, as near as codes come:

    taps          each tap's delay, by its own code
    integrators   each integrating neuron's latency for one input, the mean over its synapses, by its own code
    race          each first-layer cell's latency without any input, by its own code
    shared        all other times, the mean over the die, by the code of their line

On the bench one thing is timed after another, in every round of the search. Which of them are calibrated is
a choice; the chip is what it is for the rest. Times are the model's own, at the temperature of the silicon
that is given, as a tester would have them from spikes; `ROUNDS` times, so that what one code changes for
another settles. Currents of goal, direction, inhibition and second layer are scaled together, each line's
copies alike.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.codes import Codes, Measured, attempted, codes_near, left_off
from chips.latency.design import Biases, Design
from chips.latency.model import Lumped, lumped, usual_biases
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

PARTS = ("taps", "integrators", "race", "shared")
ROUNDS = 3  # unless said
MORE_ROUNDS = 8  # of the chip of a robot; ours
OFF = 0.1  # share of a time beyond which it is told to stay off; ours
NAME = "latency-chip"  # of the calibration
_TIMED = ("step", "window", "tonic", "hold", "block", "inhibition")  # of `Lumped`, s, beside arrays

# line: quantity of `Lumped` whose mean is its time
_TIMES: Mapping[str, str] = {
    "step": "step", "window": "window", "tonic": "tonic", "hold": "hold", "block": "block",
    "pulse": "goal_pulse", "inhibition": "inhibition",
}  # fmt: skip


def calibrated(
    design: Design,
    silicon: Silicon,
    kind: BiasKind = "gate",
    parts: Collection[str] = PARTS,
    *,
    area: float = 1.0,
    rounds: int = ROUNDS,
) -> Biases:
    """Return the biases of the chip on a silicon, calibrated at its temperature.

    They bring the times to those of the nominal die under the ideal law, as the design states them.

    Parameters
    ----------
    design
        What the chip is designed for.
    silicon
        Process, temperature and die.
    kind
        Kind of the biases.
    parts
        Which of `PARTS` are calibrated.
    area
        Area of the devices over the circuits', a ratio.
    rounds
        How often everything is timed and moved.

    Raises
    ------
    ParameterError
        A part is another, or no code reaches a current.
    """
    for part in parts:
        if part not in PARTS:
            raise ParameterError(f"latency_chip.calibration: {part}, must be one of {', '.join(PARTS)}")
    biases = usual_biases(design, kind, silicon.process)
    wanted = designed(design, silicon.process)
    nearest: dict[str, tuple[F64, F64]] = {}  # of each line: least error in a logarithm, and its current
    for _ in range(rounds):
        factors = _factors(lumped(design, biases, silicon, area), wanted, parts)
        current = {name: biases.lines[name].current for name in factors}
        for name, factor in factors.items():
            nearest[name] = _nearer(nearest.get(name), np.abs(np.log(factor)), current[name])
        biases = biases.with_currents({name: current[name] * factor for name, factor in factors.items()})
    return biases.with_currents({name: current for name, (_, current) in nearest.items()})


def _nearer(before: tuple[F64, F64] | None, error: F64, current: F64) -> tuple[F64, F64]:
    """Least error of each element of a line so far, and its current, A.

    A generator's lines do not rise with every step of their codes, so that the last round is not the best.
    """
    error = np.broadcast_to(error, current.shape)
    if before is None:
        return error, current
    return np.minimum(error, before[0]), np.where(error < before[0], current, before[1])


def designed(design: Design, process: Process) -> Lumped:
    """Return the times of a design: of its nominal chip under the ideal law, at gates that set them."""
    ideal = process.under("ideal")
    return lumped(design, usual_biases(design, "gate", ideal), Silicon(ideal))


def _factors(found: Lumped, wanted: Lumped, parts: Collection[str]) -> dict[str, F64]:
    """What each line's currents are multiplied by."""
    factors: dict[str, F64] = {}
    if "taps" in parts:
        factors["tap"] = found.tap / wanted.tap
    if "integrators" in parts:
        factors["integrating"] = _alone(found) / _alone(wanted)
    cell, usual = found.race / found.passive, wanted.race / wanted.passive
    if "race" in parts:
        factors["passive"] = cell / usual
    if "shared" in parts:
        factors |= _shared(found, wanted)
        if "race" not in parts:
            factors["passive"] = np.asarray((cell / usual).mean())
    return factors


def _shared(found: Lumped, wanted: Lumped) -> dict[str, F64]:
    """Factors of lines that the whole die shares, each of the mean over the die."""

    def ratio(time: F64, usual: F64) -> F64:
        return np.asarray(time.mean() / usual.mean())

    factors = {
        line: ratio(getattr(found, name), getattr(wanted, name)) for line, name in _TIMES.items()
    }  # fmt: skip
    factors["goal"] = ratio(np.diag(wanted.goal * wanted.goal_pulse), np.diag(found.goal * found.goal_pulse))
    factors["direction"] = ratio(
        wanted.direction * wanted.direction_pulse, found.direction * found.direction_pulse
    )
    factors["inhibit"] = ratio(wanted.inhibit, found.inhibit)
    factors["second"] = ratio(found.second_charge / found.second, wanted.second_charge / wanted.second)
    factors["recurrent"] = ratio(found.recurrent, wanted.recurrent)
    factors["emergency"] = np.asarray(found.emergency / wanted.emergency)
    return factors


def _alone(c: Lumped) -> F64:
    """Latency of an integrating neuron for one input, s, the mean over its synapses, float64[n]."""
    return np.asarray((c.integrating[:, None] / c.synapse).mean(axis=1))


@dataclass(frozen=True, slots=True)
class Sized:
    """What a chip is set up for.

    design: what it is designed for. area: area of its devices over the circuits', a ratio.
    """

    design: Design
    area: float = 1.0


def calibrate(silicon: Silicon, kind: BiasKind, setup: Sized) -> Codes:
    """Calibrate the chip of a design on a silicon, at its temperature.

    A chip of which a line has no code for what it should have cannot be used.

    Arguments are those of `chips.codes.attempted`; setup: what it is designed for, and its size. Raises
    `OutsideBoxError` where its record was not measured for the silicon, or for a current that is tried.
    """
    return attempted(NAME, silicon, kind, setup, lambda begun: _found(begun, silicon, setup))


def _found(begun: Codes, silicon: Silicon, setup: Sized) -> Codes:
    """Codes of the chip on a silicon."""
    design, area, kind = setup.design, setup.area, begun.key.bias_kind
    before = lumped(design, usual_biases(design, kind, silicon.process), silicon, area)
    found = calibrated(design, silicon, kind, area=area, rounds=MORE_ROUNDS)
    wanted = designed(design, silicon.process)
    after = lumped(design, found, silicon, area)
    measured = tuple(_measured(wanted, before, after))
    return replace(
        begun, biases=codes_near({name: line.current for name, line in found.lines.items()}),
        measured=measured, bench_s=MORE_ROUNDS * sum(each.wanted for each in measured),
        unmended=left_off(measured, OFF),
    )  # fmt: skip


def _measured(wanted: Lumped, before: Lumped, after: Lumped) -> Iterator[Measured]:
    """Times of taps, integrating neurons and cells, and the mean of all others over the die."""

    def each(name: str, *times: object) -> Iterator[Measured]:
        arrays = [np.ravel(np.asarray(t, np.float64)) for t in times]
        for k, numbers in enumerate(zip(*arrays, strict=True)):
            yield Measured(f"{name}[{k}]", "s", *map(float, numbers))

    def cells(c: Lumped) -> object:
        return c.race / c.passive

    def neurons(c: Lumped) -> object:
        return (c.integrating[:, None] / c.synapse).mean(axis=1)

    yield from each("tap", wanted.tap, before.tap, after.tap)
    yield from each("integrating", *map(neurons, (wanted, before, after)))
    yield from each("race", *map(cells, (wanted, before, after)))
    for name in _TIMED:
        means = (float(np.mean(getattr(c, name))) for c in (wanted, before, after))
        yield Measured(name, "s", *means)


def biases_of(codes: Codes, design: Design, process: Process) -> Biases:
    """Return the biases of the chip of a design at codes."""
    usual = usual_biases(design, codes.key.bias_kind, process)
    shapes = {name: line.current.shape for name, line in usual.lines.items()}
    return usual.with_currents({n: np.reshape(i, shapes[n]) for n, i in codes.currents.items()})
