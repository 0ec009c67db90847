"""`Simulator`, with the interface of nengo's own, which runs a nengo network on the NEF chip.

An unmodified `nengo.Network` is put on our neurons: encoders, intercepts, highest rates and evaluation points
are drawn by nengo's rules from its seeds, decoders solved by each connection's own solver from the curves
that are measured on the chip (`LstsqL2`, nengo's default, by our fixed-order least squares). Nodes run in
Python every step of 1 ms, pass-throughs and nodes that follow each other without a synapse in order within
it. A spike acts a step later, as in nengo; so does a number that a node reads without a synapse.

`chip=None` stands for an ideal die: nengo's own neurons, LIF with their time constants. What cannot be done
is refused by name: other neurons than LIF, learning, noise, other synapses than a low-pass, sparse and
convolutional transforms, solvers for weights, another time step, probes of anything but outputs and spikes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import nengo
import numpy as np
from numpy.typing import ArrayLike

from chips.nef.build import build
from chips.nef.calibration import REFERENCE_C, refractory_current
from chips.nef.chip import SLOWEST, NefChip
from chips.nef.nengo.built import Data, Model, Samples
from chips.nef.nengo.live import Live, size_of_probe
from chips.nef.nengo.plan import Plan
from chips.nef.network.curves import TAU_REF
from chips.nef.network.kernel import DT
from chips.nef.network.network import Connection
from chips.nef.population import populate
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from circuits.errors import ParameterError, TopologyError, UnknownNameError

NOMINAL_CHIP = NefChip()
SHORTEST, LONGEST = 0.2e-3, 20e-3  # s, refractory periods to which the chip is set; ours


class Simulator:
    """A nengo network in time, on a chip.

    `data[probe]` is float64[samples, size], a view that copies nothing; `data[ensemble]` and
    `data[connection]` are nengo's `BuiltEnsemble` and `BuiltConnection`.

    Parameters
    ----------
    network
        The network, a `nengo.Network`.
    dt
        Step of time, which must be 0.001 s.
    seed
        Seed in the place of the network's.
    progress_bar
        Taken as nengo's, and not drawn.
    chip
        What it runs on; None for an ideal die.
    temperature_c
        Temperature at which the chip is calibrated and runs, degC.

    Raises
    ------
    ParameterError
        `dt` is another, or the network has what the chip cannot do.
    """

    def __init__(
        self,
        network: nengo.Network,
        dt: float = DT,
        seed: int | None = None,
        progress_bar: object = None,
        *,
        chip: NefChip | None = NOMINAL_CHIP,
        temperature_c: float = REFERENCE_C,
    ) -> None:
        if dt != DT:
            raise ParameterError(f"dt: {dt:g} s, must be {DT:g} s, the chip's; leave it out")
        self.dt, self.n_steps, self.closed = dt, 0, False
        self.seed = network.seed if seed is None else seed
        if self.seed is None:
            self.seed = int(np.random.default_rng().integers(2**31 - 1))
        self._network = network
        self._plan = Plan(network, self.seed)
        self._curves = (
            self._plan.ideal
            if chip is None
            else _calibrated(chip, temperature_c, self._plan.ideal.tau_ref).at(temperature_c)
        )
        if chip is not None:
            _check_synapses(self._plan.connections)
        taus = self._plan.ideal.tau_rc, self._plan.ideal.tau_ref
        self._built = build(self._plan.network(), self._curves, self.seed, taus)
        self._samples: dict[Any, Samples] = {}
        self.reset()

    def __enter__(self) -> Simulator:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def data(self) -> Mapping[Any, Any]:
        """What probes have seen, float64[samples, size] each, and parts as they were built (`Data`)."""
        return Data(self._samples, self._plan, self._built)

    @property
    def model(self) -> Model:
        """What of nengo's built model a chip has: `params`, `seeds`, `toplevel` and `dt`."""
        return Model(self.data, self._plan.seeds, self._network, self.dt)

    def rates(self, ensemble: nengo.Ensemble, points: ArrayLike) -> F64:
        """Return the tuning curves that the chip's neurons have, Hz, float64[..., neurons].

        On a chip they are measured by spikes that are counted for a second, as its decoders are solved from;
        nengo's `tuning_curves` gives those of the neurons that were asked for.

        Parameters
        ----------
        ensemble
            An ensemble of the network.
        points
            Vectors at which they are wanted, in the unit of the ensemble, float64[..., dimensions].

        Raises
        ------
        UnknownNameError
            The ensemble is not of the network.
        """
        if ensemble not in self._plan.names:
            raise UnknownNameError(f"{ensemble}: not an ensemble of the network")
        points = np.asarray(points, dtype=float)
        given = points.reshape(-1, ensemble.dimensions)
        (p,) = self._built.populations[self._plan.names[ensemble]]
        rates = populate(p.ensemble, self._curves, p.first, self.seed, given, p.line, p.tau).rates
        return rates.reshape(*points.shape[:-1], ensemble.n_neurons)

    @property
    def time(self) -> float:
        """Time reached, s."""
        return self.n_steps * self.dt

    @property
    def counters(self) -> dict[str, int]:
        """Return the chip's counts: spikes, those dropped, those that waited, and what converters clipped."""
        return self._run.counters

    def reset(self, seed: int | None = None) -> None:
        """Go back to the start; raises `ParameterError` for a `seed`, which is the network's."""
        if seed is not None:
            raise ParameterError(f"seed: {seed}, neurons are drawn already; make another Simulator")
        self._run = Simulation(self._built, DT)
        self.n_steps = 0
        self._live = Live(self._plan, self._run)
        self.clear_probes()

    def clear_probes(self) -> None:
        """Forget what probes have seen."""
        self._samples = {p: Samples(size_of_probe(p)) for p in self._network.all_probes}

    def close(self) -> None:
        """Refuse to run on from here."""
        self.closed = True

    def run(self, time_in_seconds: float, progress_bar: object = None) -> None:
        """Run for a time.

        Raises `ParameterError` for a time below 0, or none.

        Parameters
        ----------
        time_in_seconds
            The time, s.
        progress_bar
            Taken as nengo's, and not drawn.
        """
        if not 0.0 <= time_in_seconds < np.inf:
            raise ParameterError(f"time_in_seconds: {time_in_seconds:g} s, must be >= 0 and finite")
        self.run_steps(round(time_in_seconds / self.dt))

    def run_steps(self, steps: int, progress_bar: object = None) -> None:
        """Take a number of `steps`; `progress_bar` is taken as nengo's, and not drawn.

        Raises `ParameterError` for no whole number of them, or one below 0.
        """
        if not (steps >= 0 and steps % 1 == 0):
            raise ParameterError(f"steps: {steps}, must be a whole number >= 0")
        for _ in range(int(steps)):
            self.step()

    def step(self) -> None:
        """Take one step; raises `TopologyError` where the simulator is closed."""
        if self.closed:
            raise TopologyError("Simulator: closed; make another one")
        self.n_steps += 1
        self._live.step(self.n_steps * self.dt)
        for probe, read in self._live.probes.items():
            every = 1 if probe.sample_every is None else probe.sample_every / self.dt
            value = read()
            if self.n_steps % every < 1.0:
                self._samples[probe].append(value)

    def trange(self, sample_every: float | None = None) -> F64:
        """Return the times of the samples, s, float64[samples]; `sample_every` is the time between two, s."""
        every = 1.0 if sample_every is None else sample_every / self.dt
        steps = np.arange(1, self.n_steps + 1)
        return np.asarray(self.dt * steps[steps % every < 1.0])


def _check_synapses(connections: Sequence[Connection]) -> None:
    """Raise `ParameterError` for a low-pass slower than the chip's slowest; very fast ones are as none."""
    for each in connections:
        if each.synapse > SLOWEST:
            raise ParameterError(
                f"connection {each.pre} to {each.post}.synapse: {each.synapse:g} s, must be at most"
                f" {SLOWEST:g} s on the chip; take that, or let an ensemble that feeds itself hold the value"
            )


def _calibrated(chip: NefChip, temperature_c: float, tau_ref: float) -> NefChip:
    """The chip, calibrated where it runs and to the refractory period of the network's neurons, s.

    A period that the chip's own biases name stays. Rates saturate by it above the radius as nengo's do.
    """
    here = replace(chip, calibration_c=temperature_c)
    if "i_rfr" in chip.biases or chip.codes is not None or tau_ref == TAU_REF:
        return here
    if not SHORTEST <= tau_ref <= LONGEST:
        raise ParameterError(
            f"neuron_type.tau_ref: {tau_ref:g} s, the chip's refractory period is set from {SHORTEST:g} to"
            f" {LONGEST:g} s; take one in between, or name the chip's own bias i_rfr"
        )
    return replace(here, biases={**chip.biases, "i_rfr": refractory_current(tau_ref)})
