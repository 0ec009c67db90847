"""Claim: the wheel works in a new environment, installed where its user can write nothing, without a home.

The wheel is built and installed with all that it needs into a virtual environment outside of the repository;
then the main job, a study, an export and a short reproduction run in another folder, without `HOME`, where
neither the installation nor the user's home can be written.
It is built of a copy of the packages, in which commands are run before (`KERNELS`) whose machine code goes
with it, for this version of Python, numba and LLVM and the kinds of `circuits.machine_code.target` that this
processor is. `--output FOLDER` keeps the wheel.
`--quick` takes what the wheel needs from the environment that runs this script, and leaves the study out.
`--ci` is for each change: the main job on the Python that runs this script, which may compile nothing, and an
export on every other of `OTHERS` that is here, each with all that it needs and from another folder. One that
is not here is named. In a continuous integration (`CI`) the wheel carries the kernels of the main job alone,
which the checkout's tests need too: whichever is first compiles them, for both. The main job is begun only.
`--first` measures instead: processor time of the first run of each of `FIRST` in a new environment with empty
caches, beside that of the second, and the size of the wheel.
"""

from __future__ import annotations

import os
import resource
import shutil
import stat
import subprocess
import sys
import sysconfig
import tempfile
import time
from argparse import Namespace
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version as version_of
from itertools import islice, product
from pathlib import Path

from _report import Row, parser_of, report
from circuits.machine_code.cache import SHIPPED
from circuits.machine_code.target import kinds_here

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("circuits", "chips", "netlists", "system")
COMMANDS = {
    "main job": ["run", "approach", "--plot", "approach.png"],
    "study": ["montecarlo", "rebound-neuron", "-n", "4", "-o", "study"],
    "export": ["export", "ranging-chip", "-o", "chip.cir"],
    "reproduction": ["reproduce", "cheely2003-fig10", "--plot", "fig10.png"],
}
LEFT = {
    "main job": "approach.png",
    "study": "study/samples.nc",
    "export": "chip.cir",
    "reproduction": "fig10.png",
}
QUICK = ("export", "reproduction")
BEGUN = ["--duration", "0.3s"]  # of the main job; its kernels are called from the first ping on
# What is run so that its kernels go with the wheel; the first is all that a check of a change needs.
KERNELS = (
    "run approach --duration 0.05s --plot a.png", "run approach --level behavioural --plot a.png",
    "simulate rebound-neuron", "simulate rolls-neuron", "op ranging-chip", "show rebound-neuron",
    "montecarlo rebound-neuron -n 20 -o study", "sweep transamp-p --over v_plus=0V..1.8V:11",
    "run rolls --duration 0.2s", "run pushbot --duration 0.3s", "run forest --pings 30", "run car --pings 20",
    "run head --duration 0.2s", "run rover --trips 1", "run bug --duration 1s", "run spiking-bat --pings 5",
)  # fmt: skip
FIRST = (
    "list", "show rebound-neuron", "simulate rebound-neuron", "run approach --beside nominal --plot a.png",
    "run approach --level behavioural --plot a.png", "run rolls --duration 0.2s",
    "run pushbot --duration 0.3s",
)  # fmt: skip
AT_MOST = 2.5  # of a first run, times the second
OTHERS = ("3.12", "3.13")  # Pythons that the wheel is also for
WHOLE = "import ctypes, ensurepip, ssl, venv"  # what a Python must have; a name of pyenv's may lead to none
# The compiler for which kernels come with the wheel.
SAME = [f"{name}=={version_of(name)}" for name in ("numba", "llvmlite")]
PIP = [sys.executable, "-m", "pip", "-q", "--disable-pip-version-check"]
# For root, whom modes do not bind: two folders are mounted read-only over themselves before the command.
READ_ONLY = (
    'for each in "$0" "$1"; do'
    ' mount --bind "$each" "$each" && mount -o remount,bind,ro "$each" || exit 1; done; shift; exec "$@"'
)


def install(folder: Path, wheel: Path, *, quick: bool) -> Path:
    """Install the wheel into `folder`; returns the command `noctule`."""
    python = new_environment(folder / "environment", sys.executable)
    if quick:
        here = sysconfig.get_path("purelib")
        (there,) = (python.parents[1] / "lib").glob("python*/site-packages")
        copied = shutil.ignore_patterns("*noctule*", "__editable__*")
        shutil.copytree(here, there, symlinks=True, dirs_exist_ok=True, ignore=copied)
    subprocess.run(
        [*PIP, "--python", str(python), "install", *(["--no-deps"] if quick else []), str(wheel)], check=True
    )
    return python.parent / "noctule"


def copied(folder: Path) -> Path:
    """A copy of what the wheel is made of, without machine code, in `folder`: the checkout stays as it is."""
    tree = folder / "tree"
    tree.mkdir()
    left = shutil.ignore_patterns("__pycache__", SHIPPED.name)
    for name in PACKAGES:
        shutil.copytree(ROOT / name, tree / name, ignore=left)
    for path in ROOT.iterdir():
        if path.is_file():
            shutil.copy(path, tree)
    return tree


def share_cache(tree: Path) -> None:
    """Keep kernels of `tree` where those of the checkout are, by their contents: each is compiled once."""
    for name in PACKAGES:
        for package in (tree / name, *(path for path in (tree / name).rglob("*") if path.is_dir())):
            kept = ROOT / package.relative_to(tree) / "__pycache__"
            kept.mkdir(exist_ok=True)
            (package / "__pycache__").symlink_to(kept)


def make_kernels(folder: Path, tree: Path, *, few: bool) -> None:
    """Have the machine code of `KERNELS` in the packages of `tree`, for each kind that this processor is."""
    work = folder / "kernels"
    work.mkdir()
    noctule = Path(sys.executable).with_name("noctule")
    environment = {**os.environ, "NOCTULE_SHIP_KERNELS": "1", "PYTHONPATH": str(tree)}
    named = [{"NUMBA_CPU_NAME": kind, "NUMBA_CPU_FEATURES": ""} for kind in kinds_here()]
    runs = product(named or [{}], KERNELS)
    for number, (target, command) in enumerate(islice(runs, 1) if few else runs):
        own = work / str(number)  # a study goes on in no folder of another
        own.mkdir()
        words = [str(noctule), *command.split()]
        subprocess.run(words, check=True, capture_output=True, cwd=own, env=environment | target)


def built(folder: Path, tree: Path) -> Path:
    """The wheel of `tree`, made in `folder`."""
    subprocess.run([*PIP, "wheel", "--no-deps", "-w", str(folder), str(tree)], check=True)
    (wheel,) = folder.glob("*.whl")
    return wheel


def new_environment(folder: Path, python: str) -> Path:
    """The Python of a new virtual environment in `folder`, of the same version as `python`."""
    subprocess.run([python, "-m", "venv", str(folder)], check=True)
    return folder / "bin" / "python"


def other_python(version: str) -> str | None:
    """A Python of a version on this machine that runs: by its name, else of pyenv's; None without."""
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    for python in (shutil.which(f"python{version}"), *sorted(pyenv.glob(f"{version}.*/bin/python"))):
        if python is not None:
            done = subprocess.run([python, "-c", WHOLE], check=False, capture_output=True)
            if not done.returncode:
                return str(python)
    return None


def checked(folder: Path, wheel: Path) -> list[Row]:
    """A row a Python: what it does with the wheel that is installed with all that it needs."""
    pythons = {f"{sys.version_info.major}.{sys.version_info.minor}": (sys.executable, "main job")}
    for version in OTHERS:
        found = other_python(version)
        if found is None:
            print(f"Python {version}: not here, skipped", file=sys.stderr)
        elif version not in pythons:
            pythons[version] = (found, "export")

    def row(version: str) -> Row:
        python, name = pythons[version]
        start = time.perf_counter()
        made = new_environment(folder / version, python)
        wanted = SAME if python == sys.executable else []
        words = [str(wheel), *wanted, "--no-compile"]  # for one command, which imports little of it
        subprocess.run([*PIP, "--python", str(made), "install", *words], check=True)
        work, kernels = folder / f"work-{version}", folder / f"kernels-{version}"
        work.mkdir()
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(kernels)}
        begun = BEGUN if name == "main job" and os.environ.get("CI") else []
        command = [str(made.parent / "noctule"), *COMMANDS[name], *begun]
        good, told = carried_out(name, command, work, environment)
        compiled = len(list(kernels.rglob("*.nbc")))
        good &= not (wanted and compiled and kinds_here())
        seconds = time.perf_counter() - start
        told = f"{compiled} kernels compiled; {told}"
        return Row(f"Python {version}, {name}", seconds, None, float(good), told, 1, 1.0)

    with ThreadPoolExecutor() as threads:
        return list(threads.map(row, pythons))


def carried_out(name: str, words: list[str], work: Path, environment: dict[str, str]) -> tuple[bool, str]:
    """Whether a command of `COMMANDS` ended well and left its file in `work`; its status with its stderr."""
    done = subprocess.run(words, check=False, capture_output=True, text=True, cwd=work, env=environment)
    good = not done.returncode and (work / LEFT[name]).is_file() and "Traceback" not in done.stderr
    told = " ".join(done.stderr.split())[:400] or "nothing on stderr"
    return good, f"status {done.returncode}; {told}"


def unwritable(folder: Path) -> list[str]:
    """Words before a command that may not write into the installation under `folder`, nor into its home."""
    environment = folder / "environment"
    if os.geteuid() == 0:
        return ["/usr/bin/unshare", "-m", "/bin/sh", "-c", READ_ONLY, str(environment), str(Path.home())]
    set_writable(environment, 0)
    return []


def set_writable(folder: Path, bit: int) -> None:
    """Give the owner of all folders under `folder` the right to write, or take it from everybody."""
    everybody = stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH
    for path in (folder, *folder.rglob("*")):
        if path.is_dir() and not path.is_symlink():
            path.chmod(path.stat().st_mode & ~everybody | bit)


def first_runs(folder: Path, wheel: Path) -> Iterator[Row]:
    """A row a command: processor time of its first run in a new environment, and of its second."""
    size = wheel.stat().st_size / 1e6
    yield Row("size of the wheel, MB", size, None, None, f"{_shipped(folder):.1f} MB of kernels")
    command = install(folder, wheel, quick=True)
    work = folder / "work"
    work.mkdir()
    for number, text in enumerate(FIRST):
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / f"kernels-{number}")}
        first, second = (_processor_time([str(command), *text.split()], work, environment) for _ in range(2))
        count = len(list((folder / f"kernels-{number}").rglob("*.nbc")))
        yield Row(text, first, second, first / second, f"{count} kernels compiled", most=AT_MOST)


def _shipped(folder: Path) -> float:
    """Machine code that goes with the wheel that was made in `folder`, MB."""
    return sum(path.stat().st_size for path in (folder / "tree").rglob("*.nb?")) / 1e6


def _processor_time(words: list[str], work: Path, environment: dict[str, str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, capture_output=True, cwd=work, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(folder: Path, wheel: Path, *, quick: bool) -> list[Row]:
    """A row a command: done or not, and how long it took."""
    command = install(folder, wheel, quick=quick)
    before = unwritable(folder)
    work = folder / "work"
    work.mkdir()
    environment = {"PATH": os.environ["PATH"], "LANG": "C.UTF-8"}
    rows = []
    for name, arguments in COMMANDS.items():
        if quick and name not in QUICK:
            continue
        start = time.perf_counter()
        good, told = carried_out(name, [*before, str(command), *arguments], work, environment)
        seconds = time.perf_counter() - start
        rows.append(Row(name, seconds, None, float(good), told, 1, 1.0))
    return rows


def main() -> int:
    """Install and run; the exit status is 1 where a command fails."""
    parser = parser_of(__doc__, "two commands, with the libraries of this environment")
    parser.add_argument("--ci", action="store_true", help="the main job, and an export on other Pythons")
    parser.add_argument("--first", action="store_true", help="first and second runs, and the size")
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="keep the wheel there")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tree, few = copied(folder), bool(os.environ.get("CI"))
        if few:
            share_cache(tree)
        make_kernels(folder, tree, few=few)
        wheel = built(folder, tree)
        if options.output:
            options.output.mkdir(parents=True, exist_ok=True)
            shutil.copy(wheel, options.output)
        rows = rows_of(folder, wheel, options)
        set_writable(folder, stat.S_IWUSR)
    return report(rows, options, beside if options.first else lambda r: f"{r.ours:6.1f} s")


def beside(row: Row) -> str:
    """Both figures, and their ratio."""
    if row.peer is None:
        return f"{row.ours:6.2f}"
    return f"{row.ours:6.2f} s, then {row.peer:.2f} s, ratio {row.ratio:.2f}"


def rows_of(folder: Path, wheel: Path, options: Namespace) -> list[Row]:
    """What is asked for."""
    if options.first:
        return list(first_runs(folder, wheel))
    return checked(folder, wheel) if options.ci else measured(folder, wheel, quick=options.quick)


if __name__ == "__main__":
    sys.exit(main())
