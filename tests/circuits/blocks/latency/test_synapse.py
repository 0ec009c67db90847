"""The comparator turns at its reference, and the synapses' steps have their length."""

import numpy as np
import pytest

from circuits.blocks.drive import powered
from circuits.blocks.latency.synapse import (
    comparator_biases,
    compared,
    events,
    step_inhibition,
    step_synapse,
)
from circuits.blocks.ports import SUPPLY, analog_in, bias_in, bias_ports, event_in
from circuits.circuit import Bias, Circuit, Port
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

CURRENT, LENGTH_CURRENT, TIMER = 2.5e-9, 5e-9, 5e-12  # A, A, F: 2 ms at 2 V
START = 1e-4  # s


def clamped(part: Circuit) -> Result:
    """The synapse's output held at 1 V by a source, an event at `START`."""
    biases = tuple(p.name for p in part.ports if p.kind == "bias")
    exc, length = biases[:2]
    source = "syn.me" if exc == "v_exc" else "syn.mk"
    kinds = (
        Bias("i_out", exc, "gate", CURRENT, source),
        Bias("i_length", length, "gate", LENGTH_CURRENT, "syn.mt"),
        *comparator_biases("syn.timer.mc0"),
    )
    ports = (SUPPLY, *event_in("event"), *bias_in(*biases), *analog_in("v_mem"))
    whole = Circuit("held", ports, (), (part.instance("syn"),), biases=kinds)
    sources = powered(5.0, {"event": pulse((START,), 5.0), "v_mem": 1.0})
    return simulate(Testbench("held", whole, sources, 4e-3, watch=()), Silicon(AMI_1500_IDEAL))


@pytest.mark.parametrize("part", [step_synapse(TIMER), step_inhibition(TIMER)])
def test_a_step_lasts_as_long_as_its_timer(part: Circuit) -> None:
    result = clamped(part)
    off = result["syn.off"]
    on = result.time[(off < 2.5) & (result.time > START)]
    # gates and junctions on the timer are 1 % of its capacitor, and the event itself takes 10 us
    assert on[-1] - on[0] == pytest.approx(TIMER * 2.0 / LENGTH_CURRENT, rel=0.025)


def test_times_before_the_ping_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"event 2: -0\.001 s, must be >= 0 s after the ping"):
        events(Port("event", "event", "in", (2,)), (0.0, -1e-3), START, 5.0)
    silent = events(Port("event", "event", "in", (1,)), (), START, 5.0)
    assert silent == {"event[0]": 0.0}


def test_the_comparator_turns_at_its_reference() -> None:
    biases = comparator_biases("c.mc0")
    ports = (SUPPLY, *analog_in("plus"), *bias_ports(biases))
    whole = Circuit("whole", ports, (), (compared("c", "plus", "above"),), biases=biases)
    for level, high in ((1.99, False), (2.01, True)):
        result = simulate(
            Testbench("level", whole, powered(5.0, {"plus": level}), 1e-4), Silicon(AMI_1500_IDEAL)
        )
        assert (np.asarray(result["above"])[-1] > 2.5) is np.bool_(high)
