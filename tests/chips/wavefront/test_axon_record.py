"""The shipped records of axon and cell belong to today's circuits, and state their errors."""

from dataclasses import replace

import pytest

from chips.record import kept_record
from chips.wavefront.axon_record import BOX, AxonGrid, axon_key, axon_record, grid_of
from chips.wavefront.model import cell_record
from circuits.blocks.wavefront import axon_delay
from circuits.errors import DataError
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process

RECORD = axon_record()
BOTH = pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500], ids=lambda p: p.effects)


@BOTH
def test_the_axon_s_record_is_not_stale(process: Process) -> None:
    record = axon_record(process)
    assert record.key == axon_key(axon_delay.build(), process, grid_of(record))
    assert grid_of(record) == AxonGrid()
    assert record.box == BOX


@BOTH
def test_the_cell_s_record_is_not_stale(process: Process) -> None:
    data = cell_record(process)
    assert {"input_delay_s", "start_delay_s", "window_s", "input_delay_gradient"} <= set(data.tables)


def test_the_key_follows_circuit_process_and_grid_but_not_biases_and_matching() -> None:
    circuit = axon_delay.build()
    key = axon_key(circuit, AMI_1500_IDEAL)
    assert axon_key(replace(circuit, biases=()), AMI_1500_IDEAL) == key
    assert axon_key(circuit, replace(AMI_1500_IDEAL, pair_a_vt=1e-9)) == key
    assert axon_key(axon_delay.build(axon_delay.Params(sink_width=24e-6)), AMI_1500_IDEAL) != key
    assert axon_key(circuit, replace(AMI_1500_IDEAL, v_dd=4.9)) != key
    assert axon_key(circuit, AMI_1500_IDEAL, AxonGrid(temperature=(0.0, 27.0))) != key


@BOTH
def test_errors_on_other_dies_are_stated_and_small(process: Process) -> None:
    # a sink's own spread is 4.4 %: the model is to be far better than what it describes
    record = axon_record(process)
    assert record.errors["first_die"] >= 500
    assert record.errors["delay_rms_relative"] < 5e-4
    assert record.errors["delay_max_relative"] < 2.5e-3
    data = cell_record(process)
    assert data.errors["input_delay_max_s"] < 0.2e-9


def test_the_sensitivities_are_those_of_a_comparator() -> None:
    gain = dict(zip(RECORD.names("parameter"), RECORD["gain"][2, 7], strict=True))
    # the offset of the pair over the swing of the ramp, V_dd - v_ref = 3 V; the mirror's is smaller
    assert gain["mc2.v_t0"] == pytest.approx(1.0 / 3.0, rel=0.02)
    assert gain["mc1.v_t0"] == pytest.approx(-gain["mc2.v_t0"], rel=0.01)
    assert 0.0 < gain["mc3.v_t0"] < gain["mc2.v_t0"]
    assert gain["mc4.v_t0"] == pytest.approx(-gain["mc3.v_t0"], rel=0.01)
    others = [abs(g) for n, g in gain.items() if n[:3] not in {"mc0", "mc1", "mc2", "mc3", "mc4"}]
    assert max(others) < 0.02


def test_another_record_is_refused() -> None:
    with pytest.raises(DataError, match="current: no axis of numbers"):
        grid_of(kept_record("centroid_board"))
