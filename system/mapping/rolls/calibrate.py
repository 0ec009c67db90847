"""The weights of a mapped network on a die: codes by which its synapses do what they do on the nominal one.

On a bench the chip's neurons are shared out among the weights in use, the virtual ones and each level, and no
neuron is connected to another. Every neuron gets regular events through its weight that bring `AIM` times
the rheobase on the nominal die; where the weight inhibits, beside `EXCITED` times the rheobase of virtual
excitation. Codes are searched until the mean rate of each share is the nominal die's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from chips.rolls.calibration import Knob, Target, Task, calibrate, neuron_rates
from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.circuit import FILTERS
from chips.rolls.program.address import NEURONS, NONPLASTIC
from chips.rolls.program.population import Population
from chips.rolls.program.program import Program, VirtualInput
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.mapping.rolls.filters import BESIDE, COLUMNS, EXTRA, FIRST_OF, SIGN, regular, together
from system.mapping.rolls.mapped import Mapped, PlacedFilter

AIM, EXCITED = 2.5, 4.5  # rheobases; ours
ROUNDS = 10  # runs of the search at most; ours
_FIRST, _WIDE = 200, 4  # of the columns of the bench, and how many each level has


class Share(NamedTuple):
    """Neurons that measure a weight.

    bias : that it hangs on; filter : its own; level : 0 for a virtual one; weight : A; neurons : of the chip.
    """

    bias: str
    filter: PlacedFilter
    level: int
    weight: float
    neurons: tuple[int, ...]


class _Bench(NamedTuple):
    """What is run, the rates of the nominal die, what is searched, and events of a duration (s)."""

    program: Program
    targets: tuple[Target, ...]
    knobs: tuple[Knob, ...]
    drive: Callable[[float], Inputs]


def calibrated(mapped: Mapped, silicon: Silicon, kind: BiasKind = "generator") -> Mapped:
    """Return a mapped network with the codes of its weights searched on a die.

    Parameters
    ----------
    mapped
        The network on its chip.
    silicon
        Process, temperature and die.
    kind
        Kind of the biases.

    Raises
    ------
    ParameterError
        No input excites, so that a bench has nothing to measure inhibition beside.
    """
    bench = _bench(mapped, kind)
    found = calibrate(Task(bench.program, bench.targets, bench.knobs, bench.drive, 0), silicon, kind, ROUNDS)
    return replace(mapped, program=replace(mapped.program, biases=found.biases))


@lru_cache(maxsize=2)  # of the network, and events of a second
def _bench(mapped: Mapped, kind: BiasKind) -> _Bench:
    """What all dies are measured with; raises `ParameterError` as `calibrated`."""
    known = {f.name: f for f in mapped.filters}
    if BESIDE not in known:
        raise ParameterError("calibrate: no input excites, which a bench needs; leave it out")
    shares = tuple(_shares(mapped))
    program = _program(mapped, shares)
    drive = lru_cache(maxsize=1)(partial(_drive, mapped, shares, known[BESIDE]))
    nominal = neuron_rates(RollsChip(program, Silicon(ROLLS_180), kind), drive)
    targets = tuple(
        Target(Population(s.bias, s.neurons), float(nominal[list(s.neurons)].mean())) for s in shares
    )
    knobs = tuple(Knob(s.bias, (s.bias,), SIGN[s.filter.name]) for s in shares)
    return _Bench(program, targets, knobs, drive)


def _shares(mapped: Mapped) -> Iterator[Share]:
    """The weights in use, each with the neurons that measure it."""
    found = []
    for one in mapped.filters:
        if one.name in FILTERS[2:]:
            found.append((FIRST_OF[one.name], one, 0))
            continue
        used = set(np.unique(mapped.program.levels * SIGN[one.name]).tolist())
        levels = {1} | ({2} if used & {2, 4} else set()) | ({3} if used & {3, 4} else set())
        biases = (FIRST_OF[one.name], *EXTRA[one.name])
        found += [(biases[k - 1], one, k) for k in sorted(levels)]
    for k, (bias, one, level) in enumerate(found):
        yield Share(bias, one, level, one.weights[max(level, 1) - 1], tuple(range(k, NEURONS, len(found))))


def _program(mapped: Mapped, shares: tuple[Share, ...]) -> Program:
    """The program of the bench."""
    levels = np.zeros((NEURONS, NEURONS), np.int8)
    for share in (s for s in shares if s.level):
        columns = [c - NONPLASTIC for c in _columns(share)]
        levels[np.ix_(share.neurons, columns)] = SIGN[share.filter.name] * share.level
    everywhere = tuple(range(NEURONS))
    inputs = VirtualInput("excite", everywhere), VirtualInput("inhibit", everywhere, inhibitory=True)
    off = mapped.program.biases.is_off(FIRST_OF[FILTERS[3]])
    return Program(levels, mapped.program.biases, (), inputs[:1] if off else inputs)


def _columns(share: Share) -> range:
    """Columns of the bench's synapses of a share."""
    if not share.level:
        return COLUMNS[share.filter.name]
    place = share.level - 1 + 3 * (SIGN[share.filter.name] < 0)
    return range(NONPLASTIC + _FIRST + _WIDE * place, NONPLASTIC + _FIRST + _WIDE * (place + 1))


def _drive(mapped: Mapped, shares: tuple[Share, ...], beside: PlacedFilter, duration: float) -> Inputs:
    """Events of every neuron of the bench."""
    rheobase = min((p for p in mapped.placed), key=lambda p: p.slow).rheobase
    parts = []
    for share in shares:
        rate = share.filter.rate(AIM * rheobase, share.weight)
        steady = beside.rate(EXCITED * rheobase, beside.weights[0]) if SIGN[share.filter.name] < 0 else 0.0
        for k in share.neurons:
            parts.append(regular(k % 16, _columns(share), rate, duration, k))
            parts.append(regular(k % 16, COLUMNS[BESIDE], steady, duration, k))
    return together(parts)
