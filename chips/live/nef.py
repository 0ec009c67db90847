"""A network on the NEF chip that is driven live, in steps of 1 ms: its nodes are lines, its probes are shown.

It takes no events: nodes bring its inputs. Outputs are the numbers of neurons, in the order of the network's
ensembles; a spike is told at the end of its step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.live.chip import Addresses, Train, within
from chips.nef.build import Built, build, moved
from chips.nef.chip import NefChip
from chips.nef.circuit import chip_biases
from chips.nef.network.kernel import DT
from chips.nef.network.network import Network
from chips.nef.simulation import Simulation, SimulationState
from chips.noise import SiliconNoise
from circuits.arrays import F64, I64, Bools
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon

_CLOSE = 1e-9  # of a step, by which its end may be missed


@dataclass(frozen=True)
class NefEngine:
    """A built network on its chip; probes: those that are shown."""

    built: Built
    probes: tuple[str, ...]

    @property
    def inputs(self) -> tuple[Addresses, ...]:
        """It takes no events."""
        return ()

    @property
    def outputs(self) -> tuple[Addresses, ...]:
        """Its neurons."""
        return (Addresses("neuron", 0, self.built.network.neurons),)

    @property
    def lines(self) -> Mapping[str, int]:
        """Its nodes, by name."""
        run = Simulation(self.built)
        return {name: run.given(name).size for name in self.built.given}

    def takes(self, addresses: I64) -> Bools:
        """It takes none."""
        return within(self.inputs, addresses)

    def begin(self) -> SimulationState:
        """Return the state at rest."""
        return Simulation(self.built).snapshot()

    def go_on(
        self, state: SimulationState, now: float, until: float, train: Train
    ) -> tuple[SimulationState, Train]:
        """Run the whole steps up to `until`, s."""
        run = self._restored(state)
        run.record()
        steps = int(np.floor(until / DT + _CLOSE)) - round(run.time / DT)
        if steps > 0:
            run.advance(steps * DT)
        return run.snapshot(), run.recorded()

    def counts(self, state: SimulationState) -> Mapping[str, int]:
        """Return the counters of the chip."""
        return self._restored(state).counters

    def biases(self) -> Mapping[str, float]:
        """Return the biases to which it is calibrated by name, A or V."""
        usual = {b.name: float(np.ravel(b.value)[0]) for b in chip_biases()}
        return usual if self.built.where is None else {**usual, **self.built.where.chip.biases}

    def with_bias(self, state: SimulationState, name: str, value: float) -> tuple[NefEngine, SimulationState]:
        """Calibrate the chip to another value of a bias, A or V; codes and decoders stay."""
        chip, celsius = self._where()
        return self._moved(state, replace(chip, biases={**chip.biases, name: value}), celsius)

    def at(self, state: SimulationState, temperature_c: float) -> tuple[NefEngine, SimulationState]:
        """Go on at another temperature, degC; codes and decoders stay."""
        return self._moved(state, self._where()[0], temperature_c)

    def drive(self, state: SimulationState, line: str, values: F64) -> SimulationState:
        """Hold a node at some values."""
        run = self._restored(state)
        run.set(line, values)
        return run.snapshot()

    def show(self, state: SimulationState) -> Mapping[str, F64]:
        """Return what its probes show."""
        run = self._restored(state)
        return {name: run.read(name) for name in self.probes}

    def _restored(self, state: SimulationState) -> Simulation:
        run = Simulation(self.built)
        run.restore(state)
        return run

    def _where(self) -> tuple[NefChip, float]:
        where = self.built.where
        if where is None:
            raise TypeError("a live network is on a chip")
        return where.chip, where.temperature_c

    def _moved(
        self, state: SimulationState, chip: NefChip, temperature_c: float
    ) -> tuple[NefEngine, SimulationState]:
        run = self._restored(state)
        built = moved(self.built, chip.at(temperature_c))
        run.move(built)
        return NefEngine(built, self.probes), run.snapshot()


def open_nef(
    silicon: Silicon | None, network: Network, bias_kind: BiasKind = "generator", *,
    probes: Sequence[str] | None = None, seed: int = 0, noise: SiliconNoise | None = None,
) -> NefEngine:  # fmt: skip
    """Return a network on the NEF chip, solved and calibrated at the silicon's temperature.

    probes : shown, all unless given; seed : of the network's neurons.
    """
    chip = NefChip(bias_kind=bias_kind, noise=noise)
    if silicon is not None:
        chip = replace(chip, die=silicon.die, calibration_c=silicon.temperature_c, process=silicon.process)
    built = build(network, chip.at(chip.calibration_c), seed)
    return NefEngine(built, tuple(p.name for p in network.probes) if probes is None else tuple(probes))
