"""A part's testbench has the chip's voltages and the events that are given, and nothing else."""

import pytest

from chips.latency.errors import usual_design
from chips.latency.model import usual_biases
from chips.latency.place import UNIT_WIRES, bench_at, line_volts, standing
from circuits.blocks.latency import unit as latency_unit
from circuits.devices.source import Constant, Pulse
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


def test_a_unit_takes_the_chips_voltages() -> None:
    part, silicon = latency_unit.build(), Silicon(AMI_1500_IDEAL)
    volts = line_volts(usual_biases(usual_design()), silicon, UNIT_WIRES, {})
    assert set(volts) == {p.name for p in part.ports if p.kind == "bias"}
    assert volts["v_ref"] == 2.0
    # V_T0 + U_T / kappa ln(57 pA / I_S) below the rail, I_S of 6 by 24 um being 11.1 nA: 0.668 V
    assert volts["v_hold"] == pytest.approx(5.0 - 0.668, abs=3e-3)
    bench = bench_at("unit", part, volts, {"tap": [2e-3, 1e-3]}, 5e-3, 5.0)
    waves = {s.name: s.waveform for s in bench.sources}
    assert isinstance(waves["tap"], Pulse)
    assert waves["reset"] == Constant(0.0)


def test_a_place_begins_with_the_chip() -> None:
    assert standing(Silicon(AMI_1500_IDEAL), ("memory", (3,)), ("unit", (4,))).place == (
        ("latency_chip", ()), ("memory", (3,)), ("unit", (4,)),
    )  # fmt: skip
