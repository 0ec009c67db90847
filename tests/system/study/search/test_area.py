"""Areas of least total for a wanted spread: the closed form, its least areas, and dies of a real block."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine
from circuits.silicon.process import AMI_1500, DiodeVariation
from circuits.silicon.process_file import format_process
from system.cli.command_line import main
from system.options.block import read_die
from system.options.silicon import SiliconChoice
from system.study.search.area import least_areas, matched, scaled_rows
from system.study.search.slope import Slopes
from system.study.statistics.contribution import kind as device_kind
from system.study.table import Condition
from system.study.target import BlockTarget, Subject

MIRROR = str(Path(__file__).parents[4] / "examples" / "circuits" / "mirror.py") + ":drive"
VARIANCE, AREA = np.array([4.0, 1.0, 1e-4]), np.array([2.0, 8.0, 5.0])


def test_areas_meet_the_variance_at_least_total() -> None:
    found = least_areas(VARIANCE, AREA, 2.0, 1e-6)
    assert float((VARIANCE * AREA / found).sum()) == pytest.approx(2.0)
    best = minimize(
        lambda x: float(np.exp(x).sum()),
        np.log(found) + 0.3,
        constraints={"type": "ineq", "fun": lambda x: 2.0 - float((VARIANCE * AREA / np.exp(x)).sum())},
    )
    assert float(found.sum()) == pytest.approx(best.fun, rel=1e-4)


def test_no_device_is_made_smaller_than_it_may() -> None:
    found = least_areas(VARIANCE, AREA, 2.0, 0.5)
    assert found[2] == 2.5
    assert float((VARIANCE * AREA / found).sum()) == pytest.approx(2.0)
    assert least_areas(VARIANCE, AREA, 1e6, 0.5).tolist() == [1.0, 4.0, 2.5]


@pytest.fixture(scope="module")
def slopes() -> Slopes:
    subject = Subject(MIRROR, ("v_out_last_V",))
    return Slopes(
        BlockTarget(subject), read_die(subject.silicon), Condition("random", 27.0, 0), "v_out_last_V", 1
    )


def test_a_circuit_matched_by_its_gradient_spreads_as_told(slopes: Slopes) -> None:
    """40 dies tell a standard deviation to 11 % at one standard error."""
    rows = np.random.default_rng(4).standard_normal((40, len(slopes.labels)))
    rows[:, [label.startswith("process") for label in slopes.labels]] = 0.0
    slope = slopes.at(np.zeros(len(slopes.labels)))
    slope = type(slope)(slope.value, np.where(rows.any(axis=0), slope.by, 0.0), slope.note)
    found = matched(slopes, slope, 0.5 * float(np.linalg.norm(slope.by)), 0.1)
    assert found.spread == pytest.approx(0.5 * found.spread_now)
    before, after = slopes.values(rows), slopes.values(scaled_rows(slopes, found, rows))
    assert before.std(ddof=1) == pytest.approx(found.spread_now, rel=0.3)
    assert after.std(ddof=1) == pytest.approx(0.5 * before.std(ddof=1), rel=0.15)


def test_a_spread_that_no_area_gives_is_refused(slopes: Slopes) -> None:
    slope = slopes.at(np.zeros(len(slopes.labels)))
    with pytest.raises(ParameterError, match="which the process alone makes and no area lessens"):
        matched(slopes, slope, 1e-9, 0.1)


DIODE = """from circuits.api import Circuit, Diode, Port, Testbench, current_into, mos, powered

def drive():
    parts = (
        mos("m_in", "n", "g", "g", "0", 6, 6), mos("m_out", "n", "v_out", "g", "0", 6, 6),
        Diode("d", "vdd", "v_out", saturation_current=1e-15),
    )
    ports = Port("vdd", "supply"), Port("g", "analog"), Port("v_out", "analog", "out")
    drives = (*powered(5.0), current_into("g", 10e-9))
    return Testbench("level", Circuit("level", ports, parts), drives, stop=1e-5)
"""


def test_diodes_are_in_the_gradient_and_no_area_of_a_transistor_lessens_them(tmp_path: Path) -> None:
    (tmp_path / "level.py").write_text(DIODE)
    process = replace(AMI_1500, diodes=DiodeVariation(0.05, 0.1))
    (tmp_path / "mine.toml").write_text(format_process(process))
    silicon = SiliconChoice(process=str(tmp_path / "mine.toml"))
    subject = Subject(f"{tmp_path}/level.py:drive", ("v_out_last_V",), silicon=silicon)
    found = Slopes(BlockTarget(subject), read_die(silicon), Condition("random", 27.0, 0), "v_out_last_V", 1)
    slope = found.at(np.zeros(len(found.labels)))
    assert found.by_gradient
    np.testing.assert_allclose(slope.by, found._by_dies(np.zeros(slope.by.size)).by, rtol=2e-2, atol=1e-6)
    moved = {label.removeprefix("level."): by for label, by in zip(found.labels, slope.by, strict=True)}
    # the output is a diode's drop of U_T ln(I / I_S) below the supply
    own, every = moved["d.saturation_current"], moved["process.diode.shared.saturation_current"]
    assert own == pytest.approx(0.025865 * 0.05 / np.sqrt(2.0), rel=1e-2)
    assert every == pytest.approx(0.025865 * 0.1, rel=1e-2)
    shared = [by for label, by in moved.items() if label.startswith("process.")]
    least = matched(found, slope, 2.0 * float(np.linalg.norm(slope.by)), 0.1)
    assert least.devices == ("level.m_in", "level.m_out")
    assert least.fixed == pytest.approx(own**2 + float(np.square(shared).sum()))
    assert {device_kind(label) for label in found.labels if "diode" in label} == {"process"}
    with pytest.raises(
        ParameterError, match="the process and what is no transistor make and no area lessens"
    ):
        matched(found, slope, 1e-9, 0.1)


def test_gradients_across_the_die_are_no_devices() -> None:
    silicon = SiliconChoice(variation="transistors", process_variation=False)
    target = BlockTarget(Subject("differential-pair", ("offset_V",), silicon=silicon))
    found = Slopes(target, read_die(silicon), Condition("random", 27.0, 0), "offset_V", 1)
    slope = found.at(np.zeros(len(found.labels)))
    assert any(label.startswith("gradient.") for label in found.labels)
    least = matched(found, slope, 0.5 * float(np.linalg.norm(slope.by)), 0.1)
    assert {name.rpartition(".")[2] for name in least.devices} == {"mb", "m1", "m2"}
    assert least.spread == pytest.approx(0.5 * least.spread_now, rel=1e-6)


def test_a_number_that_reads_currents_is_asked_of_dies() -> None:
    """An offset follows the devices beside the run's voltages; Pelgrom's law tells its spread."""
    subject = Subject("differential-pair", ("offset_V",))
    target = BlockTarget(subject)
    found = Slopes(target, read_die(subject.silicon), Condition("random", 27.0, 0), "offset_V", 1)
    slope = found.at(np.zeros(len(found.labels)))
    assert not found.by_gradient
    threshold = [label.endswith(("m1.v_t0", "m2.v_t0")) for label in found.labels]
    pair = target.choice.silicon.process.pair_a_vt / 1e-6  # of gates of 1 um by 1 um
    assert float(np.linalg.norm(slope.by[threshold])) == pytest.approx(pair, rel=1e-3)


def often(machine: Machine) -> float:
    """A threshold that is not defined where it is low."""
    found = float(machine.kernel.transistors.v_t0[0])
    return found if found > 0.47 else math.nan


def test_a_check_tells_how_many_dies_have_the_metric(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["match", "differential-pair", "--metric", f"{__name__}:often", "--check", "40"]
    assert main(asked) == 0
    (first, _) = re.findall(r"by (\d+) of 40 dies", capsys.readouterr().out)
    assert 10 < int(first) < 40
    assert main([*asked, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["checks"][0]["defined"] == int(first)
