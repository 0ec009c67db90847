"""Claim: oscillators start by themselves and keep ngspice's period within 0.2 %, on every die.

An axon-hillock neuron driven by 200 pA, rings of 3, 5 and 7 inverters and a relaxation oscillator of two
inverters, R and C, in the process of 1.8 V and in that of 5 V, on the nominal die and on 20 others. They rest
where they are not stable; the solver begins 10 mV beside, and ngspice with the same node held there. Periods
are medians of the later half of the spikes; the solver's default rtol lets an edge's timing err by a share of
a microsecond, which is most for rings, whose periods are a few nanoseconds. ours, peer: the period on the
nominal die, s; ratio: the largest difference of the periods over the dies, in percent. Where one engine is
silent, or counts of spikes differ by more than one, the claim is missed.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from _report import Row, parser_of, report
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Device, Resistor, Source, Transistor
from circuits.devices.source import Constant
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from netlists.ngspice import engine

UM, PF = 1e-6, 1e-12
DRIVE = 200e-12  # A, into the axon-hillock neuron
ALLOWED = 0.2  # percent of the period
DIES, QUICK = 20, 1  # beside the nominal one
FIRST_DIE = 1000
PERIODS = 8  # of a run, about
POINTS = 800  # of ngspice, a period at least
RELTOL = 1e-5
CMOS_180: Process = load_block("rolls-neuron").process


@dataclass(frozen=True, slots=True)
class Oscillator:
    """A testbench with the event port `spike`, and about how long its period is, s."""

    testbench: Testbench
    process: Process
    period: float


def main() -> int:
    """Run both engines on all dies and print what came of it."""
    options = parser_of(__doc__, f"the nominal die and {QUICK} other").parse_args()
    numbers: list[int | None] = [None, *range(FIRST_DIE, FIRST_DIE + (QUICK if options.quick else DIES))]
    return report((compared(o, numbers) for o in oscillators()), options, figures)


def figures(row: Row) -> str:
    """Both periods, and how far they are apart."""
    return f"solver {row.ours:.5g} s, ngspice {row.peer:.5g} s, {row.ratio:.2g} % apart on the worst die"


def oscillators() -> list[Oscillator]:
    """All of them, at 1.8 V and at 5 V."""
    found = []
    for process in (CMOS_180, AMI_1500_IDEAL):
        fast = 2.6e-9 if process is CMOS_180 else 1.5e-9  # s, of a stage of a ring
        slow = 1.8e-3 if process is CMOS_180 else 4.9e-3
        found.append(Oscillator(axon_hillock(process, PERIODS * slow), process, slow))
        found += [Oscillator(ring(process, n, PERIODS * n * fast), process, n * fast) for n in (3, 5, 7)]
        found.append(Oscillator(relaxation(process, PERIODS * 2.5e-6), process, 2.5e-6))
    return found


def axon_hillock(process: Process, stop: float) -> Testbench:
    """Mead's neuron: a membrane, two inverters, feedback by a capacitor, a reset that `v_pw` limits."""
    devices = (
        Capacitor("cm", "v_mem", "0", 0.5 * PF),
        Capacitor("cf", "v_mem", "spike", 0.2 * PF),
        *_inverter(0, "v_mem", "y"),
        *_inverter(1, "y", "spike"),
        Transistor("mr", "n", "v_mem", "spike", "r", "0", 3 * UM, 1.5 * UM),
        Transistor("mb", "n", "r", "v_pw", "0", "0", 3 * UM, 1.5 * UM),
    )
    ports = (_VDD, _SPIKE, Port("v_mem", "analog"), Port("v_pw", "bias"))
    limit = Constant(0.4 if process is CMOS_180 else 0.6)
    sources = (Source("drive", "v_mem", Constant(DRIVE), "current"), Source("v_pw", "v_pw", limit))
    return _bench("axon-hillock", process, ports, devices, stop, sources)


def ring(process: Process, stages: int, stop: float) -> Testbench:
    """An odd number of inverters in a ring, 100 fF at each node."""
    nodes = ["spike", *(f"v{k}" for k in range(1, stages))]
    devices: list[Device] = [Capacitor(f"c{k}", node, "0", 0.1 * PF) for k, node in enumerate(nodes)]
    for k, node in enumerate(nodes):
        devices += _inverter(k, node, nodes[(k + 1) % stages])
    return _bench(f"ring of {stages}", process, (_VDD, _SPIKE), devices, stop)


def relaxation(process: Process, stop: float) -> Testbench:
    """Two inverters, the capacitor from the output to the input that R discharges."""
    devices = (
        *_inverter(0, "x", "y"),
        *_inverter(1, "y", "spike"),
        Resistor("r", "y", "x", 1e6),
        Capacitor("c", "spike", "x", 1 * PF),
    )
    return _bench("relaxation oscillator", process, (_VDD, _SPIKE), devices, stop)


def compared(oscillator: Oscillator, numbers: Iterable[int | None]) -> Row:
    """Both engines on the dies of these numbers, None the nominal one."""
    nominal, apart, counts = (math.nan, math.nan), 0.0, []
    for number in numbers:
        results = run(oscillator, Die(number=number))
        pair = period(results[0]), period(results[1])
        sizes = [result.spikes["spike"].size for result in results]
        close = abs(sizes[0] - sizes[1]) <= 1 and all(map(math.isfinite, pair))
        apart = max(apart, 100.0 * abs(pair[0] / pair[1] - 1.0) if close else math.inf)
        nominal = pair if number is None else nominal
        counts += sizes
    name = f"{oscillator.testbench.title}, {oscillator.process.v_dd:g} V"
    note = f"{min(counts)} to {max(counts)} spikes a run, {len(counts) // 2} dies"
    return Row(name, *nominal, apart, note, most=ALLOWED)


def run(oscillator: Oscillator, die: Die) -> tuple[Result, Result]:
    """The oscillator on a die, in the solver, and in ngspice within 0.02 % of its converged period."""
    silicon, bench = Silicon(oscillator.process, die=die), oscillator.testbench
    longest = oscillator.period / POINTS
    return simulate(bench, silicon), engine.simulate(bench, silicon, reltol=RELTOL, tmax=longest)


def period(result: Result) -> float:
    """Median distance (s) of spikes in the later half of them; not a number below four of them."""
    spikes = result.spikes["spike"]
    return float(np.median(np.diff(spikes[spikes.size // 2 :]))) if spikes.size > 3 else math.nan


_VDD, _SPIKE = Port("vdd", "supply"), Port("spike", "event", "out")


def _inverter(number: int, a: str, y: str) -> tuple[Device, ...]:
    return (
        Transistor(f"m{number}p", "p", y, a, "vdd", "vdd", 6 * UM, 1.5 * UM),
        Transistor(f"m{number}n", "n", y, a, "0", "0", 3 * UM, 1.5 * UM),
    )


def _bench(
    title: str,
    process: Process,
    ports: tuple[Port, ...],
    devices: Iterable[Device],
    stop: float,
    sources: tuple[Source, ...] = (),
) -> Testbench:
    circuit = Circuit(title.replace(" ", "_").replace("-", "_"), ports, tuple(devices))
    supply = Source("vdd", "vdd", Constant(process.v_dd))
    return Testbench(title, circuit, (supply, *sources), stop, ("spike",))


if __name__ == "__main__":
    sys.exit(main())
