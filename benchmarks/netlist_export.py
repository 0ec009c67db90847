"""Claim: 1,000 neurons are written as a netlist within 5 s, nominal and on one die.

The circuit is one InstanceArray of 1,000 rebound neurons with shared call, echo and biases and a pair of
I_inh_tau and I_ex_tau of its own each, as on the ranging chip. The nominal netlist calls one definition 1,000
times; a die's has every transistor's own numbers. ngspice's dialect, from the circuit to the text, which is
all computation on one thread: judged by process CPU time, which other work on the machine does not stretch,
with the wall time beside it; medians of a few turns.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from statistics import median

import numpy as np

from _report import Row, parser_of, report
from chips.ranging import circuit as ranging_chip
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, InstanceArray
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_testbench

ALLOWED = 5.0  # s
NEURONS = 1000
STIMULI: Mapping[str, float | None] = {"delay": 6.4e-3, "call": 1.0, "echo": 1.0, "duration": None}


def main() -> int:
    """Time both exports and print the rows; 1 where one takes longer than allowed."""
    options = parser_of(__doc__, "one turn of each").parse_args()
    turns = 1 if options.quick else 5
    bench = testbench()
    rows = [
        row("nominal", bench, Silicon(AMI_1500_IDEAL), turns),
        row("die A/1003", bench, Silicon(AMI_1500_IDEAL, die=Die("A", 1003)), turns),
    ]
    return report(rows, options, lambda r: f"{r.ours:6.3f} s of CPU, {r.peer:g} s allowed")


def testbench() -> Testbench:
    """A call and an echo to all neurons."""
    return rebound_neuron.testbench(chip(NEURONS), STIMULI, Silicon(AMI_1500_IDEAL).process.v_dd)


def chip(count: int) -> Circuit:
    """The ranging chip with `count` neurons, its currents interpolated between its own thirteen."""
    plain = ranging_chip.build()
    where = np.linspace(0.0, ranging_chip.NEURONS - 1.0, count)

    def stretched(values: float | tuple[float, ...]) -> float | tuple[float, ...]:
        if not isinstance(values, tuple):
            return values
        return tuple(np.interp(where, np.arange(len(values)), values).tolist())

    return replace(
        plain,
        ports=tuple(replace(p, shape=(count,)) if p.shape else p for p in plain.ports),
        instances=(
            InstanceArray("neuron", rebound_neuron.build(), (count,), plain.instances[0].connections),
        ),
        biases=tuple(replace(b, value=stretched(b.value)) for b in plain.biases),
    )


def row(name: str, bench: Testbench, silicon: Silicon, turns: int) -> Row:
    """Median time of an export, and how long its text is."""
    wall, cpu, texts = [], [], set[str]()
    for _ in range(turns):
        start, spent = time.perf_counter(), time.process_time()
        texts.add(format_testbench(bench, silicon))
        wall.append(time.perf_counter() - start)
        cpu.append(time.process_time() - spent)
    text, seconds = max(texts), median(cpu)
    accuracy = f"{text.count(chr(10)):,} lines, {len(text) / 1e6:.1f} MB, wall time {median(wall):.2f} s"
    if len(texts) > 1:
        raise SystemExit(f"{name}: the same circuit gave {len(texts)} texts")
    return Row(f"{NEURONS} neurons, {name}", seconds, ALLOWED, ALLOWED / seconds, accuracy, least=1.0)


if __name__ == "__main__":
    sys.exit(main())
