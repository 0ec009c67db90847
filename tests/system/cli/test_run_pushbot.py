"""`noctule run pushbot` and `noctule montecarlo pushbot` from the command line."""

from pathlib import Path

import numpy as np
import pytest

from system.pushbot.body import Pushbot
from system.worlds.camera.file import read_events
from tests.system.conftest import RunJson


def test_json_has_the_run(run_json: RunJson, tmp_path: Path) -> None:
    picture = tmp_path / "a.png"
    options = ("--scene", "pair", "--duration", "300ms", "--window", "50ms", "--drop", "0.5")
    found = run_json("run", "pushbot", *options, "--plot", str(picture))
    assert found["scene"] == "pair"
    assert found["window_s"] == pytest.approx(0.05)
    assert found["dropped"] == 0.5
    assert len(found["path"]) == 61  # 5 ms steps and the start
    assert len(found["commands"]) == 6
    assert set(found["rates_Hz"]) == {"OR", "OL", "DR", "DL", "sp", "exc", "target"}
    assert found["obstacle_line_m"] == pytest.approx(1.0)
    assert found["summary"]["collided"] == 0.0
    assert (found["summary"]["ran_on"]["codes"], found["calibrated_at_C"]) == ("calibrated", 27.0)
    assert found["summary"]["held"] == 0.0
    assert isinstance(found["cautions"], list)
    assert picture.stat().st_size > 10_000


def test_events_that_arrived_can_be_kept(run_json: RunJson, tmp_path: Path) -> None:
    kept = tmp_path / "events.npz"
    found = run_json("run", "pushbot", "--duration", "400ms", "--events", str(kept))
    events = read_events(str(kept))
    assert len(events) == found["summary"]["events"] > 0
    assert np.all(np.diff(events.time) >= 0.0)
    # not before the link's latency, nor after the run
    assert Pushbot().latency <= events.time.min() <= events.time.max() <= found["summary"]["time_s"]
