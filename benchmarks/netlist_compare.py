"""Claim: netlists of a 13-neuron chip compare in seconds, and of 1,000 neurons on a die in less than 30 s.

Both are exported for ngspice and for HSPICE on one die and read again; the two circuits with all deviations
are then compared, and the first once more with one transistor changed, which must be found.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace

from _report import Row, parser_of, report
from chips.registry import load_chip
from circuits.circuit import Circuit, InstanceArray, Node
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Deviation, Silicon
from circuits.testbench import Testbench
from netlists.compare.circuits import compare
from netlists.read import Imported, read_netlist
from netlists.registry import Settings, load_dialect

NEURONS, QUICK_NEURONS = 1000, 100
LIMITS = {"13 neurons": 5.0, "array": 30.0}  # s


def chip() -> Testbench:
    """The ranging chip with its testbench."""
    block = load_chip("ranging-chip")
    return block.bench()


def array(count: int) -> Testbench:
    """Rebound neurons that share their inputs; what each puts out is a node of its own."""
    block = load_block("rebound-neuron")
    neuron = block.build()
    bench = block.testbench(neuron, block.defaults, 5.0)
    ports = {p.name: p.name for p in neuron.ports}
    circuit = Circuit(
        "array",
        tuple(p for p in neuron.ports if p.direction == "in"),
        (),
        (InstanceArray("neuron", neuron, (count,), ports),),
        tuple(Node(p.name, (count,)) for p in neuron.ports if p.direction == "out"),
        tuple(replace(b, device=f"neuron.{b.device}" if b.device else None) for b in neuron.biases),
    )
    return Testbench("array", circuit, bench.sources, bench.stop)


def read_again(bench: Testbench, dialect: str) -> tuple[Imported, float]:
    """Export on die 1003 and import; the seconds are those of the import."""
    text = load_dialect(dialect).write(bench, Silicon(AMI_1500_IDEAL, die=Die(number=1003)), Settings())
    start = time.perf_counter()
    return read_netlist(text), time.perf_counter() - start


def measure(name: str, bench: Testbench, limit: float) -> list[Row]:
    """Rows of one circuit: import, and comparison."""
    (a, reading), (b, _) = read_again(bench, "ngspice"), read_again(bench, "hspice")
    start = time.perf_counter()
    same = compare(a.circuit, b.circuit, deviations=(a.deviations, b.deviations))
    seconds = time.perf_counter() - start
    path = sorted(a.deviations)[len(a.deviations) // 2]
    moved = {**a.deviations, path: Deviation(a.deviations[path].v_t0 + 1e-6, a.deviations[path].beta)}
    other = compare(a.circuit, b.circuit, deviations=(moved, b.deviations))
    if not same.equal or [d.path for d in other.differences] != [path]:
        raise SystemExit(f"{name}: equal {same.equal}, found {other.differences} where {path} was changed")
    told = f"equal, and 1 uV in {path} found among {same.devices[0]} devices"
    return [
        Row(f"compare {name}", seconds, limit, limit / seconds, told, least=1.0),
        Row(f"import {name}", reading, None, None, "-"),
    ]


def main() -> int:
    """Measure both circuits and print the rows."""
    options = parser_of(__doc__, f"{QUICK_NEURONS} neurons instead of {NEURONS}").parse_args()
    count = QUICK_NEURONS if options.quick else NEURONS
    rows = measure("13 neurons", chip(), LIMITS["13 neurons"])
    rows += measure(f"{count} neurons", array(count), LIMITS["array"])
    return report(rows, options, figures)


def figures(row: Row) -> str:
    """The time, and what is allowed."""
    return f"{row.ours:7.3f} s" + ("" if row.peer is None else f" of {row.peer} s allowed")


if __name__ == "__main__":
    sys.exit(main())
