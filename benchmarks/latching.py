"""Claims: networks of nengo that latch go through nengo's own states on the NEF chip, with nengo's values.

A ring of bits, each a master and a slave that hold themselves, clocked through gates that are shut on their
`.neurons`; its first bit takes the last one's opposite, so that one bit has two states and two have four.
Nengo's gated memory is set, closed, set anew and closed; its basal ganglia and thalamus choose among three.
Ensembles of 200 neurons, memories of 200, a choice of 100 and 60; membranes drawn as nengo draws them, full
law, no noise. Read at the end of each half of the clock's period, of each of the memory's phases and choices.

On the nominal chip a mean size there is within 5 % of nengo's, and all states are nengo's, for two seeds. On
19 of 20 dies A/1010 to 1029, calibrated, they are nengo's for one seed. What ensembles decode beyond their
radius, driven from 0.5 to 3, stands beside for the same dies, as do a function with a sharp point, two inputs
that should cancel, and where a ramp switches an ensemble that feeds itself: no claim is on these. The ideal
back-end has the rows of nengo, which are tested.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import nengo
import numpy as np

from _report import Row, parser_of, report
from chips.nef.chip import NefChip
from chips.nef.nengo.simulator import Simulator
from circuits.arrays import F64
from circuits.silicon.die import NOMINAL, Die

HALF, PERIODS = 0.2, 8  # s of half a period of the clock, and how many periods
NEURONS = 200
FIRST, DIES = 1010, 20
DRIVEN = (0.5, 1.0, 1.2, 1.5, 2.0, 3.0)  # radii
RAMP = 4.0  # s
LONG, READ = 0.6, 0.2  # s of a run of what stands still, and of its end that is read
Made = tuple[nengo.Network, list[Any]]
Simulated = Callable[[nengo.Network], Any]


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "two dies").parse_args()
    return report(rows(2 if options.quick else DIES), options)


def rows(dies: int) -> Iterator[Row]:
    """Rows of all networks that latch, and of what stands still."""
    warnings.simplefilter("ignore")
    for name, (make, read) in LATCHING.items():
        wanted = [read(by_nengo, make(seed)) for seed in (1, 2)]
        nominal = [read(on(NOMINAL), make(seed)) for seed in (1, 2)]
        size = max(abs(b[1] / a[1] - 1.0) for a, b in zip(wanted, nominal, strict=True))
        same = sum(a[0] == b[0] for a, b in zip(wanted, nominal, strict=True)) / 2
        yield Row(f"{name}, nominal, values off nengo's", size, None, size, "two seeds", most=0.05)
        yield Row(f"{name}, nominal, states as nengo's", same, None, same, "two seeds", least=1.0)
        found = [read(on(Die(number=FIRST + k)), make(1)) for k in range(dies)]
        share = sum(each[0] == wanted[0][0] for each in found) / dies
        off = max(abs(each[1] / wanted[0][1] - 1.0) for each in found)
        told = f"{dies} dies; values at most {off:.1%} off"
        yield Row(f"{name}, dies with nengo's states", share, None, share, told, least=0.95)
    yield from _still(dies)


def _still(dies: int) -> Iterator[Row]:
    wanted, nominal = still(by_nengo), still(on(NOMINAL))
    found = np.array([still(on(Die(number=FIRST + k))) for k in range(dies)])
    names = [f"driven with {x:g}" for x in DRIVEN]
    names += ["1 - 5 abs(x) at 0", "0.6 and -0.6 together", "x <- in + x - 0.5 switches at"]
    for name, a, b, each in zip(names, wanted, nominal, found.T, strict=True):
        told = f"nengo {a:.3f}, nominal {b:.3f}, dies {each.min():.3f} to {each.max():.3f}"
        largest = float(max(abs(b - a), np.abs(each - a).max()))
        yield Row(f"{name}, largest difference", b, a, largest, told)


def by_nengo(network: nengo.Network) -> Any:
    """Nengo's own simulator."""
    return nengo.Simulator(network, progress_bar=False)


def on(die: Die) -> Simulated:
    """The chip of a die, calibrated."""
    return lambda network: Simulator(network, progress_bar=False, chip=NefChip(die))


def clock(t: float) -> float:
    """1 in the first half of each period."""
    return 1.0 if t % (2.0 * HALF) < HALF else 0.0


def ring(bits: int) -> Callable[[int], Made]:
    """A machine of two states a bit, by its seed."""

    def made(seed: int) -> Made:
        with nengo.Network(seed=seed) as network:
            high, low = nengo.Node(clock), nengo.Node(lambda t: 1.0 - clock(t))
            begin = nengo.Node(lambda t: 1.5 if t < 0.5 * HALF else 0.0)
            slaves = [_holding(seed + 10 * k, begin) for k in range(bits)]
            masters = [_holding(seed + 10 * k + 1, begin) for k in range(bits)]
            for k in range(bits):
                sign = 1.0 if k else -1.0
                _gated(seed + 10 * k + 2, slaves[k - 1], sign, masters[k], low)
                _gated(seed + 10 * k + 3, masters[k], 1.0, slaves[k], high)
            probes = [nengo.Probe(each, synapse=0.02) for each in slaves]
        return network, probes

    return made


def _holding(seed: int, begin: nengo.Node) -> nengo.Ensemble:
    """An ensemble that holds its sign."""
    ensemble = nengo.Ensemble(NEURONS, 1, seed=seed)
    nengo.Connection(ensemble, ensemble, function=np.sign, synapse=0.05)
    nengo.Connection(begin, ensemble, synapse=None)
    return ensemble


def _gated(seed: int, source: nengo.Ensemble, sign: float, target: nengo.Ensemble, shut: nengo.Node) -> None:
    """A connection through an ensemble whose neurons are shut."""
    gate = nengo.Ensemble(NEURONS, 1, seed=seed)
    nengo.Connection(source, gate, transform=sign, synapse=0.01)
    nengo.Connection(shut, gate.neurons, transform=[[-4.0]] * NEURONS, synapse=0.005)
    nengo.Connection(gate, target, transform=2.0, synapse=0.01)


def memory(seed: int) -> Made:
    """Nengo's gated memory: set to 0.8, closed, set to -0.6, closed."""
    with nengo.Network(seed=seed) as network:
        held = nengo.networks.InputGatedMemory(NEURONS, 1, seed=seed)
        value = nengo.Node(lambda t: 0.8 if t < 1.2 else -0.6)
        shut = nengo.Node(lambda t: 0.0 if t < 0.8 or 1.6 < t < 2.4 else 1.0)
        nengo.Connection(value, held.input, synapse=None)
        nengo.Connection(shut, held.gate, synapse=None)
        probes = [nengo.Probe(held.output, synapse=0.03)]
    return network, probes


def choice(seed: int) -> Made:
    """Basal ganglia and thalamus, whose best of three changes every half second."""
    with nengo.Network(seed=seed) as network:
        ganglia = nengo.networks.BasalGanglia(3, 100, seed=seed)
        thalamus = nengo.networks.Thalamus(3, 60, seed=seed)
        worth = nengo.Node(lambda t: np.roll([0.9, 0.5, 0.3], int(t / 0.5)))
        nengo.Connection(worth, ganglia.input, synapse=None)
        nengo.Connection(ganglia.output, thalamus.input)
        probes = [nengo.Probe(thalamus.output, synapse=0.03)]
    return network, probes


def _at(simulated: Simulated, made: Made, ends: F64, before: float) -> F64:
    """Means of what is probed over `before` s in front of some times, float64[times, values]."""
    network, probes = made
    with simulated(network) as run:
        run.run(float(ends[-1]))
        time, values = run.trange(), np.hstack([run.data[probe] for probe in probes])
    return np.array([values[(time > end - before) & (time <= end)].mean(axis=0) for end in ends])


def signs(simulated: Simulated, made: Made) -> tuple[str, float]:
    """Signs of all bits at the end of each half period, and their mean size."""
    found = _at(simulated, made, HALF * np.arange(1, 2 * PERIODS + 1), 0.03)
    return "".join("+" if x > 0.0 else "-" for x in found.ravel()), float(np.abs(found).mean())


def held(simulated: Simulated, made: Made) -> tuple[str, float]:
    """Signs of a memory at the end of each phase, 0 for less than half of the least, and their mean size."""
    found = _at(simulated, made, 0.8 * np.arange(1, 5), 0.1)
    told = ("0" if abs(x) < 0.3 else "+" if x > 0.0 else "-" for x in found.ravel())
    return "".join(told), float(np.abs(found).mean())


def chosen(simulated: Simulated, made: Made) -> tuple[str, float]:
    """Which one is chosen at the end of each half second, and the mean of its value."""
    found = _at(simulated, made, 0.5 * np.arange(1, 7), 0.1)
    return "".join(map(str, found.argmax(axis=1))), float(found.max(axis=1).mean())


LATCHING: dict[str, tuple[Callable[[int], Made], Callable[[Simulated, Made], tuple[str, float]]]] = {
    "two states": (ring(1), signs), "four states": (ring(2), signs), "gated memory": (memory, held),
    "choice of three": (choice, chosen),
}  # fmt: skip


def still(simulated: Simulated) -> F64:
    """What is decoded of all that stands still, and where a ramp switches what holds itself.

    Means of seeds 0 and 1, then of 0 to 2 for two values, and seed 1 for the ramp.
    """
    driven = np.mean([_last(simulated, _driven(seed)) for seed in (0, 1)], axis=0)
    two = np.mean([_last(simulated, _two(seed)) for seed in (0, 1, 2)], axis=0)
    return np.concatenate([driven, two, [_switched(simulated, 1)]])


def _last(simulated: Simulated, made: Made) -> F64:
    return _at(simulated, made, np.array([LONG]), READ)[0]


def _driven(seed: int) -> Made:
    with nengo.Network(seed=seed) as network:
        probes = []
        for k, value in enumerate(DRIVEN):
            ensemble = nengo.Ensemble(NEURONS, 1, seed=100 * seed + k)
            nengo.Connection(nengo.Node(value), ensemble)
            probes.append(nengo.Probe(ensemble, synapse=0.03))
    return network, probes


def _two(seed: int) -> Made:
    with nengo.Network(seed=seed) as network:
        sharp, both = nengo.Ensemble(100, 1, seed=seed), nengo.Ensemble(NEURONS, 1, seed=seed + 70)
        shown = nengo.Node(size_in=1)
        nengo.Connection(nengo.Node(0.0), sharp)
        nengo.Connection(sharp, shown, function=lambda x: 1.0 - 5.0 * abs(x), synapse=0.03)
        nengo.Connection(nengo.Node(0.6), both, synapse=None)
        nengo.Connection(nengo.Node(-0.6), both, synapse=0.005)
        probes = [nengo.Probe(shown), nengo.Probe(both, synapse=0.03)]
    return network, probes


def _switched(simulated: Simulated, seed: int) -> float:
    """Input at which `x <- in + x - 0.5` rises through 0, ramped from 0 to 1 in `RAMP` s."""
    with nengo.Network(seed=seed) as network:
        ramp, ensemble = nengo.Node(lambda t: t / RAMP - 0.5), nengo.Ensemble(NEURONS, 1, seed=seed)
        nengo.Connection(ramp, ensemble)
        nengo.Connection(ensemble, ensemble)
        probe = nengo.Probe(ensemble, synapse=0.01)
    with simulated(network) as run:
        run.run(RAMP)
        below = np.flatnonzero(run.data[probe][:, 0] < 0.0)
        return float(run.trange()[below[-1]] / RAMP)


if __name__ == "__main__":
    sys.exit(main())
