"""Claim: the wheel works in a new environment, installed where its user can write nothing, without a home.

The wheel is built and installed with all that it needs into a virtual environment outside of the repository;
then the main job, a study, an export and a short reproduction run in another folder, without `HOME`, where
neither the installation nor the user's home can be written.
`--quick` takes what the wheel needs from the environment that runs this script, and leaves the study out.
"""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
import sysconfig
import tempfile
import time
from pathlib import Path

from _report import Row, parser_of, report

ROOT = Path(__file__).resolve().parents[1]
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
# For root, whom modes do not bind: two folders are mounted read-only over themselves before the command.
READ_ONLY = (
    'for each in "$0" "$1"; do'
    ' mount --bind "$each" "$each" && mount -o remount,bind,ro "$each" || exit 1; done; shift; exec "$@"'
)


def install(folder: Path, *, quick: bool) -> Path:
    """Build the wheel and install it into `folder`; returns the command `noctule`."""
    python = folder / "environment" / "bin" / "python"
    subprocess.run([sys.executable, "-m", "venv", str(python.parents[1])], check=True)
    pip = [sys.executable, "-m", "pip", "-q", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "-w", str(folder), str(ROOT)], check=True)
    (wheel,) = folder.glob("*.whl")
    if quick:
        here = sysconfig.get_path("purelib")
        (there,) = (python.parents[1] / "lib").glob("python*/site-packages")
        copied = shutil.ignore_patterns("*noctule*", "__editable__*")
        shutil.copytree(here, there, symlinks=True, dirs_exist_ok=True, ignore=copied)
    subprocess.run(
        [*pip, "--python", str(python), "install", *(["--no-deps"] if quick else []), str(wheel)], check=True
    )
    return python.parent / "noctule"


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


def measured(folder: Path, *, quick: bool) -> list[Row]:
    """A row a command: done or not, and how long it took."""
    command = install(folder, quick=quick)
    before = unwritable(folder)
    work = folder / "work"
    work.mkdir()
    environment = {"PATH": os.environ["PATH"], "LANG": "C.UTF-8"}
    rows = []
    for name, arguments in COMMANDS.items():
        if quick and name not in QUICK:
            continue
        start = time.perf_counter()
        done = subprocess.run(
            [*before, str(command), *arguments], check=False, capture_output=True, text=True, cwd=work,
            env=environment,
        )  # fmt: skip
        seconds = time.perf_counter() - start
        good = not done.returncode and (work / LEFT[name]).is_file() and "Traceback" not in done.stderr
        told = " ".join(done.stderr.split())[:400] or "nothing on stderr"
        rows.append(Row(name, seconds, None, float(good), f"status {done.returncode}; {told}", 1, 1.0))
    return rows


def main() -> int:
    """Install and run; the exit status is 1 where a command fails."""
    options = parser_of(__doc__, "two commands, with the libraries of this environment").parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = measured(Path(folder), quick=options.quick)
        set_writable(Path(folder), stat.S_IWUSR)
    return report(rows, options, lambda r: f"{r.ours:6.1f} s")


if __name__ == "__main__":
    sys.exit(main())
