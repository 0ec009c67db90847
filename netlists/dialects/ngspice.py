"""The ngspice dialect, which is also what the engine `ngspice` runs.

Each definition is a `.subckt`. Transistors are B sources with the EKV law, its constants folded into numbers,
or M elements with BSIM3 cards, or calls of sub-circuits that follow temperature and size
(`netlists.dialects.sweepable`).

Names. ngspice ignores case, and a node array has no form of its own: `v_mem[3]` is written `v_mem#3`,
`w[1,2]` is `w#1#2`. Our names have no `#`, so nothing collides. Names that
ngspice gives a meaning wherever they stand (`gnd`, `time`, `limit`, ...) get a `#` at the end. An instance
`neuron[2]` is `xneuron#2` and a device `mi5` is `bmi5` or `rmi5`, its capacitances `cmi5#gb` and so on.
Node `neuron[2].v_r` of circuit `chip` is known to a run as `xchip.xneuron#2.v_r`, ports of the chip by their
name alone.

Time. `.tran` stores every accepted point; the largest step is a 2000th of the run unless given. Defaults
(gear, reltol 1e-5, trtol 1, gmin 1e-15) put a rebound neuron's spike within 0.2 us of the converged time;
ngspice's own are 200 us off.
"""

from __future__ import annotations

from collections.abc import Iterable

from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.dialects.spice import (
    Syntax,
    analysis_card,
    make_writer,
    mos_form,
    spice_dialect,
    tolerances,
)
from netlists.dialects.sweepable import CELLS, sweepable
from netlists.naming import make_naming
from netlists.registry import DEFAULT_RELTOL, Analysis, Method, Settings
from netlists.write import deck
from netlists.write.deck import Control, wrap
from netlists.write.traversal import Definition

PRINTED = 6  # nodes of a deck that `ngspice -b` prints, which runs nothing for a deck that prints nothing
# gnd is ground; time is the axis of a run; the others crash ngspice's parser inside v(...)
_RESERVED = frozenset({"gnd", "time", "temper", "hertz", "limit", "agauss", "aunif", "gauss", "unif"})


def _current(name: str, start: str, end: str, expression: str) -> list[str]:
    return [f"b{name} {start} {end} i={expression}"]


def _iterations(models: str) -> str:
    """Options of how many iterations an operating point of equations may take, at once and in steps of gmin.

    ngspice's usual 100 and 50 were not enough for the rebound neuron at 27 degC; ours.
    """
    return "" if models == "bsim3" else " itl1=500 itl2=500"


def _control(control: Control) -> list[str]:
    temperature, step, models = repr(control.silicon.temperature_c), repr(control.step), control.models
    way = f"trtol=1.0 reltol={control.reltol!r} method={control.method}"
    return [
        f".options temp={temperature} tnom={temperature}",
        f".options {tolerances(models)}{_iterations(models)} {way}",
        *wrap([".save", *(f"v({name})" for name in control.saved)]),
        *wrap([f".print {control.analysis}", *(f"v({name})" for name in control.saved[:PRINTED])]),
        analysis_card(control, "0", step),
    ]


_NAMING = make_naming("hash", _RESERVED | frozenset(CELLS.values()))
_SYNTAX = Syntax("ngspice", _NAMING, _current, _control, runs=True, case=str.lower)
_WRITER = make_writer(_SYNTAX)

DIALECT = spice_dialect(
    _SYNTAX,
    "B sources or BSIM3; run here",
    mos_form(_NAMING, "level=8", "version=3.3.0", instance=True),
    {"sweepable": sweepable(_SYNTAX)},
)
format_device = DIALECT.devices["ekv"]
node_name = _NAMING.node


def format_testbench(
    testbench: Testbench,
    silicon: Silicon,
    title: str | None = None,
    *,
    analysis: Analysis = "tran",
    reltol: float = DEFAULT_RELTOL,
    tmax: float | None = None,
    method: Method = "gear",
    nodes: Iterable[str] | None = None,
) -> str:
    """Complete deck of a testbench, the same text for the same input.

    Parameters
    ----------
    testbench
        Circuit, sources and stop time; `start` becomes `.nodeset`, what it begins with `.ic` and `uic`.
    silicon
        Process and temperature; every law is applied here, the deck has literal numbers only.
    title
        What the first line begins with; the testbench's title by default. Die and temperature follow.
    analysis
        `tran` up to the stop time, or `op` with the sources as they are at time 0.
    reltol, method
        ngspice's options.
    tmax
        Largest step, s; a 2000th of the stop time by default.
    nodes
        Paths of the nodes to save; all by default.

    Raises
    ------
    TopologyError
        Two names of one circuit, or of two sources, differ in case only.
    """
    return DIALECT.write(testbench, silicon, Settings("ekv", analysis, reltol, tmax, method, nodes), title)


def run_name(path: str, top: Definition) -> str:
    """Name, in lower case, by which a run of circuit `top` knows the node at `path`."""
    return deck.run_name(_WRITER, path, top)
