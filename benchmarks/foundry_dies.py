"""A thousand dies of a neuron on a foundry's cards in ngspice, failures counted, beside our law's.

Dies A/1000 on of the tonic neuron, which nothing inhibits for 60 ms, on gf180mcu's cards at 27 degC, with the
foundry's own mismatch and process (`noctule montecarlo tonic-neuron --process gf180mcu --engine ngspice`).
Beside them are the same dies by our law fitted to these cards, in the solver. Devices' own draws have the
same keys there, what a die shares does not, so that distributions are compared and not dies. Rows: median and
quartiles' distance of the period, s; dies that fire; dies that failed, with the reasons; seconds a die.
"""

from __future__ import annotations

import sys
import time
from collections import Counter

import numpy as np

from _report import Row, parser_of, report
from circuits.arrays import F64
from system.options.silicon import SiliconChoice
from system.study.engine import on_threads, run_study
from system.study.in_ngspice import Engine
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.table import FAILED, Condition, Table
from system.study.target import Subject

DIES, FEW, FIRST = 1000, 10, 1000
STIMULI = ("inhibit=off", "duration=60ms")


def study_of(engine: Engine, dies: int) -> Study:
    """The study of the neuron by an engine."""
    silicon = SiliconChoice(process="gf180mcu")
    subject = Subject("tonic-neuron", ("period_s",), stimuli=STIMULI, silicon=silicon, engine=engine)
    return Study(subject, Plan("random", 0, FIRST, dies), (Condition("random", 27.0, 0),), 16)


def measured(engine: Engine, dies: int) -> tuple[Table, float]:
    """Samples of an engine, and the seconds that a die took on one thread."""
    start = time.perf_counter()
    with on_threads(1) as workers:
        found = run_study(study_of(engine, dies), workers=workers)
    return found.table, (time.perf_counter() - start) / dies


def main() -> int:
    """Measure the dies in both engines and print the rows."""
    parser = parser_of(__doc__, f"{FEW} dies")
    options = parser.parse_args()
    dies = FEW if options.quick else DIES
    (cards, seconds), (law, seconds_law) = (measured(engine, dies) for engine in ("ngspice", "native"))
    reasons = Counter(reason for reason in cards.reason if reason)
    failed = sum(outcome == FAILED for outcome in cards.outcome)
    told = "; ".join(f"{count}: {reason}" for reason, count in reasons.most_common(3)) or "none failed"
    on, ours = (_defined(table) for table in (cards, law))
    note = f"{dies} dies, our law in the solver beside the cards in ngspice"
    rows = [
        compared("median of the period (s)", np.median(ours), np.median(on), note),
        compared("quartiles of the period apart (s)", _spread(ours), _spread(on), note),
        compared("dies that fire", float(ours.size), float(on.size), note),
        Row("dies that failed in ngspice", float(failed), None, None, told),
        compared("seconds a die", seconds_law, seconds, "one thread"),
    ]
    return report(rows, options, figures)


def compared(name: str, ours: float, peer: float, accuracy: str) -> Row:
    """Row of our law beside the cards."""
    return Row(name, float(ours), float(peer), float(ours / peer), accuracy)


def figures(row: Row) -> str:
    """Our law's figure and the cards'."""
    return f"law {row.ours:10.4g}  cards {'-' if row.peer is None else f'{row.peer:.4g}':>10}"


def _defined(table: Table) -> F64:
    values = table.column("period_s")
    return np.asarray(values[np.isfinite(values)])


def _spread(values: F64) -> float:
    low, high = np.quantile(values, (0.25, 0.75))
    return float(high - low)


if __name__ == "__main__":
    sys.exit(main())
