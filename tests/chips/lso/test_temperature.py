"""A sonar head that is at another temperature in its second ping, against the transistors of its neuron."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.lso.errors import SPREAD, inputs, neuron_bench
from chips.lso.measure import AT, circuits
from chips.lso.model import head_on, side_spikes
from chips.lso.place import NAME
from circuits.blocks.latency.tonic import START
from circuits.circuit import BiasKind
from circuits.devices.source import Polyline
from circuits.event import EDGE, WIDTH
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.temperature import moved
from circuits.solver.transient import Runner

NUMBER, SIDE = 1006, 0
SILICON = Silicon(AMI_1500, die=Die(number=NUMBER))
V_DD = AMI_1500.v_dd


def machine_at(kind: BiasKind, temperature_c: float, stop: float) -> Machine:
    """The neuron with the chip's lines at a temperature, and no events yet."""
    silicon = replace(SILICON, temperature_c=temperature_c)
    nothing = np.full(inputs(NUMBER).shape, np.inf)
    bench = neuron_bench(replace(circuits()[0], biases=()), silicon, kind, tuple(nothing), stop)
    return to_kernel(bench, replace(silicon, place=((NAME, ()), ("lso", (SIDE,)))))


def pulses(start: float, times: list[float]) -> Polyline:
    at, volts = [start], [0.0]
    for t in times:
        at += [t, t + EDGE, t + EDGE + WIDTH, t + 2.0 * EDGE + WIDTH]
        volts += [0.0, V_DD, V_DD, 0.0]
    return np.array(at), np.array(volts)


def events(ping: float, level: np.ndarray, start: float) -> dict[str, Polyline]:
    """What the neuron gets in a ping at `ping` s, from `start` s on: a reset, and the events of both ears."""
    given = {"reset": pulses(start, [ping + START])} if start > 0.0 else {}  # the bench begins in one
    for name, side in (("excite", SIDE), ("inhibit", 1 - SIDE)):
        for k, t in enumerate(level[side]):
            if np.isfinite(t):
                given[f"{name}[{k}]"] = pulses(start, [ping + START + float(t)])
    return given


@pytest.mark.parametrize(("kind", "to"), [("gate", 17.0), ("generator", 47.0)])
def test_a_ping_after_a_step_of_20_degrees_is_the_circuit_s(kind: BiasKind, to: float) -> None:
    level, begin = inputs(NUMBER), to - 20.0 if to > 27.0 else to + 20.0
    old, new = (head_on(replace(SILICON, temperature_c=t), kind) for t in (begin, to))
    longest = [1.3 * float(max(h.excite_step.max(), h.inhibit_step.max())) for h in (old, new)]
    stops = [START + AT + SPREAD + t for t in longest]
    first = machine_at(kind, begin, sum(stops))
    runner = Runner(first, ())
    state = runner.begin(operating_point(first))
    state, one = runner.advance(state, stops[0], events(0.0, level, 0.0), stop_at_event=False)
    runner, state = moved(runner, state, machine_at(kind, to, sum(stops)))
    ping = stops[0] + 1e-6
    _, two = runner.advance(state, ping + stops[1], events(ping, level, stops[0]), stop_at_event=False)
    counts = []
    for head, segment, at in ((old, one, 0.0), (new, two, ping)):
        theirs = np.array([t for _, t in segment.spikes]) - at - START
        ours = side_spikes(head, SIDE, level)
        assert ours.size == theirs.size > 2
        assert ours == pytest.approx(theirs, abs=0.03 * np.diff(theirs).mean())
        counts.append(theirs)
    assert counts[1][0] != pytest.approx(counts[0][0], rel=0.03)
