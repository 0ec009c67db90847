"""Missions of a robot whose runs take no time: yields, causes, changes, parts and how they go on."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from circuits.errors import ParameterError
from system.study.campaign import Numbered
from system.study.mission.blamed import NOT_SHOWN, NOT_THE_DIE, Blamed, blame_failing, block_shares
from system.study.mission.mission import Asked, mission_of
from tests.killed import wait_until
from tests.system.conftest import Run, RunJson
from tests.system.study.mission.robot import ROBOT

TOY = str(Path(__file__).parents[1] / "blame" / "robot.py") + ":SYSTEM"
COUNTS = ("--dies", "24", "--chunk", "4", "--threads", "1")
HERE = Path(__file__).resolve().parents[4]


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tries.py").write_text(ROBOT)
    return "tries.py:SYSTEM"


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_mission_tells_yield_causes_and_dies_that_fail(robot: str, run_json: RunJson) -> None:
    found = run_json("mission", robot, "--dies", "200", "--threads", "1", "-o", "out")
    (way,) = found["ways"]
    assert (found["runs"], way["dies"], way["name"]) == (800, 200, "generator-27C")
    # of a normal with the variance 1.5 above -1: 0.793; within three standard errors
    sigma = (way["interval"]["high"] - way["interval"]["low"]) / 3.92
    assert 0.001 < sigma < 0.04
    assert way["yield"] == pytest.approx(0.793, abs=3.0 * sigma)
    assert 200 < way["effective_runs"] < 800
    assert [cause["name"] for cause in way["causes"]] == ["die", "world", "noise"]
    assert way["causes"][0]["share"] > way["causes"][1]["share"]  # four times the world's variance
    assert way["causes"][0]["interval"]["low"] > 0.1
    fails = [die["fails"] for die in way["failing"]]
    assert fails == sorted(fails, reverse=True)
    assert sum(fails) == round(800 * (1.0 - way["yield"]))


def test_a_failing_run_is_made_again_by_its_line(robot: str, run: Run, run_json: RunJson) -> None:
    found = run_json("mission", robot, *COUNTS, "-o", "out")
    first = found["ways"][0]["failing"][0]
    words = first["again"].split()
    assert words[:3] == ["noctule", "replay", "out/generator-27C"]
    again = json.loads(run(*words[1:], "--json")[1])
    assert again["identical"] is True
    assert again["again"]["succeeded"] == 0.0
    page = Path("out/report.html").read_text()
    assert f"<code>{first['again'].replace('out/', '')}</code>" in page  # it has no film, and no page
    assert "Finished: 96 of 96 runs." in page
    assert "refresh" not in page


def test_temperatures_and_kinds_of_bias_are_ways_of_the_same_dies(robot: str, run_json: RunJson) -> None:
    found = run_json(
        "mission", robot, *COUNTS, "--temperature", "27", "--temperature", "67", "--bias-kind", "gate"
    )
    cool, warm = found["ways"]
    assert (cool["bias_kind"], warm["temperature_C"], warm["name"]) == ("gate", 67.0, "gate-67C")
    assert warm["yield"] < cool["yield"]
    assert {die["die"] for die in cool["failing"]} <= {die["die"] for die in warm["failing"]}


def test_a_change_is_judged_on_the_same_dies(robot: str, run_json: RunJson) -> None:
    found = run_json(
        "mission", robot, "--dies", "80", "--threads", "1", "--change", "area=16", "--change", "area=0.1"
    )
    more, less = found["changes"]
    assert (more["change"], more["verdict"], less["verdict"]) == ("area=16", "raises it", "lowers it")
    assert more["interval"]["low"] <= more["gain"] <= more["interval"]["high"]
    usual = run_json("mission", robot, *COUNTS, "--change", "usual")
    assert {row["change"] for row in usual["changes"]} == {"area=4", "bias-kind=ideal"}


def test_success_can_be_the_users_own(robot: str, run_json: RunJson) -> None:
    own = run_json("mission", robot, *COUNTS, "--success", "distance_m > 0")["ways"][0]
    usual = run_json("mission", robot, *COUNTS)["ways"][0]
    assert own["yield"] == usual["yield"]
    far = run_json("mission", robot, *COUNTS, "--success", "far or not far")["ways"][0]
    assert far["undefined"] == sum(die["fails"] for die in far["failing"]) > 0


def test_a_run_that_cannot_be_made_is_told_and_no_success(robot: str, run: Run) -> None:
    status, text, _ = run("mission", robot, *COUNTS, "--param", "broken=1003", "--json")
    way = json.loads(text)["ways"][0]
    assert (status, way["not_run"]) == (0, {"chip: die 1003 cannot be calibrated": 4})
    assert {"die": 1003, "fails": 4, "trial": 0, "again": None} in way["failing"]
    status, _, err = run("mission", robot, "--dies", "1", "--threads", "1", "--param", "broken=1000")
    assert (status, err.count("\n")) == (1, 1)
    assert "no run of generator-27C could be made, the first: chip: die 1000 cannot be calibrated" in err


def test_a_mission_ends_where_its_yield_is_known(robot: str, run_json: RunJson) -> None:
    found = run_json(
        "mission", robot, "--dies", "400", "--threads", "1", "--until", "8%", "--change", "area=4"
    )
    base, changed = found["ways"]
    assert base["dies"] == changed["dies"] < 400
    assert base["interval"]["high"] - base["interval"]["low"] <= 0.16


def test_parts_workers_and_a_kill_give_the_bytes_of_one_run(robot: str, run: Run, run_json: RunJson) -> None:
    words = ("mission", robot, "--dies", "12", "--chunk", "2", "--change", "area=4")
    assert run(*words, "--threads", "1", "-o", "one")[0] == 0
    for k in (1, 2):
        assert run(*words, "--threads", "1", "--shard", f"{k}/2", "-o", f"part{k}")[0] == 0
    assert run("merge", "part2", "part1", "-o", "whole")[0] == 0
    assert contents(Path("whole")) == contents(Path("one"))
    assert run(*words, "--threads", "3", "-o", "three")[0] == 0
    assert contents(Path("three")) == contents(Path("one"))


def test_failing_dies_are_blamed_and_kept(run: Run, run_json: RunJson, tmp_path: Path) -> None:
    words = (
        "mission",
        TOY,
        "--dies",
        "5",
        "--worlds",
        "1",
        "--trials",
        "1",
        "--threads",
        "1",
        "--blame",
        "2",
    )
    out = ("-o", str(tmp_path / "out"))
    (own,) = run_json(*words, *out)["blame"]
    assert [each["die"] for each in own["dies"]] == [1001, 1002]
    assert all(each["guilty"] and each["mends"] for each in own["dies"])
    assert all(path.startswith("toy_chip.cell[") for each in own["dies"] for path in each["named"])
    (row,) = own["shares"]
    assert (row["block"], row["dies"], row["share"]) == ("toy_chip.cell[*].near", 2, 1.0)
    assert row["interval"]["low"] == pytest.approx(0.1581, abs=1e-4)  # Clopper and Pearson, 2 of 2
    page = (tmp_path / "out/report.html").read_text()
    assert own["dies"][0]["named"][0] in page
    kept = contents(tmp_path / "out")
    assert run(*words, *out, "--resume")[0] == 0
    assert contents(tmp_path / "out") == kept


def test_a_die_is_blamed_for_what_success_is_in_the_users_words() -> None:
    own = Asked(TOY, "total_V < 1", dies=2, worlds=1, trials=1)  # of which a healed die has none either
    made = mission_of(own)
    failing = {Numbered(made.ways[0].name, 1001): 0}
    (found,) = blame_failing(made, failing)
    assert not found.guilty
    assert [(row.block, row.share.value) for row in block_shares([found])] == [(NOT_THE_DIE, 1.0)]


def test_an_error_while_a_die_is_blamed_is_no_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    made = mission_of(Asked(TOY, dies=2, worlds=1, trials=1))
    failing = {Numbered(made.ways[0].name, 1001): 0}

    def refused(case: object) -> None:
        raise ParameterError("cell: 3, must be another")

    monkeypatch.setattr("system.study.mission.blamed.blame", refused)
    with pytest.raises(ParameterError, match="cell: 3, must be another"):
        blame_failing(made, failing)


def test_a_die_is_divided_among_its_devices() -> None:
    own = Blamed(
        "way", 1000, 0, guilty=True, named=("a.m1", "a.m2", "b.m1"), blocks=("a", "a", "b"), mends=True
    )
    other = Blamed("way", 1001, 0, guilty=True, named=("b.m1",), blocks=("b",))
    rows = block_shares([own, other])
    assert [(row.block, row.dies, row.share.value) for row in rows] == [
        ("a", 1, pytest.approx(1.0 / 3.0)), ("b", 1, pytest.approx(1.0 / 6.0)), (NOT_SHOWN, 1, 0.5),
    ]  # fmt: skip
    assert all(0.0 <= row.share.interval.low < row.share.value < row.share.interval.high for row in rows)


def test_a_killed_mission_goes_on_to_the_bytes_of_one_run(robot: str, run: Run) -> None:
    words = ("mission", robot, "--dies", "40", "--chunk", "1", "--threads", "1")
    command = [sys.executable, "-m", "system.cli.command_line", *words, "-o", "killed"]
    process = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": str(HERE)})
    chunks = Path("killed/generator-27C/chunks")
    wait_until(lambda: chunks.is_dir() and len(list(chunks.glob("*.nc"))) > 2)
    process.send_signal(signal.SIGKILL)
    process.wait()
    page = Path("killed/report.html").read_text()
    assert 'http-equiv="refresh"' in page
    assert "of 160 runs. This page reads itself again every 5 s." in page
    assert run(*words, "-o", "killed", "--resume")[0] == 0
    assert run(*words, "-o", "one")[0] == 0
    assert contents(Path("killed")) == contents(Path("one"))


def test_what_does_not_belong_together_is_not_merged(
    robot: str, run: Run, refused: Callable[..., str]
) -> None:
    words = ("mission", robot, *COUNTS)
    for k in (1, 2):
        assert run(*words, "--shard", f"{k}/2", "-o", f"part{k}")[0] == 0
    assert "merge: 2 of 2 missing; name its folder too" in refused("merge", "part1", "-o", "whole")
    twice = refused("merge", "part1", "part2", "part1/", "-o", "whole")
    assert "merge: 1/2 is in part1 and in part1, must be there once" in twice
    assert run(*words, "--worlds", "1", "--shard", "2/2", "-o", "other")[0] == 0
    assert "merge: other has worlds 1, must be 2" in refused("merge", "part1", "other", "-o", "whole")
    manifest = Path("part2/generator-27C/study.json")
    kept = manifest.read_text()
    manifest.write_text(kept.replace('"noctule": "', '"noctule": "9.'))
    assert "merge: part2 was run with noctule 9." in refused("merge", "part1", "part2", "-o", "whole")
    manifest.write_text(kept)
    code = Path(robot.partition(":")[0])
    own = code.read_text()
    code.write_text(own + "# mended\n")
    assert "merge: part1/generator-27C has subject.code " in refused("merge", "part1", "part2", "-o", "whole")
    code.write_text(own)
    next(Path("part2/generator-27C/chunks").glob("*.nc")).unlink()
    assert "part2/generator-27C has no samples of dies" in refused("merge", "part1", "part2", "-o", "whole")
    assert "no mission, there is no mission.json" in refused("merge", ".", "-o", "whole")
    assert not Path("whole").exists()
    into = refused("merge", "part1", "part2", "-o", "other")
    assert "output: other has a mission; name another folder" in into


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--success", "way >= 20"], "--success: metric way: unknown"),
        (["--dies", "0"], "--dies: 0, must be at least 1"),
        (["--worlds", "1001"], "--worlds: 1001, must be at least 1 and at most 1000"),
        (["--until", "60%"], "--until: 0.6, must be above 0 and below 50 %"),
        (["--shard", "3/2", "-o", "out"], '--shard: "3/2", must be I/N'),
        (["--shard", "1/2"], "--shard: of which mission, must come with --output"),
        (
            ["--shard", "1/40", "-o", "out"],
            "--shard: 1/40, must be 1/n to n/n with n at most 6, the chunks of 4 dies",
        ),
        (
            ["--shard", "1/2", "--until", "2%", "-o", "out"],
            "--shard: with --until, whose end depends on all dies",
        ),
        (["--blame", "-1"], "--blame: -1, must be at least 0"),
        (
            ["--blame", "1", "--shard", "1/2", "-o", "out"],
            "--blame: with --shard, which has some of the dies",
        ),
        (["--change", "colour=red"], "colour: not an option of tries"),
        (["--change", "area"], "must be NAME=VALUE"),
        (["--temperature", "27", "--temperature", "27"], "generator-27C is there twice"),
        (["--param", "silicon_noise=off"], "--trials: 2, there is no noise"),
        (["--no-mismatch", "--no-process-variation"], "so all dies are one; leave it on"),
        (["--param", "pace=3"], "pace: not an option of tries"),
        (["--resume", "-o", "out"], "--resume: out has no mission to go on with"),
    ],
)
def test_what_no_mission_has_is_refused(
    robot: str, words: list[str], says: str, refused: Callable[..., str]
) -> None:
    counts = COUNTS if "--dies" not in words else COUNTS[2:]
    assert says in refused("mission", robot, *counts, *words)
    assert not (Path("out") / "mission.json").exists()
