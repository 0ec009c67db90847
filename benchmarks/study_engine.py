"""Claims: a study costs at most 1.2 times the bare batch, two workers 1.85 times less; its memory is flat.

The bare batch puts one lowered machine on every die and tunes it, on one thread; the study does the same dies
in chunks that are kept on disk, with statistics at the end. Two workers are two threads of one process.
Memory is the peak resident size of a process that runs a study of a quick metric, 100,000 samples by 1,000:
flat is at most 1.1 times as much (ours).
Values are compared bit by bit between all runs of the same dies.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from _report import Row, parser_of, report
from circuits.blocks.sonar import rebound_neuron, tuning
from circuits.lowering.kernel import Machine
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.solver.batch import map_dies
from system.options.silicon import SiliconChoice
from system.study.engine import on_threads, run_study
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.statistics.summary import summarise
from system.study.table import Condition, Table
from system.study.target import Subject

CLAIM_STUDY, CLAIM_WORKERS, CLAIM_MEMORY = 1.2, 1.85, 1.1
FIRST = 1000
HERE = "study_engine"


def threshold(machine: Machine) -> float:
    """A quick metric: the mean threshold of the die's transistors, V."""
    return float(machine.kernel.transistors.v_t0.mean())


def study(metric: str, count: int, chunk: int = 32) -> Study:
    """Dies with mismatch only."""
    subject = Subject("rebound-neuron", (metric,), silicon=SiliconChoice(process_variation=False))
    return Study(subject, Plan("random", 0, FIRST, count), (Condition("random", 27.0, 0),), chunk)


def timed_study(wanted: Study, threads: int) -> tuple[float, Table]:
    """Wall seconds of a study with its files and statistics, and its samples."""
    with tempfile.TemporaryDirectory() as folder, on_threads(threads) as workers:
        start = time.perf_counter()
        table = run_study(wanted, Path(folder) / "study", workers=workers).table
        summarise(table.values[:, 0], np.random.Generator(np.random.Philox(key=0)))
        return time.perf_counter() - start, table


def bare(count: int) -> tuple[float, list[float]]:
    """Wall seconds of the batch alone on one thread, and its best delays."""
    machine = tuning.tuning_machine(rebound_neuron.build(), Silicon(AMI_1500, die=Die(process=False)))
    dies = [Die(number=k, process=False) for k in range(FIRST, FIRST + count)]
    start = time.perf_counter()
    found = map_dies(tuning.tune, machine, dies, 1)
    seconds = time.perf_counter() - start
    return seconds, [np.nan if s.value is None else s.value.best_delay for s in found]


def peak(count: int) -> float:
    """Peak resident size of a process that runs a quick study of `count` dies, MB."""
    quick = f"b.study('{HERE}:threshold', {count}, 500)"
    code = f"import {HERE} as b; b.timed_study({quick}, 1); print(b.resident())"
    folder = Path(__file__).resolve().parent
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return float(done.stdout)


def resident() -> float:
    """Peak resident size of this process, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main() -> int:
    """Print the three rows."""
    options = parser_of(__doc__, "fewer dies").parse_args()
    count, many = (96, 20_000) if options.quick else (320, 100_000)
    timed_study(study("best_delay", 8), 1)  # compiles the kernels
    batch, expected = bare(count)
    one, table = timed_study(study("best_delay", count), 1)
    two, again = timed_study(study("best_delay", count), 2)
    same = np.array_equal(table.values[:, 0], expected, equal_nan=True) and np.array_equal(
        table.values, again.values, equal_nan=True
    )
    accuracy = "all values identical" if same else "VALUES DIFFER"
    few, most = peak(1000), peak(many)
    rows = [
        Row(f"study of {count} dies by the bare batch", one, batch, one / batch, accuracy, most=CLAIM_STUDY),
        Row("one worker by two", two, one, one / two, accuracy, 2, CLAIM_WORKERS),
        Row(f"memory, {many} samples by 1,000, MB", most, few, most / few, accuracy, most=CLAIM_MEMORY),
    ]
    return report(rows, options, lambda r: f"{r.ours:9.3f} against {r.peer:9.3f}: {r.ratio:.3f}")


if __name__ == "__main__":
    sys.exit(main())
