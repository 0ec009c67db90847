"""The comparator turns at its reference, and the synapses' steps have their length."""

import numpy as np
import pytest

from circuits.blocks.latency.synapse import comparator, event_sources, step_inhibition, step_synapse
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.event import pulse
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
        Bias("i_cmp", "v_cmp", "gate", 50e-9, "syn.timer.mc0"),
        Bias("v_ref", "v_ref", "voltage", 2.0),
    )
    ports = (Port("vdd", "supply"), Port("event", "event"), *(Port(n, "bias") for n in biases))
    ports = (*ports, Port("v_mem", "analog"))
    inner = Instance("syn", part, part.wired())
    whole = Circuit("held", ports, (), (inner,), biases=kinds)
    sources = (
        Source("vdd", "vdd", Constant(5.0)),
        Source("event", "event", pulse((START,), 5.0)),
        Source("v_mem", "v_mem", Constant(1.0)),
    )
    return simulate(Testbench("held", whole, sources, 4e-3, watch=()), Silicon())


@pytest.mark.parametrize("part", [step_synapse(TIMER), step_inhibition(TIMER)])
def test_a_step_lasts_as_long_as_its_timer(part: Circuit) -> None:
    result = clamped(part)
    off = result["syn.off"]
    on = result.time[(off < 2.5) & (result.time > START)]
    # gates and junctions on the timer are 1 % of its capacitor, and the event itself takes 10 us
    assert on[-1] - on[0] == pytest.approx(TIMER * 2.0 / LENGTH_CURRENT, rel=0.025)


def test_times_before_the_ping_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"event 2: -0\.001 s, must be >= 0 s after the ping"):
        event_sources("event", (0.0, -1e-3), 2, START, 5.0)
    silent = event_sources("event", (), 1, START, 5.0)[0]
    assert isinstance(silent.waveform, Constant)


def test_the_comparator_turns_at_its_reference() -> None:
    part = comparator()
    biases = (Bias("i_cmp", "v_cmp", "gate", 50e-9, "c.mc0"), Bias("v_ref", "v_ref", "voltage", 2.0))
    ports = (Port("vdd", "supply"), Port("plus", "analog"), *(Port(b.port, "bias") for b in biases))
    inner = Instance("c", part, part.wired())
    whole = Circuit("whole", ports, (), (inner,), biases=biases)
    for level, high in ((1.99, False), (2.01, True)):
        sources = (Source("vdd", "vdd", Constant(5.0)), Source("plus", "plus", Constant(level)))
        result = simulate(Testbench("level", whole, sources, 1e-4, watch=()), Silicon())
        assert (np.asarray(result["above"])[-1] > 2.5) is np.bool_(high)
