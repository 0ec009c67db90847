"""A spiking network: populations of neurons, projections between them, and the spikes of a run.

Populations are named arrays of neurons, of inputs too; a projection joins neurons of two of them one by one.
`wire` makes them the arrays of `system.spiking_bat.network.kernel`, whose docstring gives the equations and
the order of delivery.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError, SolverError
from system.spiking_bat.network.hodgkin_huxley import CURRENT, DECAY_E, DECAY_I, LANES, ROWS, new_blocks
from system.spiking_bat.network.kernel import (
    ACTIVE,
    FOREVER,
    LOST,
    NOBODY,
    NOW,
    SPIKES,
    State,
    Wiring,
    advance,
)

Ints = I64 | int
Floats = F64 | float

STEP = 0.02e-3  # s, the paper's
_EVENTS = 2  # that may be put off at once, a synapse
_INTERVAL = 10e-3  # s, of room for a spike of every neuron; on average they spike far less often


@dataclass(frozen=True, slots=True)
class Conductors:
    """A population of Hodgkin-Huxley neurons; times in s, current in A/m^2."""

    shape: tuple[int, ...]
    tau_exc: float = 1e-3
    tau_inh: float = 8e-3
    current: float = 0.0


@dataclass(frozen=True, slots=True)
class Integrators:
    """Integrate-and-fire neurons. drive: I_0, thresholds a second; leak: 1/s; refractory: s, inf to release.

    drive is a number or an array of the shape.
    """

    shape: tuple[int, ...]
    leak: float = 0.0
    drive: Floats = 0.0
    refractory: float = 2e-3
    released: bool = False


@dataclass(frozen=True, slots=True)
class Inputs:
    """A population of sources whose spikes are given from outside.

    shape : of the array of sources.
    """

    shape: tuple[int, ...]


Population = Conductors | Integrators | Inputs


@dataclass(frozen=True, slots=True)
class Projection:
    """Synapses from neurons of one population to neurons of another, by their flat numbers in it.

    source, target, weight and delay (s) broadcast. To integrate-and-fire neurons the weight is a current in
    thresholds a second for `hold` s (inf: latched until the release); to others a peak conductance g_syn,
    S/m^2, inhibitory where it is below 0.
    """

    name: str
    source: str
    target: str
    pairs: tuple[Ints, Ints]
    weight: Floats
    delay: Floats = 0.0
    hold: float = 0.0


class Network(NamedTuple):
    """A wired network: where each population begins, and its shape; arrays for the kernel.

    first : number of each population's first neuron among all sources, by name.
    populations : of neurons and inputs, by name.
    wiring : its synapses, as arrays for the kernel.
    blocks : state at rest of the Hodgkin-Huxley neurons, as the kernel has it.
    slots : time steps that the ring of coming spikes spans, a power of two above the longest delay.
    """

    first: Mapping[str, int]
    populations: Mapping[str, Population]
    wiring: Wiring
    blocks: F64
    slots: int

    def number(self, name: str, *index: int) -> int:
        """Number of a neuron among all sources."""
        shape = self.populations[name].shape
        return self.first[name] + int(np.ravel_multi_index(index, shape) if index else 0)

    def size(self, name: str) -> int:
        """How many neurons a population has."""
        return math.prod(self.populations[name].shape)


@dataclass(frozen=True, slots=True)
class Spikes:
    """Spikes of a run: steps and sources, int64[n] each, in the order of time.

    network : whose spikes they are.
    step : when, in time steps, int64[n].
    source : which neuron or input, int64[n].
    """

    network: Network = field(repr=False)
    step: I64
    source: I64

    def of(self, name: str) -> tuple[F64, I64]:
        """Times (s, the end of the step) and flat numbers of a population's spikes."""
        first = self.network.first[name]
        mine = (self.source >= first) & (self.source < first + self.network.size(name))
        times = (self.step[mine] + 1) * self.network.wiring.step
        return np.asarray(times, dtype=np.float64), self.source[mine] - first


def wire(
    populations: Mapping[str, Population],
    projections: Sequence[Projection],
    release: str | None = None,
    step: float = STEP,
) -> Network:
    """Make the arrays of a network; `release` names the input whose spikes release.

    Raises `ParameterError` for a projection outside its populations, or a time that is no number of steps.
    """
    ordered = {
        name: p
        for kind in (Conductors, Integrators, Inputs)
        for name, p in populations.items()
        if isinstance(p, kind)
    }
    first: dict[str, int] = {}
    count = 0
    conductors = 0
    for name, p in ordered.items():
        first[name] = count
        count += math.prod(p.shape)
        conductors = count if isinstance(p, Conductors) else conductors
    source, target, weight, delay, hold = _synapses(ordered, first, projections, step)
    order = np.argsort(source, kind="stable")
    decay, gain, drive, refractory, released = _integrators(ordered, step)
    wiring = Wiring(
        step=step,
        conductors=conductors,
        release=NOBODY if release is None else first[release],
        begin=np.searchsorted(source[order], np.arange(count + 1)).astype(np.int64),
        target=target[order],
        delay=delay[order],
        hold=hold[order],
        weight=weight[order],
        decay=decay,
        gain=gain,
        drive=drive,
        refractory=refractory,
        released=released,
    )
    longest = int((delay.max(initial=0)) + hold.max(initial=0)) + 2
    slots = 1 << longest.bit_length()
    return Network(first, ordered, wiring, _blocks(ordered, conductors, step), slots)


def new_state(network: Network) -> State:
    """Return the state of a network at rest."""
    w = network.wiring
    integrators, synapses, sources = w.decay.size, w.target.size, w.begin.size - 1
    room = _EVENTS * synapses + 1
    after = np.arange(1, room + 1, dtype=np.int64)
    after[-1] = NOBODY
    counts = np.zeros(5, dtype=np.int64)
    active = np.arange(integrators, dtype=np.int64)
    counts[ACTIVE] = integrators
    return State(
        blocks=network.blocks.copy(),
        v=np.zeros(integrators),
        current=np.zeros(integrators),
        held=np.zeros(integrators),
        wait=np.zeros(integrators, dtype=np.int64),
        active=active,
        place=active.copy(),
        latched=np.zeros(synapses, dtype=np.bool_),
        slot=np.full(network.slots, NOBODY, dtype=np.int64),
        after=after,
        event=np.zeros(room, dtype=np.int64),
        fired=np.zeros(2 * sources, dtype=np.int64),
        counts=counts,
    )


def run(
    network: Network, state: State, duration: float, inputs: I64, probes: Sequence[int] = ()
) -> tuple[Spikes, F64]:
    """Advance the state of a network by `duration` (s), and return its spikes and probes.

    inputs: int64[n, 2], step and source; steps count from the beginning of the state. probes: neurons whose
    voltage is kept.

    Returns the spikes and float64[steps, probes], V, or thresholds. Raises `SolverError` where more spikes
    came than there is room for.
    """
    steps = round(duration / network.wiring.step)
    order = np.lexsort((inputs[:, 1], inputs[:, 0]))
    given = np.ascontiguousarray(inputs[order])
    now = int(state.counts[NOW])
    if len(given) and not (given[0, 0] >= now and given[-1, 0] < now + steps):
        raise ParameterError(f"inputs: a spike in step {given[0, 0]}, must be within the run from step {now}")
    state.counts[SPIKES] = 0
    room = (network.wiring.begin.size - 1) * (1 + math.ceil(duration / _INTERVAL))
    raster = np.empty((room, 2), dtype=np.int64)
    traces = np.zeros((steps, len(probes)))
    advance(network.wiring, state, given, steps, raster, np.array(probes, dtype=np.int64), traces)
    if state.counts[LOST]:
        raise SolverError(f"network: {state.counts[LOST]} spikes without room; run it for a shorter time")
    found = raster[: state.counts[SPIKES]].copy()
    return Spikes(network, found[:, 0], found[:, 1]), traces


def _synapses(
    populations: Mapping[str, Population],
    first: Mapping[str, int],
    projections: Sequence[Projection],
    step: float,
) -> tuple[I64, I64, F64, I64, I64]:
    """Source, target, weight, delay and hold of all synapses, one projection after the other."""
    source, target, weight, delay, hold = [], [], [], [], []
    for p in projections:
        pre, post, w, d = np.broadcast_arrays(*p.pairs, p.weight, p.delay)
        for numbers, name in ((pre, p.source), (post, p.target)):
            size = math.prod(populations[name].shape)
            if numbers.size and not 0 <= numbers.min() <= numbers.max() < size:
                raise ParameterError(
                    f"{p.name}: {numbers.max()}, must be a neuron of {name}, 0 to {size - 1}"
                )
        after = populations[p.target]
        if d.size and d.min() < 0.0:
            raise ParameterError(f"{p.name}.delay: {d.min():g} s, must be >= 0")
        if isinstance(after, Conductors):
            tau = np.where(w > 0.0, after.tau_exc, after.tau_inh)
            w = w * math.e / tau
        elif not p.hold > 0.0:
            raise ParameterError(f"{p.name}.hold: {p.hold:g} s, must be > 0 for integrate-and-fire neurons")
        source.append(pre.ravel() + first[p.source])
        target.append(post.ravel() + first[p.target])
        weight.append(np.asarray(w, dtype=np.float64).ravel())
        delay.append(np.rint(d.ravel() / step).astype(np.int64))
        hold.append(np.full(pre.size, -1 if math.isinf(p.hold) else round(p.hold / step)))
    s, t, d, h = (np.concatenate(x).astype(np.int64) for x in (source, target, delay, hold))
    return s, t, np.concatenate(weight), d, h


def _integrators(populations: Mapping[str, Population], step: float) -> tuple[F64, F64, F64, I64, Bools]:
    """Decay, gain, drive, refractory steps and whether released, of all integrate-and-fire neurons."""
    found = [p for p in populations.values() if isinstance(p, Integrators)]
    count = np.array([math.prod(p.shape) for p in found], dtype=np.int64)
    leak = np.repeat(np.array([p.leak for p in found], dtype=np.float64), count)
    decay = np.exp(-step * leak)
    leaky = leak > 0.0
    gain = np.where(leaky, (1.0 - decay) / np.where(leaky, leak, 1.0), step)
    drive = [np.broadcast_to(p.drive, p.shape).astype(np.float64).ravel() for p in found]
    wait = [FOREVER if math.isinf(p.refractory) else round(p.refractory / step) for p in found]
    return (
        decay,
        gain,
        np.concatenate([np.zeros(0), *drive]),
        np.repeat(np.array(wait, dtype=np.int64), count),
        np.repeat(np.array([p.released for p in found], dtype=np.bool_), count),
    )


def _blocks(populations: Mapping[str, Population], count: int, step: float) -> F64:
    """Hodgkin-Huxley neurons at rest, with their time constants and currents."""
    blocks = new_blocks(count).reshape(-1, ROWS, LANES)
    at = 0
    for p in populations.values():
        if not isinstance(p, Conductors):
            continue
        n = np.arange(at, at + math.prod(p.shape))
        at += n.size
        for row, value in (
            (DECAY_E, math.exp(-step / p.tau_exc)),
            (DECAY_I, math.exp(-step / p.tau_inh)),
            (CURRENT, p.current),
        ):
            blocks[n // LANES, row, n % LANES] = value
    return blocks.reshape(-1)
