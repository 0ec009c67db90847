"""What the characteriser of the wavefront chip measures, on a small grid."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from chips.measured.perturbation import perturbed
from chips.wavefront import measure as w
from chips.wavefront.axon_record import AxonGrid, axon_record
from chips.wavefront.measure import axon_errors, measure_axon
from chips.wavefront.model import cell_record
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront.axon_linearity import delay_at, delay_machine
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from system.cli.command_line import main

MACHINE = delay_machine(axon_delay.build(), Silicon(AMI_1500_IDEAL))


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500], ids=lambda p: p.effects)
def test_a_small_grid_agrees_with_the_record_of(process: Process) -> None:
    shipped = axon_record(process)
    i, j = 7, 5
    grid = AxonGrid((27.0,), (shipped.numbers("current")[i],), (shipped.numbers("comparator_current")[j],))
    found = measure_axon(process=process, grid=grid)
    # the same simulations: rounding of the solver's steps at most
    assert found["log_charge"][0, 0, 0] == pytest.approx(shipped["log_charge"][2, i, j], abs=1e-9)
    assert found["gain"][0, 0] == pytest.approx(shipped["gain"][2, i], abs=1e-6)
    assert found["offset"][0, 0] == pytest.approx(shipped["offset"][2, i], abs=1e-5)


def test_the_charge_is_the_current_times_the_delay() -> None:
    shipped = axon_record()
    nominal = delay_at(MACHINE, 16) * 3.0046e-9
    at = np.exp(shipped["log_charge"][2, :, :, 15])
    assert at.min() < nominal < at.max()


def test_a_device_moves_alone_and_a_polarity_without_what_sets_the_currents() -> None:
    t = MACHINE.kernel.transistors
    alone = perturbed(MACHINE, "mc2", 0.01).kernel.transistors
    assert np.count_nonzero(alone.v_t0 != t.v_t0) == 1
    polarity = perturbed(MACHINE, "n", log_beta=0.1, held=w.HELD).kernel.transistors
    moved = polarity.specific_current != t.specific_current
    assert np.count_nonzero(moved) == np.count_nonzero(t.sign > 0.0) - len(w.HELD)
    # an offset of 10 mV in the pair over the 3 V of the ramp, on 31 units and the parasitics' two
    apart = delay_at(perturbed(MACHINE, "mc2", 0.01), 31) / delay_at(MACHINE, 31) - 1.0
    assert apart == pytest.approx(0.01 / 3.0 * 33.0 / 31.0, rel=0.02)


def test_errors_are_those_of_the_dies_that_are_asked_for() -> None:
    errors = axon_errors(axon_record(), dies=(500, 501))
    assert (errors["dies"], errors["first_die"]) == (2.0, 500.0)
    assert 0.0 < errors["delay_rms_relative"] <= errors["delay_max_relative"] < 2.5e-3


def test_the_cell_s_record_is_what_the_cell_does() -> None:
    data = cell_record(AMI_1500_IDEAL)
    found = w._cell_at(Silicon(AMI_1500_IDEAL))
    for name, value in found.items():
        at = data.numbers("temperature").index(27.0), 0, data.numbers("shift").index(0.0)
        assert value == pytest.approx(float(data[name][at]), rel=1e-6)


def test_the_command_writes_the_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(w, "measure_axon", axon_record)
    monkeypatch.setattr(w, "HELD_OUT", (500,))
    monkeypatch.setattr(w, "axon_errors", partial(axon_errors, dies=(500,)))
    target = tmp_path / "axon.nc"
    assert main(["characterise", "axon-delay", "-o", str(target), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["errors"]["dies"] == 1.0
    assert target.is_file()
