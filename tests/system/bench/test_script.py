"""Scripts say what is set and read, and a slip in one is told in a line of file, key, value and rule."""

from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.bench.run import run_script
from system.bench.script import Record, Sweep, read_script

PAIR = """
circuit = "NDP"
read = ["C2F0", "C2F1"]
[biases]
NDP_VB_N = "N 30nA 20"
[voltages]
AIN6 = "0.9V"
[sweep]
points = 5
way = "both"
[sweep.over]
AIN5 = ["0.8V", "1V"]
"""
STEP = """
circuit = "FOI"
read = ["ADC10"]
[biases]
FOI_VB_N = "N 460pA 37"
[voltages]
AIN9 = "0.9V"
[record]
samples = 20
interval = "50us"
steps = {AIN9 = "1V"}
"""


def written(text: str, folder: Path) -> str:
    path = folder / "script.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_sweep_is_read_and_run(tmp_path: Path) -> None:
    script = read_script(written(PAIR, tmp_path), 1.8)
    assert isinstance(script.act, Sweep)
    table = run_script(script, Silicon(ROLLS_180))
    assert table.set_columns == ("AIN5_V",)
    assert list(table.columns) == ["AIN5_V", "C2F0_counts", "C2F1_counts"]
    one, other = table.columns["C2F0_counts"], table.columns["C2F1_counts"]
    assert (np.diff(one[:5]) > 0.0).all()
    assert (np.diff(other[:5]) < 0.0).all()
    assert np.abs(one[5:] - one[4::-1]).max() < 20  # back again, but for what differs between readings


def test_a_bias_is_swept_by_its_code(tmp_path: Path) -> None:
    text = PAIR.replace('AIN5 = ["0.8V", "1V"]', 'NDP_VB_N = ["0", "40"]').replace('"both"', '"up"')
    table = run_script(read_script(written(text, tmp_path), 1.8), Silicon(ROLLS_180))
    assert table.columns["NDP_VB_N_code"].tolist() == [0.0, 10.0, 20.0, 30.0, 40.0]
    assert (np.diff(table.columns["C2F1_counts"]) > 0.0).all()


def test_a_record_is_read_and_run(tmp_path: Path) -> None:
    script = read_script(written(STEP, tmp_path), 1.8)
    assert isinstance(script.act, Record)
    table = run_script(script, Silicon(ROLLS_180))
    assert table.columns["time_s"][1] == pytest.approx(50e-6)
    assert table.columns["ADC10_V"][-1] > table.columns["ADC10_V"][0] + 0.07


SLIPS = {
    ('"NDP"', '"NPD"'): r"circuit NPD: unknown; did you mean NDP",
    ('"C2F0", ', '"C2F5", '): r"read C2F5: unknown",
    (
        "N 30nA 20",
        "N 30nA 256",
    ): r"biases.NDP_VB_N: bias fine code: 256, must be a whole number from 0 to 255",
    ("N 30nA 20", "N 31nA 20"): r"biases.NDP_VB_N: bias master: '31nA', must be one of 60pA",
    ("N 30nA 20", "30nA 20"): r"biases.NDP_VB_N: '30nA 20', must be type, coarse current and code",
    ('"1V"', '"2V"'): r"sweep.over.AIN5: 2 V, must be within 0 V and the supply of 1.8 V",
    ('"1V"', '"1A"'): r"sweep.over.AIN5",
    ("points = 5", "points = 1"): r"sweep.points: 1, must be 2 to 100000",
    ("points = 5", "point = 5"): r"sweep: Object contains unknown field point",
    ("points = 5", 'points = "x"'): r"sweep.points: Expected int, got str",
    ("AIN5 = [", "AIN7 = ["): r"sweep.over AIN7: unknown",
    ("[sweep]", "[swep]"): r"unknown field|sweep",
    ('AIN6 = "0.9V"', 'AIN9 = "0.9V"'): r"voltages AIN9: unknown",
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_told_in_a_line(slip: tuple[str, str], tmp_path: Path) -> None:
    assert slip[0] in PAIR
    path = written(PAIR.replace(*slip), tmp_path)
    with pytest.raises(DataError, match=SLIPS[slip]) as found:
        read_script(path, 1.8)
    assert str(found.value).startswith(path)
    assert "\n" not in str(found.value)


def test_other_slips(tmp_path: Path) -> None:
    both = written(PAIR + '[record]\nsamples = 3\ninterval = "1s"\n', tmp_path)
    with pytest.raises(DataError, match=r"sweep, record: must be one of them"):
        read_script(both, 1.8)
    events = written(STEP + 'events = ["1ms"]\n', tmp_path)
    with pytest.raises(DataError, match=r"record.events: no events come in at this circuit"):
        read_script(events, 1.8)
    code = PAIR.replace('AIN5 = ["0.8V", "1V"]', 'NDP_VB_N = ["0", "300"]')
    with pytest.raises(DataError, match=r"sweep.over.NDP_VB_N: bias fine code: 300"):
        read_script(written(code, tmp_path), 1.8)
    with pytest.raises(DataError, match=r"must be a readable file"):
        read_script(str(tmp_path / "none.toml"), 1.8)
