"""`noctule run pushbot` and `noctule montecarlo pushbot` from the command line."""

import json
from pathlib import Path

import numpy as np
import pytest

from system.cli.command_line import main
from system.pushbot.body import Pushbot
from system.worlds.camera.file import read_events


def test_json_has_the_run(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "a.png"
    options = ("--scene", "pair", "--duration", "300ms", "--window", "50ms", "--drop", "0.5", "--json")
    assert main(("run", "pushbot", *options, "--plot", str(picture))) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["scene"] == "pair"
    assert found["window_s"] == pytest.approx(0.05)
    assert found["dropped"] == 0.5
    assert len(found["path"]) == 61  # 5 ms steps and the start
    assert len(found["commands"]) == 6
    assert set(found["rates_Hz"]) == {"OR", "OL", "DR", "DL", "sp", "exc", "target"}
    assert found["obstacle_line_m"] == pytest.approx(1.0)
    assert found["summary"]["collided"] == 0.0
    assert found["calibrated"] is True
    assert found["summary"]["held"] == 0.0
    assert isinstance(found["cautions"], list)
    assert picture.stat().st_size > 10_000


def test_events_that_arrived_can_be_kept(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    kept = tmp_path / "events.npz"
    assert main(("run", "pushbot", "--duration", "400ms", "--events", str(kept), "--json")) == 0
    found = json.loads(capsys.readouterr().out)
    events = read_events(str(kept))
    assert len(events) == found["summary"]["events"] > 0
    assert np.all(np.diff(events.time) >= 0.0)
    # not before the link's latency, nor after the run
    assert Pushbot().latency <= events.time.min() <= events.time.max() <= found["summary"]["time_s"]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (("--events", "events.dat"), "events.dat: must end with .aedat4, .npz, .txt"),
        (("--way", "0"), "--way: 0 m, must be > 0"),
        (("--speed-factor", "0"), "speed_factor: 0, must be above 0"),
        (("--scene", "nowhere"), "scene nowhere: unknown"),
        (("--exc", "60"), "population.target: 128 neurons, must be <= 116"),
        (("--window", "70ms"), "--window: 0.07 s"),
        (("--readout", "mean"), "--readout: mean, must be fixed, sliding or spikes"),
        (("--readout", "spikes", "--window", "50ms"), "--window: 0.05 s, must not be given"),
        (("--frame",), "--frame: without a target"),
        (("--light", "blinding"), "light: blinding"),
        (("--light", "500"), "or an illuminance above 0; write as in 500lux"),
        (("--plot", "way.bmp"), "--plot: way.bmp"),
    ],
)
def test_bad_input_is_one_line(
    options: tuple[str, ...], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(("run", "pushbot", *options)) != 0
    err = capsys.readouterr().err
    assert text in err
    assert err.count("\n") == 1
