"""Random circuits in both engines: a small form, and what the rows say of a circuit that disagrees."""

from __future__ import annotations

from dataclasses import replace

import pytest
from matplotlib.figure import Figure

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Source, Transistor
from circuits.devices.source import Constant, Pulse
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from system.papers.checks import random_circuits
from system.papers.checks.random_circuits import Beside, beside
from system.study.campaign import Numbered

GOOD = Beside(1, 5, solved=True, converged=True, point=1e-6, edge=1e-4, amplitude=0.1)


@pytest.mark.parametrize("number", [1, 206])  # 206: nodes that hang on leakage alone
def test_a_circuit_agrees(number: int) -> None:
    found = beside(Numbered("circuit", number))
    assert found.solved
    assert found.converged
    assert found.point is not None
    assert found.point < 1e-3
    assert [row.agrees for row in random_circuits._rows([found])] == [True] * 4


def latch(high: str) -> Testbench:
    """Two inverters in a ring, of which the solver is started with one node high."""
    pair = [("a", "b"), ("b", "a")]
    devices = [
        Transistor(f"m{p}{k}", p, out, given, rail, rail, w, 3e-6)  # type: ignore[arg-type]
        for k, (given, out) in enumerate(pair)
        for p, rail, w in (("n", "0", 6e-6), ("p", "vdd", 12e-6))
    ]
    loads = [Capacitor(f"c{n}", n, "0", 1e-13) for n in "ab"]
    circuit = Circuit("latch", (Port("vdd", "supply"),), (*devices, *loads))
    return Testbench("latch", circuit, (Source("vdd", "vdd", Constant(5.0)),), 1e-6, start={high: 5.0})


def test_a_circuit_of_several_points_is_told_from_one_that_is_wrong() -> None:
    silicon = Silicon()
    ours = random_circuits._solved(latch("a"), silicon)
    peer = random_circuits._converged(latch("b"), silicon, {"a": 0.0, "b": 5.0})
    assert ours is not None
    assert peer is not None
    assert random_circuits._apart(ours.voltages(), peer) > 4.0
    assert random_circuits._is_rest_of_both(latch("a"), silicon, ours, peer)
    wrong = {**peer, "a": 1.0}
    assert not random_circuits._is_rest_of_both(latch("a"), silicon, ours, wrong)


def test_edges_are_held_against_each_other() -> None:
    silicon = Silicon()
    circuit = Circuit(
        "load", (Port("in", "analog"),), (Transistor("m", "n", "in", "in", "0", "0", 6e-6, 6e-6),)
    )
    runs = []
    for late in (0.0, 3e-6):
        pulse = Pulse(0.0, 5.0, (2e-5 + late,), 3e-5, 1e-7, 1e-7)
        bench = Testbench("load", circuit, (Source("in", "in", pulse),), 1e-4)
        runs.append(random_circuits.simulate(bench, silicon))
    apart = random_circuits._edges_apart(*runs, "in", 2.5, 5.0)
    assert apart == pytest.approx(3e-6, rel=1e-6)


@pytest.mark.parametrize(
    ("change", "row"),
    [
        ({"point": 2e-3}, "same_point"),
        ({"edge": 0.02}, "same_edges"),
        ({"amplitude": 1.5}, "same_amplitudes"),
        ({"edge": None, "amplitude": None, "failed": "gave up"}, "same_edges"),
    ],
)
def test_what_disagrees_is_named(change: dict[str, object], row: str) -> None:
    bad = replace(GOOD, number=2, **change)  # type: ignore[arg-type]
    assert row in {r.name for r in random_circuits._rows([GOOD, bad]) if r.agrees is False}
    assert any("circuit 2" in note for note in random_circuits._notes([GOOD, bad]))


def test_several_points_are_no_disagreement_and_a_lost_one_counts() -> None:
    several = replace(GOOD, point=3.0, several=True)
    assert all(r.agrees for r in random_circuits._rows([GOOD, several]))
    lost = Beside(3, 4, solved=False, converged=True)
    rows = {r.name: r for r in random_circuits._rows([GOOD, lost])}
    assert rows["share_with_a_point"].agrees is False
    assert "circuit 3: no point in the solver." in random_circuits._notes([GOOD, lost])


def test_the_picture_shows_the_differences() -> None:
    figure = Figure()
    random_circuits.draw([GOOD, replace(GOOD, point=1e-4)], figure)
    assert len(figure.axes[0].lines) == 4
