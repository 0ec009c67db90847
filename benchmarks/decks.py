"""Claim: decks that nobody here wrote are read or refused with a line, and run as they do in ngspice alone.

Nothing is fetched: FOLDER has ngspice's source (its `examples` and `tests`), and beside them a folder
`public` with decks found by a public search, under the names below. Each deck is read as `noctule import`
does. It is solved natively where its devices are ours, run in ngspice as it stands, and, with `--ngspice
FILE`, by that program alone from its own file. Rows: `ours` is the larger rms difference of a voltage over
its swing (1 mV at least), `peer` is how many points were compared; of a deck that is refused both are missing
and the line is its accuracy.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from _report import Row, parser_of, report
from circuits.arrays import F64
from circuits.checks import implausible_allowed
from circuits.errors import CircuitError
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from netlists.ngspice.deck import Ran, run_deck
from netlists.read import Imported, read_netlist
from netlists.read.analysis import Sweep, Transient
from netlists.read.text.name import original_name

Curves = tuple[F64, dict[str, F64]]  # axis, voltages by node
AGREED = 0.01  # of a swing, rms
_POINTS = 2001
_DEADLINE = 60.0  # s
_QUICK = 6  # decks
NGSPICE = "ngspice's source, modified BSD unless a file says otherwise"
DECKS = (
    *(
        (name, NGSPICE)
        for name in (
            "tests/resistance/res_simple.cir", "tests/resistance/res_array.cir", "tests/general/rtlinv.cir",
            "tests/general/schmitt.cir", "tests/general/rca3040.cir", "tests/general/fourbitadder.cir",
            "tests/general/mosmem.cir", "tests/mos6/simpleinv.cir", "tests/mos6/mos6inv.cir",
            "tests/bsim1/test.cir", "tests/bsim3soidd/inv2.cir", "tests/bsim3soipd/t4.cir",
            "tests/hfet/inverter.cir", "tests/jfet/jfet_vds-vgs.cir", "tests/mes/subth.cir",
            "tests/mesa/mesosc.cir", "tests/vbic/diffamp.cir", "tests/vbic/FG.cir",
            "tests/transmission/ltra1_1_line.cir", "tests/transmission/txl2_3_line.cir",
            "tests/regression/subckt-processing/global-1.cir", "tests/regression/misc/if-elseif.cir",
            "examples/measure/simple-meas-tran.sp", "examples/measure/inv-meas-tran.sp",
            "examples/p-to-n-examples/switch-oscillators.cir", "examples/p-to-n-examples/logic.cir",
            "tests/xspice/digital/d_ram.cir",
        )
    ),
    ("public/AH_neuron.spice", "RoyceRichmond/Mosbious_2025_Spikcore, axon-hillock neuron, no licence found"),
    ("public/izhikevich.net", "Abiaselli/izhneuron, an Izhikevich neuron, no licence found"),
    ("public/lif_neuron.sp", "chekfung/lasana, a leaky integrate-and-fire neuron, no licence found"),
)  # fmt: skip


def main() -> int:
    """Measure every deck that the folder has."""
    parser = parser_of(__doc__, f"only {_QUICK} decks")
    parser.add_argument("folder", nargs="?", type=Path, help="of ngspice's source; without it nothing is run")
    parser.add_argument("--ngspice", type=Path, help="ngspice as a program, to compare with alone")
    options = parser.parse_args()
    rows = [] if options.folder is None else list(_rows(options))
    if not rows:
        print("decks: no FOLDER of decks is named, nothing to measure", file=sys.stderr)
    return report(rows, options, _figures)


def _figures(row: Row) -> str:
    return "-" if row.peer is None else f"{100.0 * row.ours:8.3g} %  {row.peer:6g} points"


def _rows(options: Namespace) -> Iterator[Row]:
    decks = DECKS[:_QUICK] if options.quick else DECKS
    for name, origin in decks:
        yield _row(options.folder, name, origin, options.ngspice)


def _row(folder: Path, name: str, origin: str, program: Path | None) -> Row:
    path, root = folder / name, folder
    try:
        with implausible_allowed():
            found = read_netlist(path, root=root, foreign="kept")
    except CircuitError as error:
        return Row(name, 0.0, None, None, f"refused: {error}; {origin}")
    inside = len(found.circuit.devices) + len(found.circuit.instances) + len(found.testbench.sources)
    told = f"{inside} in the circuit, {len(found.foreign)} for ngspice only"
    ran = _asked(found)
    try:
        stands = run_deck(path, ran, root=root, deadline_s=_DEADLINE)
    except CircuitError as error:
        return Row(name, 0.0, None, None, f"read ({told}); {error}; {origin}")
    theirs: Curves = (stands.axis, {n: v for n, v in stands.values.items() if "#" not in n and "@" not in n})
    compared: dict[str, Curves | None] = {"native": None if found.foreign else _native(found, ran)}
    compared["ngspice alone"] = None if program is None else _alone(program, path, ran)
    apart = {what: _apart(curves, theirs) for what, curves in compared.items() if curves is not None}
    says = ", ".join(f"{what} {100.0 * value:.3g} %" for what, value in apart.items()) or "nothing beside it"
    worst = max(apart.values(), default=0.0)
    ratio = worst if apart else None
    return Row(name, worst, float(stands.steps), ratio, f"{ran}; {told}; {says}; {origin}", most=AGREED)


def _asked(found: Imported) -> Ran:
    kinds = {type(a) for a in found.analyses}
    return "tran" if Transient in kinds else "dc" if Sweep in kinds else "op"


def _native(found: Imported, ran: Ran) -> Curves | None:
    """What the solver gives; None for a sweep, and where it refuses the circuit, which is said."""
    silicon = Silicon(temperature_c=27.0 if found.temperature_c is None else found.temperature_c)
    try:
        if ran == "op":
            volts = operating_point(found.testbench, silicon).voltages()
            return np.zeros(0), {original_name(n): np.array([v]) for n, v in volts.items()}
        if ran == "tran":
            result = simulate(found.testbench, silicon)
            return result.time, {original_name(n): result[n] for n in result.nodes}
    except CircuitError as error:
        print(f"native: {error}", file=sys.stderr)
    return None


def _alone(program: Path, path: Path, ran: Ran) -> Curves | None:
    """What ngspice makes of the file by itself, in its folder; None where it writes nothing."""
    with tempfile.TemporaryDirectory() as folder:
        raw = Path(folder) / "out.raw"
        command = [str(program), "-b", "-r", str(raw), path.name]
        try:
            subprocess.run(command, cwd=path.parent, capture_output=True, timeout=_DEADLINE, check=False)
        except subprocess.TimeoutExpired:
            return None
        return _read_raw(raw.read_bytes(), ran) if raw.is_file() else None


def _read_raw(data: bytes, ran: Ran) -> Curves | None:
    """The first plot of an analysis in a binary rawfile; None where there is none of real values."""
    head, _, rest = data.partition(b"Binary:\n")
    if not rest:
        return None
    lines = head.decode("latin-1").splitlines()
    fields = dict(line.split(":", 1) for line in lines if ":" in line and not line.startswith("\t"))
    count, points = int(fields["No. Variables"]), int(fields["No. Points"])
    kind = {"tran": "Transient", "dc": "DC transfer", "op": "Operating"}[ran]
    if not fields["Plotname"].strip().startswith(kind):
        width = 16 if "complex" in fields["Flags"] else 8
        return _read_raw(rest[width * count * points :], ran)
    names = [line.split()[1].lower() for line in lines if line.startswith("\t")][:count]
    table = np.frombuffer(rest[: 8 * count * points], np.float64).reshape(points, count)
    volts = {n[2:-1] if n.startswith("v(") else n: table[:, k] for k, n in enumerate(names)}
    return (table[:, 0], volts)


def _apart(one: Curves, other: Curves) -> float:
    """Largest rms difference of a node over its swing, on equally spaced points of the axis."""
    shared = [n for n in other[1] if n in one[1]]
    if not shared:
        return float("inf")
    worst = 0.0
    for node in shared:
        a, b = one[1][node], other[1][node]
        if other[0].size > 1 and (np.diff(other[0]) > 0.0).all() and (np.diff(one[0]) > 0.0).all():
            grid = np.linspace(other[0][0], min(one[0][-1], other[0][-1]), _POINTS)
            a, b = np.interp(grid, one[0], a), np.interp(grid, *((other[0], b)))
        if a.size != b.size:
            return float("inf")
        swing = max(float(b.max() - b.min()), float(np.abs(b).max()) if b.size == 1 else 0.0, 1e-3)
        worst = max(worst, float(np.sqrt(np.mean((a - b) ** 2))) / swing)
    return worst


if __name__ == "__main__":
    sys.exit(main())
