"""Claim: whatever ends a study, resuming it gives the undisturbed one's files to the bit, and leaves nothing.

Processes are killed by signal 9 at random moments of a run on threads or on two processes: the command, one
of its workers, or all of them at once. Then a disk that takes no large file, a folder that may not be
written, two processes on one folder, spoiled chunks, and spoiled machine code in the kernels' cache. Every
command but the killed ones ends with status 0, or with one line and status 2. `ours` is how many of the cases
did, and `peer` of how many.
"""

from __future__ import annotations

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import psutil

from _report import Row, parser_of, report

COMMAND = [sys.executable, "-c", "import sys; from system.cli.command_line import main; sys.exit(main())"]
STUDY = ["montecarlo", "rebound-neuron", "--metric", "t_inh", "-n", "24", "--chunk", "2"]
HANDS = (("--threads", "2"), ("--workers", "2"))
VICTIMS = ("parent", "worker", "tree")
ALLOWED = ["setpriv", "--bounding-set", "-dac_override"]  # root without writing where it may not
PATIENCE = 300.0  # s, for a command


def run(arguments: Sequence[str], before: Sequence[str] = (), **options: object) -> tuple[int, str]:
    """Status and stderr of a command; `before`: what it is run by."""
    done = subprocess.run(
        [*before, *COMMAND, *arguments],
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
        **options,
    )  # type: ignore[call-overload]
    return done.returncode, done.stderr


def contents(folder: Path) -> dict[str, bytes]:
    """Samples and chunks; hidden files too, which nobody should have left."""
    files = [p for p in folder.rglob("*") if p.is_file() and p.name not in {"study.json", "report.html"}]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def killed(folder: Path, seed: int, seconds: float) -> None:
    """Begin a study and kill some of it at a random moment."""
    rng = random.Random(seed)  # noqa: S311 - moments
    hands, victim = HANDS[seed % 2], VICTIMS[seed // 2 % 3]
    child = subprocess.Popen(
        [*COMMAND, *STUDY, *hands, "-o", str(folder)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    time.sleep(rng.uniform(0.1, 1.0) * seconds)
    try:
        family = psutil.Process(child.pid).children(recursive=True)
    except psutil.NoSuchProcess:
        family = []
    pids = [p.pid for p in family]
    if victim == "worker" and pids:
        kill(rng.choice(pids))
        child.wait(PATIENCE)
    else:
        for pid in [child.pid, *(pids if victim == "tree" else [])]:
            kill(pid)
    child.wait()
    _, alive = psutil.wait_procs(family, timeout=60.0)  # workers end by themselves once nobody asks them
    if alive:
        raise RuntimeError(f"{len(alive)} processes outlive the one that began them")


def kill(pid: int) -> None:
    """Kill a process that may be gone."""
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return


def resumed(folder: Path, expected: dict[str, bytes], hands: Sequence[str] = HANDS[0]) -> bool:
    """Whether a study that goes on, or begins where nothing was begun, comes to the same files."""
    again = ["--resume"] if (folder / "study.json").exists() else []
    status, _ = run([*STUDY, *hands, "-o", str(folder), *again])
    return status == 0 and contents(folder) == expected


def at_kill(folder: Path, expected: dict[str, bytes], seed: int, seconds: float) -> bool:
    """One moment: the resumed study is the undisturbed one, and nothing is left among temporary files."""
    killed(folder, seed, seconds)
    same = resumed(folder, expected, HANDS[seed % 2])
    return same and not list(Path(tempfile.gettempdir()).glob(".noctule-*"))


def on_full_disk(folder: Path, expected: dict[str, bytes]) -> bool:
    """One line, the chunks are there, and the study goes on."""
    chunk = max(len(data) for name, data in expected.items() if name != "samples.nc")
    largest = (chunk + len(expected["samples.nc"])) // 2  # a chunk, and not all samples

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))

    status, told = run([*STUDY, "-o", str(folder)], preexec_fn=limit)
    kept = {name: data for name, data in expected.items() if name != "samples.nc"}
    refused = status == 2 and len(told.splitlines()) == 1 and contents(folder) == kept
    return refused and resumed(folder, expected)


def in_read_only_folder(folder: Path, expected: dict[str, bytes]) -> bool:
    """One line, and nothing changes."""
    run([*STUDY, "-o", str(folder)])
    folder.chmod(0o555)

    status, told = run([*STUDY, "-o", str(folder), "--resume"], ALLOWED if os.getuid() == 0 else ())
    folder.chmod(0o755)
    return status == 2 and len(told.splitlines()) == 1 and contents(folder) == expected


def by_two_processes(folder: Path, expected: dict[str, bytes]) -> bool:
    """One ends well; the other does too, or is refused by the folder's name."""
    begin = [*COMMAND, *STUDY, "-o", str(folder)]
    both = [
        subprocess.Popen(begin, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for _ in "12"
    ]
    told = [child.communicate(timeout=PATIENCE)[1] for child in both]
    states = sorted(child.returncode for child in both)
    named = all(str(folder) in text for text, child in zip(told, both, strict=True) if child.returncode)
    return states in ([0, 0], [0, 2]) and named and contents(folder) == expected


def with_spoiled_chunks(folder: Path, expected: dict[str, bytes]) -> bool:
    """Chunks with a byte that was changed, half of one, and another's in its place."""
    run([*STUDY, "-o", str(folder)])
    files = sorted((folder / "chunks").iterdir())
    data = bytearray(files[0].read_bytes())
    data[-9] ^= 0xFF
    files[0].write_bytes(bytes(data))
    files[1].write_bytes(files[1].read_bytes()[:900])
    files[2].write_bytes(files[3].read_bytes())
    return resumed(folder, expected)


def with_spoiled_kernels(folder: Path, expected: dict[str, bytes]) -> bool:
    """Every file of the kernels' cache is another's half."""
    cache = folder.parent / "kernels"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    run([*STUDY, "-o", str(folder)], env=environment)
    for path in cache.rglob("*.nb?"):
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    shutil.rmtree(folder)
    status, told = run([*STUDY, "-o", str(folder)], env=environment)
    return (status, told) == (0, "") and contents(folder) == expected


CASES: dict[str, Callable[[Path, dict[str, bytes]], bool]] = {
    "a disk that takes no large file": on_full_disk,
    "a folder that may not be written": in_read_only_folder,
    "two processes on one folder": by_two_processes,
    "spoiled chunks": with_spoiled_chunks,
    "spoiled kernels": with_spoiled_kernels,
}


def main() -> int:
    """Print a row a kind of fault."""
    options = parser_of(__doc__, "6 kills, without spoiled kernels").parse_args()
    moments = 6 if options.quick else 50
    with tempfile.TemporaryDirectory() as above:
        os.environ["TMPDIR"] = tempfile.tempdir = above  # debris of other commands is not ours
        run([*STUDY, "-o", f"{above}/first"])  # compiles the kernels
        start = time.perf_counter()
        run([*STUDY, "-o", f"{above}/undisturbed"])
        seconds = time.perf_counter() - start
        expected = contents(Path(above) / "undisturbed")
        held = [at_kill(Path(above) / f"killed{k}", expected, k, seconds) for k in range(moments)]
        rows = [row("killed at a random moment", held)]
        for name, case in list(CASES.items())[: 4 if options.quick else None]:
            rows.append(row(name, [case(Path(above) / name.replace(" ", "_"), expected)]))
    return report(rows, options, lambda r: f"{r.ours:3.0f} of {r.peer:3.0f}")


def row(name: str, held: Sequence[bool]) -> Row:
    """How many cases held, of how many."""
    missed = [k for k, well in enumerate(held) if not well]
    accuracy = f"files differ or status is wrong at {missed}" if missed else "all files identical, no debris"
    return Row(name, sum(held), len(held), sum(held) / len(held), accuracy, least=1.0)


if __name__ == "__main__":
    sys.exit(main())
