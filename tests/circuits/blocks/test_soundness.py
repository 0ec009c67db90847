"""Every block and every chip is wired soundly, and would not be with a node that nothing holds."""

from __future__ import annotations

from dataclasses import replace

import pytest

from circuits.devices import Capacitor
from circuits.registry import BLOCKS, load_block
from tests.chips.whole import WHOLE_CHIPS
from tests.circuits.soundness import fault

ALL = {name: load_block(name) for name in BLOCKS} | WHOLE_CHIPS
SMALL = {"wavefront-chip": {"rows": 2, "columns": 2}, "latency-chip": {"paths": 1, "taps": 1, "synapses": 1}}


LEVELS = {"v_code"}  # of a memory outside of the circuit, which no bias sets


@pytest.mark.parametrize("name", ALL)
def test_every_bias_port_is_set_by_a_bias(name: str) -> None:
    block = ALL[name]
    circuit = block.build(block.params(**SMALL.get(name, {})))
    ports = {port.name for port in circuit.ports if port.kind == "bias"}
    assert ports - {bias.port for bias in circuit.biases} <= LEVELS


@pytest.mark.parametrize("name", ALL)
def test_the_circuit_is_sound(name: str) -> None:
    block = ALL[name]
    circuit = block.build(block.params(**SMALL.get(name, {})))
    assert fault(circuit) == ""
    loose = Capacitor("added", "loose", "0", 1e-12)
    assert fault(replace(circuit, devices=(*circuit.devices, loose))).startswith("loose: no path")
