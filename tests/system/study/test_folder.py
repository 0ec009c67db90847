"""A study's folder: one process at a time, nothing foreign or edited is believed, nothing is left behind."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from circuits.errors import DataError, ParameterError
from circuits.seal import sealed, unsealed
from system.cli.command_line import main
from system.files.claim import claimed
from system.study.folder import CHUNKS, SAMPLES, open_folder, study_table
from system.study.manifest import Study
from tests.system.study.test_engine import HERE, ROOT, run, same, study


def chunk_files(folder: Path) -> list[Path]:
    return sorted((folder / CHUNKS).iterdir())


def biased() -> Study:
    wanted = study()
    return replace(wanted, subject=replace(wanted.subject, biases=("i_rtau=30pA",)))


def foreign(folder: Path, tmp_path: Path) -> str:
    """A chunk of the same dies at another bias."""
    run(biased(), tmp_path / "other")
    shutil.copy(chunk_files(tmp_path / "other")[1], chunk_files(folder)[1])
    return "is of another study"


def edited(folder: Path, tmp_path: Path) -> str:
    with h5py.File(chunk_files(folder)[1], "r+") as file:
        file["metric_threshold_sum"][2] += 1e-3  # the other two have no value
    return "it was cut or edited"


def flipped(folder: Path, tmp_path: Path) -> str:
    path = chunk_files(folder)[1]
    path.write_bytes(flip(path.read_bytes()))
    return "it was changed since it was written"


def of_old(folder: Path, tmp_path: Path) -> str:
    """As chunks were before they were sealed."""
    path = chunk_files(folder)[1]
    path.write_bytes(unsealed(path.read_bytes()))
    return "no digest of its contents at its end"


def flip(data: bytes) -> bytes:
    """Byte 793 turned over: HDF5 reads such a file for ever."""
    return data[:793] + bytes([data[793] ^ 1]) + data[794:]


def cut_short(data: bytes) -> bytes:
    return data[:4000]


def empty(data: bytes) -> bytes:
    return b""


def without_key(folder: Path, tmp_path: Path) -> str:
    """As chunks were before they had a key, sealed."""
    path = chunk_files(folder)[1]
    with xr.open_dataset(path, engine="h5netcdf") as data:
        loaded = data.load()
    del loaded.attrs["study"]
    loaded.attrs["format"] = 1
    path.write_bytes(sealed(loaded.to_netcdf(engine="h5netcdf")))
    return "is no table of samples, format 1"


def truncated(folder: Path, tmp_path: Path) -> str:
    path = chunk_files(folder)[1]
    path.write_bytes(path.read_bytes()[:4000])
    return "cannot be read"


@pytest.mark.parametrize("spoil", [foreign, edited, flipped, of_old, without_key, truncated])
def test_a_chunk_that_does_not_fit_is_measured_again_and_told(
    spoil: Callable[[Path, Path], str], tmp_path: Path
) -> None:
    once = run(study(), tmp_path / "a").table
    told = spoil(tmp_path / "a", tmp_path)
    again = run(study(), tmp_path / "a", resume=True)
    assert same(again.table, once)
    assert again.chunks_read == 3
    assert len(again.chunks_redone) == 1
    assert told in again.chunks_redone[0]
    assert same(study_table(str(tmp_path / "a")), once)


@pytest.mark.parametrize("spoil", [foreign, edited, flipped, of_old, without_key, truncated])
def test_samples_that_do_not_fit_are_no_samples_of_the_study(
    spoil: Callable[[Path, Path], str], tmp_path: Path
) -> None:
    run(study(), tmp_path / "a")
    (tmp_path / "a" / SAMPLES).unlink()
    told = spoil(tmp_path / "a", tmp_path)
    with pytest.raises(DataError, match=told):
        study_table(tmp_path / "a")


def test_spoiled_samples_are_told_in_one_line_each(tmp_path: Path) -> None:
    run(study(), tmp_path / "a")
    folders = []
    for spoil in (flip, cut_short, empty):
        folders.append(tmp_path / spoil.__name__)
        shutil.copytree(tmp_path / "a", folders[-1])
        path = folders[-1] / SAMPLES
        path.write_bytes(spoil(path.read_bytes()))
    words = ["--die", "1005", "--metric", f"{HERE}:threshold_sum"]
    code = (
        "import sys; from system.cli.command_line import main;"
        f"sys.exit(max(main(['replay', folder, *{words}]) for folder in sys.argv[1:]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *folders], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")  # nothing of a file that HDF5 left half open
    told = [line for line in done.stdout.splitlines() if "samples.nc" in line]
    assert len(told) == len(folders)
    assert all("cannot be read" in line for line in told)


def test_a_study_of_a_class_alone_is_read_back(tmp_path: Path) -> None:
    wanted = study(2)
    wanted = replace(wanted, subject=replace(wanted.subject, metrics=("class",)))
    once = run(wanted, tmp_path).table
    again = run(wanted, tmp_path, resume=True)
    assert again.chunks_redone == ()
    assert again.table.outcome == once.outcome


def test_a_second_process_is_refused_by_name(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from tests.system.study import test_engine as t;"
        "from system.study.folder import open_folder;"
        f"held = open_folder(Path({str(tmp_path)!r}), t.study(), resume=False); held.__enter__();"
        "print('at work', flush=True); sys.stdin.read()"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", code], cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert child.stdout is not None
        assert child.stdout.readline() == "at work\n"
        with pytest.raises(ParameterError, match=r"output: .* another process is at work in it"):
            run(study(), tmp_path, resume=True)
    finally:
        child.kill()
        child.communicate()
    assert run(study(), tmp_path, resume=True).table.die.size == 10  # a dead process holds nothing


def test_one_process_does_not_write_a_folder_twice(tmp_path: Path) -> None:
    with (
        open_folder(tmp_path, study(), resume=False),
        pytest.raises(ParameterError, match="another process is at work"),
    ):
        run(study(), tmp_path, resume=True)


def test_what_a_killed_process_left_is_swept_and_what_a_live_one_writes_stays(tmp_path: Path) -> None:
    run(study(4), tmp_path)
    dead = [tmp_path / CHUNKS / ".noctule-0123456789ab.nc", tmp_path / ".noctule-0123456789ab.json"]
    alive, theirs = tmp_path / ".noctule-ba9876543210.csv", tmp_path / CHUNKS / "notes.txt"
    for path in (*dead, alive, theirs):
        path.write_text("half")
    with claimed(alive):
        run(study(), tmp_path, resume=True)
    assert [path.exists() for path in (*dead, alive, theirs)] == [False, False, True, True]


def test_a_full_disk_ends_in_one_line_and_keeps_what_was_finished(tmp_path: Path) -> None:
    """The largest file that is allowed holds a chunk, and not the table of all samples."""
    folder = tmp_path / "study"
    size = largest_chunk(tmp_path) + 2048

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    command = ["montecarlo", "rebound-neuron", "--metric", f"{HERE}:threshold_sum", "--no-process-variation"]
    command += ["-n", "100", "--chunk", "20", "-o", str(folder)]
    # no page of an unfinished study, which a slow machine would write and which is too large as well
    code = """import sys
from system.cli.command_line import main
from system.study.report.growing import Growing
Growing.__call__ = lambda self, found: None
sys.exit(main())"""
    done = subprocess.run(
        [sys.executable, "-c", code, *command], cwd=ROOT, preexec_fn=limit, capture_output=True, text=True,
        check=False, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert "samples.nc: cannot be written, the file grows beyond the allowed size" in done.stderr
    assert len(chunk_files(folder)) == 5
    assert not (folder / SAMPLES).exists()
    assert not list(tmp_path.rglob(".noctule-*"))
    again = run(study(100, 20), folder, resume=True)
    assert again.chunks_read == 5
    assert same(again.table, run(study(100, 20)).table)


def largest_chunk(tmp_path: Path) -> int:
    run(study(200, 20), tmp_path / "free")
    sizes = [path.stat().st_size for path in chunk_files(tmp_path / "free")]
    assert (tmp_path / "free" / SAMPLES).stat().st_size > max(sizes) + 2048
    return max(sizes)


@pytest.mark.parametrize("spoil", [foreign, edited, flipped])
def test_replay_shows_no_value_that_is_not_the_study_s(
    spoil: Callable[[Path, Path], str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(study(), tmp_path / "a")
    (tmp_path / "a" / SAMPLES).unlink()
    told = spoil(tmp_path / "a", tmp_path)
    assert main(["replay", str(tmp_path / "a"), "--die", "1005", "--metric", f"{HERE}:threshold_sum"]) == 0
    out = capsys.readouterr().out
    assert "nothing to compare with" in out
    assert told in out
    assert "identical" not in out


def test_a_changed_metric_s_name_shows_no_old_value(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wanted = study(2)
    wanted = replace(wanted, subject=replace(wanted.subject, metrics=("t_inh",)))
    kept = run(wanted, tmp_path).table
    manifest = tmp_path / "study.json"
    manifest.write_text(manifest.read_text().replace('"t_inh"', '"best_delay"'))
    assert main(["replay", str(tmp_path), "--die", "1000", "--json"]) == 0
    out = capsys.readouterr().out
    assert "is of another study" in out
    assert repr(float(kept.values[0, 0])) not in out
    assert np.isfinite(kept.values[0, 0])
