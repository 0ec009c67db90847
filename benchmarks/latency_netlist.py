"""Claim: parts cut out of the latency chip's netlist spike in ngspice as in the solver, within 1e-4.

The chip on a die, two memories of two units, is written as ngspice's text. By path, a tap of the delay line,
a unit of a memory and a cell of the first layer are cut out of it: their definitions and those below, as they
stand there, and the voltages of the chip's sources at their bias ports. With events of their own they run in
ngspice; the solver runs the same part at its place on the same die. Compared is the time of the part's event
(ours: the solver's, s; peer: ngspice's; ratio: their relative difference). Sources, nodes' names and a start
near the state of rest are those of the part's own deck, whose definitions the cut ones replace.

Returns 1 where the claim is missed.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from _report import Row, parser_of, report
from chips.latency.chip import LatencyChip
from chips.latency.circuit import CHIP, TIMER, Params, build, design_of
from chips.latency.design import REACH
from chips.latency.place import bench_at, standing
from circuits.blocks.latency import unit as latency_unit
from circuits.blocks.latency.parts import racing_cell
from circuits.blocks.latency.tap import delay_tap
from circuits.circuit import Circuit
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_testbench
from netlists.ngspice import engine
from netlists.ngspice import run as ngspice
from netlists.ngspice.agreement import SOLVER_RTOL
from netlists.ngspice.form import started

PARAMS = Params(paths=2, taps=2)
DIE = Die(number=1003)
RELATIVE = 1e-4
RELTOL, STEPS = 1e-4, 2000  # of ngspice
START = 20e-6  # s, of the first event
Place = tuple[tuple[str, tuple[int, ...]], ...]


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the chip: place, circuit, events by port (s), end (s), and the port that is watched."""

    place: Place
    circuit: Circuit
    events: Mapping[str, Sequence[float]]
    stop: float
    watch: str


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "the tap alone").parse_args()
    silicon = Silicon(AMI_1500_IDEAL, die=DIE)
    chip = LatencyChip(design_of(PARAMS), silicon=silicon)
    parts = list(parts_of(chip))[: 1 if options.quick else None]
    lines = exported(silicon)
    rows = [compared(part, lines, silicon) for part in parts]
    return report(rows, options, figures)


def figures(row: Row) -> str:
    """Both times."""
    return f"{row.ours:.6g} s, ngspice {row.peer:.6g} s, {row.ratio:.2g} apart"


def parts_of(chip: LatencyChip) -> Iterator[Part]:
    """A tap, a unit whose INH has spiked before the tap, and a cell with a charge and an inhibition."""
    c = chip.lumped
    yield Part((("tap", (1,)),), delay_tap(TIMER), {"event": [START]}, 1.2 * float(c.tap[1]), "out")
    at, lag = START + 1.3 * float(c.tonic[1, 0]), 0.5 * float(c.window[1, 0, 0])
    events = {"reset": [START], "tap": [at], "integrating": [at + lag]}
    place: Place = (("memory", (1,)), ("unit", (0,)))
    yield Part(place, latency_unit.build(), events, at + 1.1 * lag, "spike")
    alone = float(c.race[1] / c.passive[1])
    inhibited = f"inhibit[{REACH + 2}]"  # two memories away: the own one's would silence the cell on this die
    events = {"reset": [START], "goal": [START + 0.1 * alone], inhibited: [START + 0.6 * alone]}
    yield Part((("first", (1,)),), racing_cell(REACH), events, 1.15 * alone, "spike")


def exported(silicon: Silicon) -> list[str]:
    """Cards of the chip's netlist, lines that go on joined."""
    stimuli = CHIP.defaults
    bench = CHIP.testbench(build(PARAMS), stimuli, silicon.process.v_dd)
    return cards(format_testbench(bench, silicon))


def cards(text: str) -> list[str]:
    """Cards of a deck without comments, lines that go on joined."""
    return [x for x in text.replace("\n+", " ").splitlines() if not x.startswith("*%")]


def compared(part: Part, lines: Sequence[str], silicon: Silicon) -> Row:
    """The part in both engines."""
    placed = standing(silicon, *part.place)
    body, ports, name = cut(lines, part.place)
    volts = sources_of(lines)
    biases = {p: volts[net] for p, net in ports.items() if p in _bias_ports(part.circuit)}
    v_dd = silicon.process.v_dd
    title = part.circuit.name
    bench = bench_at(title, part.circuit, biases, part.events, part.stop, v_dd, (part.watch,))
    start = time.process_time()
    solved = simulate(bench, placed, rtol=SOLVER_RTOL)
    ours = time.process_time() - start
    deck = grafted(started(bench, placed), placed, body, name)
    start = time.process_time()
    waves = ngspice.run(deck)
    peer = time.process_time() - start
    node = engine.node_names(bench, placed)[part.watch]
    theirs = engine.upward_crossings(waves.axis, waves.values[node], 0.5 * v_dd)
    mine = solved.spikes[part.watch]
    path = "/".join(f"{p}[{k[0]}]" for p, k in part.place)
    apart = abs(theirs[0] / mine[0] - 1.0) if mine.size == theirs.size == 1 else float("inf")
    note = f"{mine.size} and {theirs.size} events; {DIE}; CPU {ours:.2f} s, ngspice {peer:.1f} s"
    at = [float(x[0]) if x.size else float("nan") for x in (mine, theirs)]
    return Row(path, at[0], at[1], apart, note, most=RELATIVE)


def cut(lines: Sequence[str], place: Place) -> tuple[list[str], dict[str, str], str]:
    """Definitions of the part at a place; the chip's net of each of its ports; the name of its definition."""
    definitions = _definitions(lines)
    top = next(x.split() for x in lines if x.startswith("xlatency_chip "))
    name, nets = top[-1], {net: net for net in top[1:-1]}
    for part, index in place:
        call = f"x{part}{''.join(f'#{k}' for k in index)} "
        _, *actual, below = next(x.split() for x in definitions[name] if x.startswith(call))
        formal = definitions[below][0].split()[2:]
        nets = {f: nets.get(a, a) for f, a in zip(formal, actual, strict=True)}
        name = below
    ports = {re.sub(r"#(\d+)", r"[\1]", f): net for f, net in nets.items()}
    return [x for needed in _needed(definitions, name) for x in definitions[needed]], ports, name


def _definitions(lines: Sequence[str]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    name = None
    for line in lines:
        if line.startswith(".subckt "):
            name = line.split()[1]
            found[name] = []
        if name is not None:
            found[name].append(line)
        if line.startswith(".ends"):
            name = None
    return found


def _needed(definitions: Mapping[str, Sequence[str]], name: str) -> list[str]:
    """Names of a definition and all below, in the order in which they are to be written."""
    found: list[str] = []
    for line in definitions[name]:
        if line.startswith("x"):
            found += [n for n in _needed(definitions, line.split()[-1]) if n not in found]
    return [*found, name]


def sources_of(lines: Sequence[str]) -> dict[str, float]:
    """Voltage of each net that a source of the chip's deck holds, V."""
    return {x.split()[1]: float(x.split()[4]) for x in lines if x.startswith("v") and len(x.split()) >= 5}


def _bias_ports(circuit: Circuit) -> set[str]:
    return {name for port in circuit.ports if port.kind == "bias" for name in port.elements()}


def grafted(bench: Testbench, silicon: Silicon, body: Sequence[str], name: str) -> str:
    """The part's own deck with the chip's definitions in place of its own."""
    text = cards(format_testbench(bench, silicon, reltol=RELTOL, tmax=bench.stop / STEPS))
    own = {x for definition in _definitions(text).values() for x in definition}
    kept = [x for x in text[1:] if x not in own]
    call = f"x{bench.circuit.name} "
    kept = [f"{x.rsplit(' ', 1)[0]} {name}" if x.startswith(call) else x for x in kept]
    return "\n".join([text[0], *body, *kept]) + "\n"


if __name__ == "__main__":
    sys.exit(main())
