"""Spikes of very many dies as arrays: draws, rest states and runs are made on a graphics processor.

`spikes_on_gpu(machine, dies)` gives what runs of a machine on each die leave, but without a result for each:
their waveforms are not kept. Draws, rest states, steps and spikes are those of `circuits.solver.lanes`. While
the runs are on the way, the processor tells from the rest states' modes which are stable. A die whose rest
state is not found or not stable, and a run that fails, are done again by themselves, and counted.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, on_die
from circuits.lowering.on_dies import coefficients_on_dies, differ_in_transistors
from circuits.programs import gpu
from circuits.silicon.die import Die
from circuits.silicon.draws_on_gpu import normals_on_gpu
from circuits.solver.batch import samples
from circuits.solver.lanes.layout import DONE, TERM, Jobs, Wiring, dense, jobs_of, moving_of, wiring
from circuits.solver.lanes.on_gpu import Batch
from circuits.solver.lanes.rest import begins_at_rest, decays, nominal_rests
from circuits.solver.lanes.simulate import fits
from circuits.solver.operating_point import charge_matrix
from circuits.solver.transient import DEFAULT_RTOL, MAX_STEPS, Runner, simulate

_TOGETHER = 100_000  # dies that go to the device at once; ours
_AHEAD = 2  # such groups that are on the way; ours
_DRAWN = 16384  # dies that are drawn at once; ours
_MODES = 1024  # rest states of which a thread of the processor finds the modes at once; ours
_ARRAYS = ("time", "die", "port", "steps", "again")


class SpikesOfDies(NamedTuple):
    """What runs of a machine leave on many dies.

    ports: what is watched. time: of all spikes, s, die after die and each die's in their order. die, port: of
    each spike, which die and which of the ports. steps: of each die, accepted, rejected and iterations.
    again: dies that were done again by themselves. failed: why dies have no run, by the die's position.
    """

    ports: tuple[str, ...]
    time: F64
    die: I64
    port: I64
    steps: F64
    again: I64
    failed: dict[int, str]

    def first(self, port: str) -> F64:
        """The first spike at a port on each die, s, float64[dies]; NaN where there is none."""
        found = np.full(len(self.steps), np.nan)
        own = np.flatnonzero(self.port == self.ports.index(port))[::-1]
        found[self.die[own]] = self.time[own]
        return found


def spikes_on_gpu(machine: Machine, dies: Sequence[Die], *, rtol: float = DEFAULT_RTOL) -> SpikesOfDies:
    """Spikes of runs of a machine on many dies.

    Parameters
    ----------
    machine
        A lowered testbench whose runs fit for lanes, begin at rest, and differ from die to die in their
        transistors alone; ParameterError otherwise.
    dies
        The dies.
    rtol
        Local error of a step, relative to the larger of |v| and 1 V.

    Raises
    ------
    ParameterError
        Where there is no graphics processor, too.
    """
    if not dies:
        raise ParameterError("dies: none, must be at least one")
    if not (fits(machine) and begins_at_rest(machine) and differ_in_transistors(machine, dies)):
        raise ParameterError(
            f"{machine.flat.circuit.name}: runs on these dies differ in more than their transistors, or are "
            "not for lanes; call simulate_each with place='gpu', or simulate"
        )
    groups = [dies[k : k + _TOGETHER] for k in range(0, len(dies), _TOGETHER)]
    with ThreadPoolExecutor(_AHEAD) as threads:  # while the last runs of one are on the way, others begin
        parts = list(threads.map(partial(_part, machine, rtol), groups))
    first = np.cumsum([0, *map(len, groups)])[:-1].tolist()
    moved = [p._replace(die=p.die + k, again=p.again + k) for p, k in zip(parts, first, strict=True)]
    joined = {name: np.concatenate([getattr(p, name) for p in moved]) for name in _ARRAYS}
    return _with_others(machine, dies, rtol, SpikesOfDies(parts[0].ports, **joined, failed={}))


def _part(machine: Machine, rtol: float, dies: Sequence[Die]) -> SpikesOfDies:
    """Spikes of as many dies as go to the device at once, of those whose runs come to an end there."""
    with gpu.stream():
        return _on_device(machine, rtol, dies)


def _on_device(machine: Machine, rtol: float, dies: Sequence[Die]) -> SpikesOfDies:
    runner = Runner(machine, (), rtol)
    w = wiring(machine, np.zeros(0, dtype=np.int64), runner.watched, moving_of([machine]))
    two = [on_die(machine, replace(dies[0], number=k)) for k in range(2)]  # which tell what differs
    zero = np.zeros(w.columns)
    jobs = jobs_of(two, [zero, zero], rtol, MAX_STEPS, resting=True)
    rest = Batch(w, jobs, len(dies), _own_coefficients(machine, dies, jobs))
    (states,) = rest.all_found()
    rests, jacobian = states.state == DONE, states.jacobian
    rests |= _near_nominal(machine, w, jobs, rest, np.flatnonzero(~rests), jacobian)
    jobs = jobs._replace(resting=False)
    given = {"coefficient": rest.arrays["jobs_coefficient"], "start": rest.arrays["rest"]}
    stable = np.zeros(len(dies), dtype=np.bool_)

    def tell_stable() -> None:
        stable[rests] = _stable(w, machine, jacobian[rests])

    parts = list(Batch(w, jobs, len(dies), given).all_found(tell_stable))
    good = stable & (parts[-1].state == DONE)
    time, die, port = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("spike_time", "spike_job", "spike_index")
    )
    order = np.lexsort((time, die))
    order = order[good[die[order]]]
    mine = (time[order], die[order], port[order])
    return SpikesOfDies(tuple(runner.labels), *mine, parts[-1].steps, np.flatnonzero(~good), {})


def _near_nominal(machine: Machine, w: Wiring, jobs: Jobs, rest: Batch, lost: I64, jacobian: F64) -> Bools:
    """Whether a rest state is found of dies that were lost, from the nominal die's; it joins the others."""
    good = np.zeros(len(jacobian), dtype=np.bool_)
    if not lost.size:
        return good
    (near,) = nominal_rests([machine])
    if near is None:
        return good
    given = {"coefficient": rest.arrays["jobs_coefficient"][lost], "start": near[None]}
    again = Batch(w, jobs, lost.size, given)
    (found,) = again.all_found()
    good[lost] = found.state == DONE
    rest.arrays["rest"][lost], jacobian[lost] = again.arrays["rest"], found.jacobian
    return good


def _own_coefficients(machine: Machine, dies: Sequence[Die], jobs: Jobs) -> dict[str, F64]:
    """Coefficients that differ from die to die, [dies, own], by the field of `Jobs`."""
    parts = [dies[k : k + _DRAWN] for k in range(0, len(dies), _DRAWN)]
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        each = threads.map(lambda part: coefficients_on_dies(machine, part, normals_on_gpu), parts)
        v_t0, specific = map(np.concatenate, zip(*each, strict=True))
    phi, gamma = jobs.coefficient[0, TERM.surface_potential], jobs.coefficient[0, TERM.gamma]
    lift = phi + gamma * np.sqrt(phi) - v_t0
    drawn = {TERM.specific_current: specific, TERM.v_t0: v_t0, TERM.lift: lift}
    differs = (jobs.coefficient[0] != jobs.coefficient[1]).reshape(-1)
    n, own = v_t0.shape[1], np.flatnonzero(differs).tolist()
    found = np.empty((len(dies), len(own)))
    for column, k in enumerate(own):
        found[:, column] = drawn[k // n][:, k % n]
    return {"coefficient": found}


def _stable(w: Wiring, machine: Machine, jacobian: F64) -> Bools:
    """Whether small deviations die out from each rest state."""
    charge = charge_matrix(machine.kernel)
    parts = [jacobian[k : k + _MODES] for k in range(0, len(jacobian), _MODES)]
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        found = list(threads.map(lambda part: decays(dense(w, part), charge), parts))
    return np.concatenate([np.zeros(0, dtype=np.bool_), *found])


def _with_others(machine: Machine, dies: Sequence[Die], rtol: float, found: SpikesOfDies) -> SpikesOfDies:
    """The spikes with those of dies that are done again by themselves."""
    time, die, port, failed = [found.time], [found.die], [found.port], {}
    work = partial(simulate, rtol=rtol, record=())
    for k, sample in zip(
        found.again.tolist(), samples(work, machine, [dies[k] for k in found.again]), strict=True
    ):
        if sample.value is None:
            failed[k] = sample.reason
            continue
        for j, name in enumerate(found.ports):
            own = sample.value.spikes[name]
            time.append(own)
            die.append(np.full(own.size, k))
            port.append(np.full(own.size, j))
        steps = sample.value.steps
        found.steps[k] = steps.accepted, steps.rejected, steps.iterations
    times, dies_of, ports = np.concatenate(time), np.concatenate(die), np.concatenate(port)
    order = np.lexsort((times, dies_of))
    return found._replace(time=times[order], die=dies_of[order], port=ports[order], failed=failed)
