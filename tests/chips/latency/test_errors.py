"""The model against transistors at their places on a die that the record was not built from."""

import pytest

from chips.latency.chip import LatencyChip
from chips.latency.errors import (
    INSIDE,
    OUTSIDE,
    inhibition_times,
    neuron_latencies,
    race_latencies,
    tap_delays,
    unit_spikes,
    usual_design,
)
from chips.latency.model import usual_biases
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon

ERROR = 0.02  # the largest in the record is 1.5 %


@pytest.fixture(scope="module", params=[("ideal", 1002, 45.0), ("gate", 1005, 10.0)])
def chip(request: pytest.FixtureRequest) -> LatencyChip:
    kind: BiasKind
    kind, number, celsius = request.param
    design = usual_design()
    silicon = Silicon(temperature_c=celsius, die=Die(number=number))
    return LatencyChip(design, usual_biases(design, kind), silicon)


def test_times_are_those_of_the_transistors(chip: LatencyChip) -> None:
    found = [
        tap_delays(chip, 7), neuron_latencies(chip, 20), race_latencies(chip, 4),
        *((ours, theirs) for _, ours, theirs in inhibition_times(chip, 12, 3)),
    ]  # fmt: skip
    for ours, theirs in found:
        assert ours == pytest.approx(theirs, rel=ERROR)


def test_detectors_decide_as_the_transistors_do(chip: LatencyChip) -> None:
    window = float(chip.lumped.window[12, 3, 0])
    assert unit_spikes(chip, 12, 3, INSIDE * window) == (True, True)
    assert unit_spikes(chip, 12, 3, OUTSIDE * window) == (False, False)
