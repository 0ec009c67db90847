"""Claim: the rebound neuron's behavioural model has the circuit's outcome on at least 98 % of dies.

200 dies at 27 degC that were not used to build its record (1000 to 1199, mismatch only), and 20 dies at each
of 0 and 60 degC for each kind of bias, these pooled. Class of each against the transistor-level solver;
`undecided` counts as disagreement. Where both work, both edges of the facilitating interval must lie within
max(0.1 ms, 2 % of t_inh). Biases are those of the facts. The time is one neuron's tuning on one thread.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from _report import Row, parser_of, report
from chips.ranging.model import model_of, neurons_on
from chips.ranging.response import UNDECIDED, Tunings, join, tune
from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron, tuning
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

CLAIM = 0.98  # of classes
FIRST_DIE = 1000
CLASSES = [c.value for c in tuning.NeuronClass]


@dataclass(frozen=True, slots=True)
class Group:
    """Dies at one temperature with one kind of bias; what both levels say of them, and how long it took."""

    name: str
    circuit: list[tuning.Tuning]
    model: Tunings
    seconds: tuple[float, float, float]  # transistor level, model, preparing the model's devices

    @property
    def agreeing(self) -> int:
        """Dies whose class is the same."""
        return sum(a.outcome.value == b for a, b in zip(self.circuit, self.model.classes, strict=True))

    @property
    def works(self) -> int:
        """Dies that work at transistor level."""
        return sum(a.outcome.value == "works" for a in self.circuit)

    @property
    def edges(self) -> list[float]:
        """Larger error of both edges over what is allowed, for each die that works at both levels."""
        pairs = zip(self.circuit, self.model.classes, self.model.first, self.model.last, strict=True)
        return [
            max(abs(a.first - first), abs(a.last - last)) / max(0.1e-3, 0.02 * a.t_inh)
            for a, b, first, last in pairs
            if a.outcome.value == b == "works"
        ]


def compare(dies: Iterable[int], temperature: float, kind: BiasKind, rtol: float) -> Group:
    """Tune every die at both levels."""
    neuron = rebias(rebound_neuron.build(), kind=kind)
    places = [
        Silicon(AMI_1500_IDEAL, temperature_c=temperature, die=Die(number=d, process=False)) for d in dies
    ]
    model = model_of(neuron, places[0].process)
    tune(neurons_on(model, places[0]))  # compiles
    tuning.tune(tuning.tuning_machine(neuron, places[0]))
    start = time.perf_counter()
    circuit = [tuning.tune(tuning.tuning_machine(neuron, s), rtol) for s in places]
    middle = time.perf_counter()
    neurons = join([neurons_on(model, s) for s in places])
    prepared = time.perf_counter()
    found = tune(neurons)
    end = time.perf_counter()
    name = f"{temperature:g} degC, {kind}"
    return Group(name, circuit, found, (middle - start, end - prepared, prepared - middle))


def confusion(groups: list[Group]) -> str:
    """Table of classes: rows the circuit's, columns the model's."""
    pairs = Counter(
        (a.outcome.value, b) for g in groups for a, b in zip(g.circuit, g.model.classes, strict=True)
    )
    columns = [c for c in (*CLASSES, UNDECIDED) if any(b == c for _, b in pairs)]
    rows = [c for c in CLASSES if any(a == c for a, _ in pairs)]
    lines = ["circuit \\ model  " + "".join(f"{c:>12}" for c in columns)]
    lines += [f"{a:<17}" + "".join(f"{pairs[a, b]:>12}" for b in columns) for a in rows]
    return "\n".join(lines)


def rows_of(name: str, groups: list[Group]) -> Iterator[Row]:
    """The share of classes that agree, and the times."""
    dies = sum(len(g.circuit) for g in groups)
    agreeing = sum(g.agreeing for g in groups)
    edges = [e for g in groups for e in g.edges]
    circuit, model = (sum(g.seconds[i] for g in groups) / dies for i in (0, 1))
    inside = sum(e <= 1.0 for e in edges)
    accuracy = (
        f"class of {agreeing} of {dies} ({agreeing / dies:.1%}); edges of {inside} of {len(edges)} inside,"
        f" largest error {max(edges, default=0.0):.2f} of what is allowed, mean {np.mean(edges):.3f}"
    )
    share = agreeing / dies
    yield Row(f"{name}, share of equal classes", share, None, share, accuracy, least=CLAIM)
    yield Row(f"{name}, times of a neuron, s", model, circuit, circuit / model, accuracy)


def main() -> int:
    """Compare both levels and print a table."""
    parser = parser_of(__doc__, "40 dies, and 5 in each of the other groups")
    parser.add_argument("--rtol", type=float, default=tuning.TUNING_RTOL, help="of the transistor level")
    options = parser.parse_args()
    many, few = (40, 5) if options.quick else (200, 20)
    warm = [compare(range(FIRST_DIE, FIRST_DIE + many), 27.0, "gate", options.rtol)]
    kinds: tuple[BiasKind, ...] = ("gate", "ideal")
    dies = range(FIRST_DIE, FIRST_DIE + few)
    others = [compare(dies, t, k, options.rtol) for t in (0.0, 60.0) for k in kinds]
    rows = [
        *rows_of(f"{many} dies, {warm[0].name}", warm),
        *rows_of(f"4 x {few} dies, 0 and 60 degC, pooled", others),
    ]
    status = report(rows, options, figures)
    if not options.json:
        show(warm, others)
    return status


def figures(row: Row) -> str:
    """The share, or both times of a neuron."""
    if row.peer is None:
        return f"{row.ours:.3f}"
    return f"{1e3 * row.ours:.2f} ms a neuron against {1e3 * row.peer:.1f}, {row.ratio:.0f} times"


def show(warm: list[Group], others: list[Group]) -> None:
    """Print the classes of both rows, and a line a group."""
    for groups in (warm, others):
        print(f"\n{confusion(groups)}")
    print()
    for g in [*warm, *others]:
        share = f"{g.works} of {len(g.circuit)} work" + (
            "" if 2 * g.works >= len(g.circuit) else ", under half"
        )
        prepared = 1e3 * g.seconds[2] / len(g.circuit)
        print(f"{g.name}: class of {g.agreeing} agrees; {share}; {prepared:.1f} ms to prepare a die")


if __name__ == "__main__":
    sys.exit(main())
