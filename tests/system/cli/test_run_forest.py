"""`noctule run forest`: one JSON document, a table, and one line for whatever is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from system.cli.command_line import main

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def call(*arguments: str) -> tuple[int, str, str]:
        status = main(("run", "forest", *arguments))
        return status, *capsys.readouterr()

    return call


def test_the_document(run: Run, tmp_path: Path) -> None:
    picture = tmp_path / "path.png"
    flight = ("--obstacles", "900", "--vmax", "2.5m/s", "--ping-rate", "10Hz", "--pings", "200")
    status, out, err = run(*flight, "--seed", "1003", "--plot", str(picture), "--json")
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert (found["obstacles"], found["max_speed_m_per_s"], found["ping_rate_Hz"], found["seed"]) == (
        900, 2.5, 10.0, 1003,
    )  # fmt: skip
    pings = int(found["summary"]["pings"])
    assert len(found["obstacles_m"]) == 900
    assert len(found["path_m"]) == pings + 1
    assert [len(found[k]) for k in ("time_s", "heading_rad", "ping_direction", "arc", "scanning")] == [
        pings
    ] * 5
    assert found["path_m"][0] == found["start_m"]
    assert (found["ping_direction"][0], found["ranges"]) == (2, "exact")
    assert picture.stat().st_size > 10_000


def test_the_table(run: Run) -> None:
    status, out, err = run("--pings", "20")
    assert (status, err) == (0, "")
    assert "forest, 1400 obstacles, 2 m/s, 5 Hz" in out
    assert "avoided" in out
    assert "all 20 pings flown" in out


def test_the_document_with_chips(run: Run, tmp_path: Path) -> None:
    film = tmp_path / "flight.gif"
    options = ("--ranges", "chip", "--selection", "chip", "--die", "1003", "--no-process", "--pings", "6")
    status, out, err = run(*options, "--animate", str(film), "--temperature", "30", "--json")
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert (found["ranges"], found["selection"], found["die"]) == ("chip", "chip", 1003)
    assert (found["temperature_C"], found["process_variation"]) == (30.0, False)
    assert found["summary"]["heard"] + found["summary"]["missed"] > 0
    assert film.read_bytes()[:6] == b"GIF89a"


def test_a_map_of_ones_own(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "wood.csv"
    path.write_text("x_m,y_m\n10,10\n")
    found = json.loads(run("--map", str(path), "--start", "20m,30m", "--pings", "5", "--json")[1])
    assert found["obstacles_m"] == [[10.0, 10.0]]
    assert found["path_m"][-1] == pytest.approx([18.0, 30.0])
    status, _, err = run("--map", str(path), "--start", "10.1m,10m")
    assert status == 2
    assert err.count("\n") == 1
    assert "--start: 10.1,10, an obstacle is 0.1 m away" in err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--obstacles", "9000"), "--obstacles: 9000, must fit 50 x 50 m"),
        (("--vmax", "0"), "--vmax: 0 m/s, must be > 0"),
        (("--ping-rate", "-5Hz"), "--ping-rate: -5 Hz, must be > 0"),
        (("--map", "/nonexistent.csv"), "/nonexistent.csv: No such file"),
        (("--plot", "way.bmp"), "--plot: way.bmp, must end with"),
        (("--ranges", "radar"), "--ranges: radar, must be exact, sonar or chip"),
        (("--die", "3"), "--die: no chip is in the loop"),
        (("--temperature", "60"), "--temperature: 60 degC, must be 27"),
        (("--weights", "none"), "--weights: none, must be fixed or speed"),
        (("--animate", "way.mov"), "--animate: way.mov, must end with .gif"),
        (("--animate", "/nonexistent/way.gif"), "there is no folder /nonexistent"),
        (("--occlusion",), "--occlusion: not with --ranges exact"),
        (("--ranges", "chip", "--area", "0"), "ranging.area: 0 times"),
        (
            ("--model", "latency-chip"),
            "--model: is no option now",
        ),
        (("--taps", "15"), "No such option: --taps"),
    ],
)
def test_what_is_wrong_is_one_line(run: Run, arguments: tuple[str, ...], says: str) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert err.startswith("noctule: ")
    assert says in err
    assert err.count("\n") == 1
