"""A study's testbench in ngspice: metrics of its runs, and draws of a foundry's dies.

A metric that is read from a run of the testbench is read from ngspice's run likewise. One that makes runs of
its own, or is a function of the machine, does so in our solver and is refused here. On a foundry's cards a
die shares the foundry's own numbers (`netlists.foundry.die`), which have their labels in the place of our
V_T0 and beta of a polarity.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from circuits.arrays import F64
from circuits.blocks.metric import Metric
from circuits.errors import ParameterError
from circuits.lowering.flatten import FlatCircuit
from circuits.lowering.kernel import Machine
from circuits.lowering.variation import variation_draws, variation_labels
from circuits.silicon.die import SHARED_PLACE, Die, Path, standard_normals
from circuits.silicon.sampling import labels
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result
from circuits.solver.transient import simulate as native
from netlists.foundry import engine
from netlists.foundry.die import foundry_labels, statistics_text
from netlists.foundry.process import card_file, process_names, read_foundry
from system.options.block import Choice

Engine = Literal["native", "ngspice"]


def simulate(machine: Machine) -> Result:
    """Run the machine's testbench on its die in ngspice, on a foundry's cards where its process has some.

    Raises `SimulatorError` where ngspice fails, which a study counts with its reason.
    """
    return engine.simulate(machine.testbench, machine.silicon)


def metrics_in_ngspice(metrics: Sequence[Metric]) -> tuple[Metric, ...]:
    """The metrics, measured in ngspice; raises `ParameterError` for one that is not read from one run."""
    for metric in metrics:
        if metric.measure is not native:
            raise ParameterError(
                f"metric: {metric.name}, is measured by runs of its own in our solver; with the engine"
                " ngspice"
                " take what the testbench measures"
            )
    return tuple(replace(metric, measure=simulate) for metric in metrics)


def choice_on_cards(choice: Choice) -> Choice:
    """The choice whose biases are voltages for the foundry's cards; itself on a process of our own."""
    if not choice.silicon.process.cards:
        return choice
    return replace(choice, circuit=engine.biased_on_cards(choice.circuit, choice.silicon))


@dataclass(frozen=True, slots=True)
class Draws:
    """Standard normals behind the dies of a circuit in ngspice."""

    flat: FlatCircuit
    silicon: Silicon

    def labels(self) -> tuple[str, ...]:
        """Label of every draw: the transistors' own, then what a die shares."""
        own = variation_labels(self.flat, self._local())
        return (*own, *(x for path, name in self._shared() for x in labels(SHARED_PLACE, [path], name)))

    def of(self, die: Die) -> F64:
        """Draws of a die, float64[labels]; those of the nominal die are zero."""
        if die.number is None:
            return np.zeros(len(self.labels()))
        own = variation_draws(self.flat, self._local(), die)
        shared = [standard_normals(die, SHARED_PLACE, [path], name) for path, name in self._shared()]
        return np.concatenate([own, *shared])

    def _local(self) -> Silicon:
        die = self.silicon.die
        if not self._of_foundry():
            return self.silicon
        return replace(self.silicon, die=replace(die, process=False))

    def _of_foundry(self) -> bool:
        return bool(self.silicon.process.cards)

    def _shared(self) -> list[tuple[Path, str]]:
        die = self.silicon.die
        if not (self._of_foundry() and die.process and die.corner == "random"):
            return []
        mapping = read_foundry(self.silicon.process.cards)
        return [(((kind, ()),), f"shared.{name}") for kind, name in foundry_labels(mapping)]


def named_statistics(process: str | None, engine: Engine) -> str:
    """End of a title: on which cards in ngspice, and whose statistics its dies have; empty without any.

    Parameters
    ----------
    process
        Name of the process that was asked for; None for a block's own.
    engine
        What solves the testbench.
    """
    if engine == "native":
        return ""
    if process not in process_names():
        return ", in ngspice"
    return f", in ngspice on {process}, statistics {statistics_text(read_foundry(process or ''))}"


def cards_digest(silicon: Silicon) -> str:
    """Hash of the foundry's file whose cards are taken; empty for a process of our own."""
    if not silicon.process.cards:
        return ""
    return hashlib.sha256(card_file(read_foundry(silicon.process.cards)).read_bytes()).hexdigest()[:16]
