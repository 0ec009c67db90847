"""Claim: 1,000 rebound neurons in one array are exported within 5 s, in every dialect and with every model.

Nominal, where all share one definition of each circuit, and on a die, where every neuron has its own: 34,000
transistors, each with its deviation. CPU seconds of one process, the circuit already built.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass, replace

from circuits.blocks import rebound_neuron
from circuits.circuit import Circuit, InstanceArray
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.die import NOMINAL, Die
from circuits.silicon import Silicon
from circuits.testbench import Testbench
from netlists.dialect import Settings, dialect_names, load_dialect

NEURONS = 1000
ALLOWED = 5.0  # s
OUTPUTS = frozenset({"v_mem", "spike"})  # one a neuron, other ports are shared


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table: CPU s of the export beside what is allowed."""

    name: str
    ours: float
    peer: float
    ratio: float
    accuracy: str
    cores: int


def bank(count: int) -> Testbench:
    """Neurons that share supply, events and biases."""
    cell = rebound_neuron.build()
    ports = tuple(replace(p, shape=(count,)) if p.name in OUTPUTS else p for p in cell.ports)
    neurons = InstanceArray("neuron", cell, (count,), {p.name: p.name for p in ports})
    biases = tuple(replace(b, device=b.device and f"neuron.{b.device}") for b in cell.biases)
    levels = {"vdd": 5.0, "call": 0.0, "echo": 0.0}
    sources = tuple(Source(name, name, Constant(level)) for name, level in levels.items())
    return Testbench("bank", Circuit("bank", ports, (), (neurons,), (), biases), sources, 1e-3)


def measure(bench: Testbench, dialect: str, models: str, die: Die) -> Row:
    """Time one export."""
    silicon, settings = Silicon(die=die), Settings(models)
    write = load_dialect(dialect).write
    write(bank(2), silicon, settings)  # kernels of the draws compile once
    start = time.process_time()
    text = write(bench, silicon, settings)
    seconds = time.process_time() - start
    size = f"{text.count(chr(10)):,} lines"
    return Row(f"{dialect} {models}, {die}", seconds, ALLOWED, ALLOWED / seconds, size, 1)


def main() -> None:
    """Print a row a dialect, model and die."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="the same: it takes half a minute")
    options = parser.parse_args()
    bench = bank(NEURONS)
    rows = [
        measure(bench, dialect, models, die)
        for dialect in dialect_names()
        for models in load_dialect(dialect).devices
        for die in (NOMINAL, Die("A", 1003))
    ]
    if options.json:
        print(json.dumps([{k: getattr(row, k) for k in Row.__slots__} for row in rows], indent=2))
        return
    for row in rows:
        print(f"{row.name:32} {row.ours:6.2f} s of {row.peer:.0f} s allowed, {row.accuracy}")


if __name__ == "__main__":
    main()
