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
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

ERROR = 0.02  # the largest in the record is 1.5 %


CASES = [
    ("ideal", 45.0, Die(number=1002), AMI_1500_IDEAL), ("gate", 10.0, Die(number=1005), AMI_1500_IDEAL),
    ("generator", 60.0, Die(number=1006), AMI_1500),
    ("gate", 27.0, Die(number=1001, variation="full"), AMI_1500),  # its capacitors are 2 % larger
]  # fmt: skip


@pytest.fixture(scope="module", params=CASES)
def chip(request: pytest.FixtureRequest) -> LatencyChip:
    kind: BiasKind
    kind, celsius, die, process = request.param
    design = usual_design()
    silicon = Silicon(process, celsius, die)
    return LatencyChip(design, usual_biases(design, kind, process), silicon)


def test_times_are_those_of_the_transistors(chip: LatencyChip) -> None:
    found = [
        tap_delays(chip, 7), neuron_latencies(chip, 20), race_latencies(chip, 4),
        # under the full law later periods may be shorter than the first
        *((ours, theirs) for name, ours, theirs in inhibition_times(chip, 12, 3)
          if name != "tonic" or chip.silicon.process is AMI_1500_IDEAL),
    ]  # fmt: skip
    for ours, theirs in found:
        assert ours == pytest.approx(theirs, rel=ERROR)


def test_detectors_decide_as_the_transistors_do(chip: LatencyChip) -> None:
    window = float(chip.lumped.window[12, 3, 0])
    assert unit_spikes(chip, 12, 3, INSIDE * window) == (True, True)
    assert unit_spikes(chip, 12, 3, OUTSIDE * window) == (False, False)
