"""The solver's questions, answered by ngspice: on a foundry's cards where the process has some, else our law.

A process that stands for a foundry's cards names them (`Process.cards`). Its circuits keep their sizes. The
biases of kind `gate` become the voltages at which the foundry's nominal devices carry their currents;
voltages stay. Currents that are derived from a run's voltages, as some measures are, are those of our law.
"""

from __future__ import annotations

from dataclasses import replace

from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from netlists.foundry.deck import format_foundry, map_circuit
from netlists.foundry.die import check_die
from netlists.foundry.process import read_foundry
from netlists.ngspice import engine
from netlists.ngspice.deadline import DEADLINE
from netlists.registry import Method, Settings

RELTOL = 1e-4
"""Relative tolerance of a run on a foundry's cards; ours."""


def simulate(
    testbench: Testbench,
    silicon: Silicon,
    *,
    reltol: float | None = None,
    tmax: float | None = None,
    method: Method = "gear",
    deadline_s: float | None = DEADLINE,
) -> Result:
    """Run a testbench in ngspice, on a foundry's cards where the process has some.

    Parameters
    ----------
    testbench, silicon
        As for the solver.
    reltol, tmax, method
        Relative tolerance, `RELTOL` on a foundry's cards unless given, largest step (s) and method of
        ngspice.
    deadline_s
        Wall-clock time after which a run is halted, s; None for as long as it takes.

    Raises
    ------
    SimulatorError, TopologyError
        As `netlists.ngspice.engine.simulate`.
    ParameterError
        The foundry has no such size, die or corner, or a bias is of a kind that needs our own law.
    """
    if not silicon.process.cards:
        given = {} if reltol is None else {"reltol": reltol}
        return engine.simulate(testbench, silicon, tmax=tmax, method=method, deadline_s=deadline_s, **given)
    bench = on_cards(testbench, silicon)
    settings = Settings(reltol=RELTOL if reltol is None else reltol, tmax=tmax, method=method)
    return engine.simulate_deck(bench, silicon, lambda b: deck_of(b, silicon, settings), deadline_s)


def operating_point(
    testbench: Testbench, silicon: Silicon, deadline_s: float | None = DEADLINE
) -> dict[str, float]:
    """Voltage (V) of every node by path in ngspice, as `netlists.ngspice.engine.operating_point`.

    Parameters
    ----------
    testbench, silicon
        As for the solver; on a foundry's cards where the process has some.
    deadline_s
        Wall-clock time after which the run is halted, s; None for as long as it takes.

    Raises
    ------
    SimulatorError, ParameterError
        As `simulate`.
    """
    if not silicon.process.cards:
        return engine.operating_point(testbench, silicon, deadline_s)
    bench, settings = on_cards(testbench, silicon), Settings(analysis="op", reltol=RELTOL)
    return engine.point_of_deck(bench, silicon, lambda b: deck_of(b, silicon, settings), deadline_s)


def deck_of(testbench: Testbench, silicon: Silicon, settings: Settings) -> str:
    """Deck of a testbench on a foundry's cards, whose biases are voltages (`on_cards`).

    silicon: process, temperature and die. settings: analysis, tolerance, method and largest step.
    """
    return format_foundry(testbench, read_foundry(silicon.process.cards), silicon, settings)


def on_cards(testbench: Testbench, silicon: Silicon) -> Testbench:
    """The testbench whose circuit has its biases as voltages for the cards of the silicon's process.

    testbench: of any biases. silicon: its process names a foundry's cards. Raises `ParameterError` as
    `biased_on_cards`.
    """
    return replace(testbench, circuit=biased_on_cards(testbench.circuit, silicon))


def biased_on_cards(circuit: Circuit, silicon: Silicon) -> Circuit:
    """Give a circuit the biases that it has on a foundry's cards, as voltages; this runs ngspice.

    silicon: its process names the cards.

    Raises `ParameterError` where a bias comes from our bias generator or an ideal copy, whose law no card is;
    a current that the foundry's device cannot carry; or a die or corner that the foundry has not.
    """
    mapping = read_foundry(silicon.process.cards)
    check_die(mapping, silicon.die)
    for bias in circuit.biases:
        if bias.kind not in {"gate", "voltage"}:
            raise ParameterError(
                f"{circuit.name}.{bias.name}: a bias of kind {bias.kind}, on the cards of {mapping.name}"
                " biases are"
                " fixed gates or voltages; give the bias kind gate"
            )
    if all(bias.kind == "voltage" for bias in circuit.biases):
        return circuit
    return map_circuit(circuit, mapping, silicon)
