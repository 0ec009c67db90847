"""Claim: gradients of a metric by all devices take at most 3 runs, and are within 1 % of central differences.

The first spike of each block that spikes, else a port's voltage at 70 % of the run, on the nominal die and
dies 1000 to 1002. `ours` is the CPU time of the gradients, their run included, `peer` that of the run alone
at the same tolerance, best of three. The accuracy is the largest difference to a central difference at rtol
1e-9, times the sigma of what is moved, in the metric's sigma over dies: of the two devices that move it most
and of three others. The energy of the supply reads every step, and is claimed at 3 runs too, and ten metrics
at once are at 12. Of the search for the best delay `ours` is what its gradient takes beyond the search, and
`peer` a run at each of its edges, of which it takes at most 3 each.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from _report import Row, best_of, parser_of, report
from circuits.blocks.block import Block
from circuits.blocks.sonar.tuning import tuning_machine
from circuits.blocks.sonar.tuning_metrics import BEST_DELAY
from circuits.gradient.every import Searched, gradients_of_search
from circuits.gradient.gradient import GRADIENT_RTOL, Gradients, gradients_of
from circuits.gradient.measure import Current, Energy, Extreme, Integral, Measure, SpikeTime, Voltage
from circuits.lowering.kernel import Machine, to_kernel
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.circuits.gradient.differences import by_deviation

DIES = (None, 1000, 1001, 1002)
STEP = 0.01  # sigma, of a central difference
LEAST = 1e-9  # of the metric, below which its spread over dies is rounding
CLAIMED = {"rebound-neuron"}  # 34 transistors


def main() -> int:
    """Measure and print a row a block and die."""
    options = parser_of(__doc__, "two blocks on the nominal die").parse_args()
    names = ("rebound-neuron", "winner-take-all") if options.quick else block_names()
    return report(rows(names, DIES[:1] if options.quick else DIES), options)


def rows(names: tuple[str, ...] | list[str], dies: tuple[int | None, ...]) -> Iterator[Row]:
    """A row a block and die."""
    for name in names:
        block = load_block(name)
        for number in dies:
            machine = to_kernel(block.bench(), Silicon(block.process, 27.0, Die(number=number)))
            measure = measure_of(block, machine)
            if measure is None:
                continue
            found = gradients_of(machine, (measure,))
            ours = best_of(lambda m=machine, of=measure: gradients_of(m, (of,)))
            peer = best_of(lambda m=machine: simulate(m, rtol=GRADIENT_RTOL))
            label = f"{name}, die {'nominal' if number is None else number}, {measure.name}"
            most = 3.0 if name in CLAIMED else float("inf")
            yield Row(label, ours, peer, ours / peer, accuracy(machine, measure, found), most=most)
            if name in CLAIMED:
                die = label.split(", spike", maxsplit=1)[0]
                yield energy(die, machine, peer)
                yield ten(die, machine, measure, peer)
                yield edges(die, machine)


def energy(label: str, machine: Machine, peer: float) -> Row:
    """What the supply delivers."""
    measure = Energy("vdd")
    ours = best_of(lambda: gradients_of(machine, (measure,)))
    told = accuracy(machine, measure, gradients_of(machine, (measure,)))
    return Row(f"{label}, {measure.name}", ours, peer, ours / peer, told, most=3.0)


def ten(label: str, machine: Machine, first: Measure, peer: float) -> Row:
    """A spike, and voltages and currents at a time, their extremes and integrals."""
    node, late, early = "v_mem", *(share * machine.testbench.stop for share in (0.7, 0.3))
    measures = (
        first, Energy("vdd"), Voltage(node, late), Voltage(node, early), Extreme(node),
        Extreme(node, highest=False), Integral(node), Integral("i(vdd)"), Current("vdd", late),
        Extreme("i(vdd)"),
    )  # fmt: skip
    ours = best_of(lambda: gradients_of(machine, measures))
    return Row(f"{label}, ten metrics", ours, peer, ours / peer, "values of one run", most=12.0)


def edges(label: str, machine: Machine) -> Row:
    """The best delay, on the die of a machine."""
    searched = Searched(BEST_DELAY, tuning_machine(machine.testbench.circuit, machine.silicon))
    found = BEST_DELAY.edges(searched.machine, BEST_DELAY.measure(searched.machine))
    name = f"{label}, best_delay, an edge"
    if not found:
        return Row(name, 0.0, None, None, "the neuron has no interval, and so no edge")
    search = best_of(lambda: BEST_DELAY.measure(searched.machine))
    ours = best_of(lambda: gradients_of_search(searched)) - search
    peer = sum(best_of(lambda e=e: simulate(e.beside(e.resolution), rtol=GRADIENT_RTOL)) for e in found)
    return Row(name, ours, peer, ours / peer, f"beyond a search of {search:.3g} s", most=3.0)


def measure_of(block: Block, machine: Machine) -> Measure | None:
    """The first spike, or the voltage of a port that the circuit drives; None where there is none."""
    result = simulate(machine)
    spiking = [port for port, times in result.spikes.items() if times.size]
    if spiking:
        return SpikeTime(spiking[0])
    ports = [p.elements()[0] for p in machine.testbench.circuit.ports if p.kind in ("analog", "event")]
    free = [node for node in ports if machine.column_of(node) < machine.kernel.unknowns]
    return Voltage(free[0], 0.7 * block.bench().stop) if free else None


def accuracy(machine: Machine, measure: Measure, found: Gradients) -> str:
    """The largest difference to a central difference, in words."""
    moved, total = np.abs(found.by[0] * found.sigma), float(found.spread[0])
    own = [k for k in np.argsort(-moved) if moved[k] > 0.0 and "process" not in found.labels[k]]
    if not total > LEAST * abs(float(found.values[0])) or len(own) < 2:
        return "nothing of it varies over dies"
    worst, where = 0.0, ""
    for k in dict.fromkeys([*own[:2], *(own[len(own) * q // 4] for q in (1, 2, 3))]):
        other = by_deviation(machine, measure, found.labels[k], STEP * found.sigma[k])
        off = abs(other - found.by[0, k]) * found.sigma[k] / total
        if not off < worst:
            worst, where = off, found.labels[k]
    return (
        f"off by {100.0 * worst:.2g} % of the metric's sigma at most, {where}; {found.notes[0] or 'smooth'}"
    )


if __name__ == "__main__":
    sys.exit(main())
