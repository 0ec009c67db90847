"""A script of the bench, run: what was set and what was read, a column each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from chips.coach.bench import CoachBench
from chips.coach.identified import Found
from circuits.arrays import F64
from circuits.silicon.silicon import Silicon
from system.bench.script import Record, Script, Sweep


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """What a script has measured.

    Attributes
    ----------
    set_columns : tuple of str
        Names of what was set, in the order of the table; of a record the time alone.
    columns : dict of str to array
        float64[rows] by name: what was set, as the DAC made it (V) or as a code, then what was read. A name
        ends with its unit, `_V`, `_A`, `_s`, `_counts` or `_code`.
    found : Found or None
        What the bench took of an identified chip; None of a nominal bench.
    """

    set_columns: tuple[str, ...]
    columns: dict[str, F64]
    found: Found | None = None


def bench_of(script: Script, silicon: Silicon, seed: int, identified: Path | None = None) -> CoachBench:
    """The bench with the circuit, biases and voltages of a script.

    Parameters
    ----------
    script
        What is set.
    silicon
        Process, temperature and die.
    seed
        Keys what differs from one reading to the next.
    identified
        File of an identified die, whose process numbers, generator and board are taken.
    """
    bench = CoachBench(silicon, seed=seed, identified=identified)
    bench.select(script.circuit)
    bench.set_range(script.range)
    for name, code in script.biases.items():
        bench.set_bias(name, code.kind, code.master, code.fine)
    for pin, volt in script.voltages.items():
        bench.set_voltage(pin, volt)
    return bench


def run_script(
    script: Script,
    silicon: Silicon,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    identified: Path | None = None,
) -> Table:
    """Run a script.

    Parameters
    ----------
    script, silicon, seed, identified
        As `bench_of` has them; the script says what is read too.
    progress
        Is told the share that is done.
    """
    bench, act = bench_of(script, silicon, seed, identified), script.act
    if isinstance(act, Record):
        return _recorded(bench, script, act)
    return _swept(bench, script, act, progress)


def _swept(
    bench: CoachBench, script: Script, sweep: Sweep, progress: Callable[[float], None] | None
) -> Table:
    rows: list[list[float]] = []
    count = len(next(iter(sweep.over.values())))
    for k in range(count):
        made = [_set(bench, script, name, float(values[k])) for name, values in sweep.over.items()]
        rows.append([*made, *(_reading(bench, script, pin) for pin in script.read)])
        if progress is not None:
            progress((k + 1) / count)
    lines = script.wiring.lines
    set_names = [f"{name}_{'code' if name in lines else 'V'}" for name in sweep.over]
    names = [*set_names, *(column_of(script, pin) for pin in script.read)]
    table = np.array(rows, dtype=np.float64).T
    return Table(tuple(set_names), dict(zip(names, table, strict=True)), bench.found)


def _set(bench: CoachBench, script: Script, name: str, value: float) -> float:
    """Set a pin or a bias's fine code; what it became."""
    if name not in script.wiring.lines:
        return bench.set_voltage(name, value)
    code = script.biases[name]
    bench.set_bias(name, code.kind, code.master, int(value))
    return value


def _reading(bench: CoachBench, script: Script, pin: str) -> float:
    if pin in script.wiring.outputs:
        return bench.read_voltage(pin)
    if pin in script.wiring.ammeters:
        return bench.read_current(pin)
    return float(bench.read_counts(pin, script.counting_time))


def _recorded(bench: CoachBench, script: Script, act: Record) -> Table:
    record = bench.record(
        script.read, act.samples, act.interval, steps=act.steps, events=act.events, fast=act.fast
    )
    read = {column_of(script, pin): record.values[pin] for pin in script.read}
    return Table(("time_s",), {"time_s": record.time, **read}, bench.found)


def column_of(script: Script, pin: str) -> str:
    """Name of the column of a pin that is read, with its unit; pin: a name of the script's `read`."""
    if pin in script.wiring.outputs:
        return f"{pin}_V"
    return f"{pin}_A" if pin in script.wiring.ammeters else f"{pin}_counts"
