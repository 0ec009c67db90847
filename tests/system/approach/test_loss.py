"""Which neuron lost a target, and which of its transistors."""

from dataclasses import replace

import numpy as np
import pytest

from chips.ranging.circuit import BEST_DELAYS
from circuits.silicon.die import Die
from system.approach import healing
from system.approach.healing import explained
from system.approach.loss import Reason, losses, reasons
from system.approach.neuron import TOLERANCE, waveform
from system.approach.trace import Trace
from system.registry import load_system


@pytest.fixture(scope="module")
def trace() -> Trace:
    """A die whose neuron 2, with the codes of the design, does not answer at 2.9 s."""
    approach = load_system("approach")
    scenario = approach.on_silicon(
        level="behavioural", codes="default", die=Die(number=1002), duration=3.2, silicon_noise="off"
    )
    found: Trace = approach.run(scenario)
    return found


def test_a_target_that_is_held_is_never_lost(trace: Trace) -> None:
    assert losses(trace)
    assert losses(replace(trace, estimate_m=trace.range_m)) == []


def test_reasons_are_told_from_the_run(trace: Trace) -> None:
    ((begin, end), *_) = losses(trace)
    away, wrong, silent = reasons(trace, begin, end)
    counts = np.bincount([n for t, n in trace.spikes if begin <= t < end], minlength=13)
    assert away.neuron == counts.argmax()
    assert counts.max() > 10 * ((trace.pulses >= begin) & (trace.pulses < end)).sum()
    assert "as 3 more" in away.why
    assert sorted(counts)[-4] > 3 * sorted(counts)[-5]  # so they are four
    # the longest delay, whose echo would come from farther than anything stands
    assert (wrong.neuron, wrong.why[:7]) == (12, "answers")
    assert (silent.neuron, silent.why) == (2, "does not answer")
    # a chip that says one spike a call, at the target's delay, does nothing wrong
    held = tuple((echo + 1e-3, n) for call in trace.pulses for echo, n in _answers(trace, call))
    assert list(reasons(replace(trace, spikes=held), begin, end)) == []


def _answers(trace: Trace, call: float) -> list[tuple[float, int]]:
    """Each echo of a call with the neuron of its delay."""
    since = trace.echoes - call
    delays = np.array(BEST_DELAYS)
    near = since[(since > 2e-3) & (since < 40e-3)]
    return [(call + float(d), int(np.argmin(np.abs(delays - d)))) for d in near]


def test_a_runaway_is_healed_by_the_transistor_that_makes_it(
    trace: Trace, monkeypatch: pytest.MonkeyPatch
) -> None:
    first: list[Reason] = []

    def only(trace: Trace, begin: float, end: float) -> list[Reason]:
        first.append(next(iter(reasons(trace, begin, end))))
        return first[-1:]

    monkeypatch.setattr(healing, "reasons", only)
    monkeypatch.setattr(healing, "MOST", 1)
    ((moment, neuron),) = explained(trace)
    assert neuron is not None
    assert moment.why.startswith("runs away with 2")
    assert neuron.name == first[0].name
    assert neuron.devices[0].mended.startswith("0 spikes after the call, not ")
    assert neuron.devices[1].mended.endswith("as before")


def test_healing_the_transistor_that_lost_it_brings_the_spike_back(
    trace: Trace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(healing, "reasons", lambda *stretch: [list(reasons(*stretch))[-1]])
    ((moment, neuron), *_) = explained(trace)
    assert neuron is not None
    k = int(neuron.name[7:-1])
    own = [t for t, n in trace.spikes if n == k and moment.time < t < moment.end]
    assert own == []  # it was silent
    assert np.min(np.abs(trace.echoes - moment.time)) == 0.0  # at an echo that the chip heard
    first, *others = neuron.devices
    assert first.mended.startswith("spikes ")
    assert [d.mended.startswith("silent") for d in others][-20:] == [True] * 20
    assert first.waveform is not None
    as_it_is, healed = first.waveform.lines
    late = [line.value[line.time > moment.time].max() for line in (as_it_is, healed)]
    assert late[1] > late[0] + 0.1  # V, up to the threshold


def test_a_thinned_waveform_is_as_near_as_it_says() -> None:
    time = np.linspace(0.0, 1.0, 2001)
    volts = np.sin(7.0 * time)
    line = waveform("v", time, volts)
    assert line.time.size < 200
    assert np.abs(np.interp(time, line.time, line.value) - volts).max() <= TOLERANCE
