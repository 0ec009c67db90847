"""`Simulator`, with the interface of nengo's own, which runs a nengo network on the NEF chip.

An unmodified `nengo.Network` is put on our neurons: encoders, intercepts, highest rates, evaluation points
and membranes at the beginning are drawn by nengo's rules from its seeds, decoders solved by each connection's
own solver from the curves that are measured on the chip (`LstsqL2`, nengo's default, by our fixed-order least
squares). Nodes run in Python every step of 1 ms. What goes to a node or probe is there in the step in which
it is in nengo's own simulator; so is what a synapse brings to neurons. Spikes that go to neurons without a
synapse, directly or by way of nodes, act a step later than in nengo, which is warned of.

`chip=None` stands for an ideal die: nengo's own neurons, LIF with their time constants, spike by spike. What
cannot be done is refused by name: other neurons than LIF, learning, noise, other synapses than a low-pass
into neurons, sparse and convolutional transforms, solvers for weights, another time step, probes of anything
but outputs and spikes.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import nengo
import numpy as np
from nengo.utils.progress import Progress, ProgressTracker
from numpy.typing import ArrayLike

from chips.nef.build import build
from chips.nef.calibration import REFERENCE_C, refractory_current
from chips.nef.chip import SLOWEST, NefChip
from chips.nef.nengo.built import Data, Model, Samples
from chips.nef.nengo.errors import ClosedError, InvalidError, RefusedError
from chips.nef.nengo.live import Live, size_of_probe
from chips.nef.nengo.plan import Plan
from chips.nef.network.curves import TAU_REF
from chips.nef.network.demand import check_demand
from chips.nef.network.kernel import DT
from chips.nef.network.network import Connection
from chips.nef.population import populate
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from circuits.errors import ParameterError, UnknownNameError

NOMINAL_CHIP = NefChip()
_NENGOS = ("dg", "rng", "signals", "step_order")
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
        Seed of what processes of nodes draw, where they have none of their own, as nengo's: one more than the
        network's unless given. Neurons are drawn from the network's.
    model
        None; a chip takes no model that nengo has built.
    progress_bar
        nengo's: whether, or which, bar is drawn while networks are built and run; none unless given.
    optimize
        Taken as nengo's, and without effect.
    chip
        What it runs on; None for an ideal die.
    temperature_c
        Temperature at which the chip is calibrated and runs, degC.

    Raises
    ------
    InvalidError
        `dt` is another, or there is a `model` or no network; a `ParameterError`, and nengo's
        `ValidationError`.
    RefusedError
        The network has what the chip cannot do; a `ParameterError`, and nengo's `BuildError`.
    """

    def __init__(
        self,
        network: nengo.Network,
        dt: float = DT,
        seed: int | None = None,
        model: object = None,
        progress_bar: Any = None,
        optimize: object = None,
        *,
        chip: NefChip | None = NOMINAL_CHIP,
        temperature_c: float = REFERENCE_C,
    ) -> None:
        if dt != DT:
            raise InvalidError(f"dt: {dt} s, must be {DT:g} s, the chip's; leave it out")
        if model is not None:
            raise InvalidError(f"model: {model}, a chip takes no model of nengo's; give the network alone")
        if not isinstance(network, nengo.Network):
            raise InvalidError(f"network: {network!r}, must be a nengo.Network")
        self._steps, self._closed = 0, False
        self.progress_bar, self.optimize = progress_bar, optimize
        self._network = network
        with ProgressTracker(progress_bar, Progress("Building", "Build")):
            self._build(network, chip, temperature_c)
        if seed is None and network.seed is not None:
            seed = network.seed + 1
        self.seed = int(np.random.default_rng().integers(2**31 - 1)) if seed is None else seed
        self._samples: dict[Any, Samples] = {}
        self.reset()
        if self._live.delayed:
            first, *others = self._live.delayed
            more = f" and {len(others)} more" if others else ""
            warnings.warn(
                f"{first}{more}: spikes without a synapse act on neurons a step later than in nengo; give it"
                " synapse=0 for the same in both",
                nengo.exceptions.NengoWarning,
                stacklevel=2,
            )

    def _build(self, network: nengo.Network, chip: NefChip | None, temperature_c: float) -> None:
        """Draw the neurons, and solve for decoders."""
        self._plan = Plan(network)
        if chip is not None:  # before it is calibrated
            _check_synapses(self._plan.connections)
            with _refused():
                check_demand(self._plan.network(), chip)
        self._curves = (
            self._plan.ideal
            if chip is None
            else _calibrated(chip, temperature_c, self._plan.ideal.tau_ref).at(temperature_c)
        )
        taus = self._plan.ideal.tau_rc, self._plan.ideal.tau_ref
        with _refused():
            self._built = build(self._plan.network(), self._curves, self._plan.seeds[network], taus)

    def __enter__(self) -> Simulator:
        """Return itself; raises `ClosedError` where it is closed."""
        self._check_open("entered")
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
        seed = self._plan.seeds[self._network]
        rates = populate(p.ensemble, self._curves, p.first, seed, given, p.line, p.tau).rates
        return rates.reshape(*points.shape[:-1], ensemble.n_neurons)

    @property
    def dt(self) -> float:
        """Step of time, s."""
        return DT

    @property
    def n_steps(self) -> int:
        """How many steps were taken."""
        return self._steps

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._closed

    @property
    def time(self) -> float:
        """Time reached, s."""
        return self.n_steps * self.dt

    @property
    def counters(self) -> dict[str, int]:
        """Return the chip's counts: spikes, those dropped, those that waited, and what converters clipped."""
        return self._run.counters

    def reset(self, seed: int | None = None) -> None:
        """Go back to the start, with another `seed` of what processes of nodes draw if one is given.

        Raises `ClosedError` where it is closed.
        """
        self._check_open("reset")
        if seed is not None:
            self.seed = seed
        self._run = Simulation(self._built, DT)
        _begin(self._plan, self._run)
        self._steps = 0
        self._live = Live(self._plan, self._run, self.seed)
        self.clear_probes()

    def clear_probes(self) -> None:
        """Forget what probes have seen."""
        self._samples = {p: Samples(size_of_probe(p)) for p in self._live.probes}

    def close(self) -> None:
        """Refuse to run on from here; what probes have seen stays."""
        self._closed = True

    def run(self, time_in_seconds: float, progress_bar: Any = None) -> None:
        """Run for a time, in whole steps; a time of less than half a step warns that there is none.

        Raises `InvalidError` for a time below 0, or none, and `ClosedError` where it is closed.

        Parameters
        ----------
        time_in_seconds
            The time, s.
        progress_bar
            As of the simulator, whose own is drawn unless another is given.
        """
        if not 0.0 <= time_in_seconds < np.inf:
            raise InvalidError(f"time_in_seconds: {time_in_seconds:g} s, must be >= 0 and finite")
        steps = round(time_in_seconds / self.dt)
        if steps == 0:
            self._check_open("run")
            warnings.warn(
                f"{time_in_seconds} results in running for 0 timesteps. Simulator still at time {self.time}.",
                stacklevel=2,
            )
        self.run_steps(steps, progress_bar=progress_bar)

    def run_steps(self, steps: int, progress_bar: Any = None) -> None:
        """Take a number of `steps`; `progress_bar` is as of `run`.

        Raises `InvalidError` for no whole number of them, or one below 0, and `ClosedError` where it is
        closed.
        """
        if not (steps >= 0 and steps % 1 == 0):
            raise InvalidError(f"steps: {steps}, must be a whole number >= 0")
        shown = self.progress_bar if progress_bar is None else progress_bar
        with ProgressTracker(shown, Progress("Simulating", "Simulation", max(int(steps), 1))) as bar:
            for _ in range(int(steps)):
                self.step()
                bar.total_progress.step()

    def step(self) -> None:
        """Take one step; raises `ClosedError` where it is closed."""
        self._check_open("run")
        self._steps += 1
        self._live.step(self.n_steps * self.dt)
        for probe, read in self._live.probes.items():
            every = 1 if probe.sample_every is None else probe.sample_every / self.dt
            if self.n_steps % every < 1.0:
                self._samples[probe].append(read())

    def trange(self, dt: float | None = None, sample_every: float | None = None) -> F64:
        """Return the times of the samples, s, float64[samples].

        Parameters
        ----------
        dt
            The old name of `sample_every`, s, which warns, as nengo's does.
        sample_every
            Time between two samples, s; a step unless given.

        Raises
        ------
        InvalidError
            Both are given, or the time is not above 0.
        """
        if dt is not None:
            if sample_every is not None:
                raise InvalidError(f"trange.dt: {dt:g} s beside sample_every; give sample_every alone")
            warnings.warn("`dt` is deprecated. Use `sample_every` instead.", DeprecationWarning, stacklevel=2)
            sample_every = dt
        if sample_every is not None and not sample_every > 0.0:
            raise InvalidError(f"trange.sample_every: {sample_every:g} s, must be > 0")
        every = 1.0 if sample_every is None else sample_every / self.dt
        steps = np.arange(1, self.n_steps + 1)
        return np.asarray(self.dt * steps[steps % every < 1.0])

    def __getattr__(self, name: str) -> Any:
        """Refuse, by name, what only nengo's own simulator has; raises `AttributeError`."""
        if name in _NENGOS:
            raise AttributeError(f"Simulator.{name}: a chip has no signals and operators of nengo's")
        raise AttributeError(f"Simulator.{name}: unknown")

    def __reduce__(self) -> Any:
        """Refuse to be pickled or copied; raises `TypeError`."""
        raise TypeError("Simulator: cannot be pickled or copied; pickle the network, and make another one")

    def _check_open(self, what: str) -> None:
        if self._closed:
            raise ClosedError(f"Simulator: cannot be {what}, the simulator is closed; make another one")


def _begin(plan: Plan, run: Simulation) -> None:
    """Set membranes and refractory periods to where nengo begins with these neurons."""
    for e, name in plan.names.items():
        state = e.neuron_type.make_state(e.n_neurons, rng=np.random.RandomState(plan.seeds[e] + 1))
        own = run.built.neurons(name)
        run.state.u[own] = state["voltage"]
        run.state.rest[own] = state["refractory_time"] - DT  # nengo's counts from the step's end


@contextmanager
def _refused() -> Iterator[None]:
    """Raise `RefusedError` for a `ParameterError` within."""
    try:
        yield
    except ParameterError as error:
        raise RefusedError(str(error)) from error


def _check_synapses(connections: Sequence[Connection]) -> None:
    """Raise `ParameterError` for a low-pass slower than the chip's slowest; very fast ones are as none."""
    for each in connections:
        if each.synapse > SLOWEST:
            raise RefusedError(
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
        raise RefusedError(
            f"neuron_type.tau_ref: {tau_ref:g} s, the chip's refractory period is set from {SHORTEST:g} to"
            f" {LONGEST:g} s; take one in between, or name the chip's own bias i_rfr"
        )
    return replace(here, biases={**chip.biases, "i_rfr": refractory_current(tau_ref)})
