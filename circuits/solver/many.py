"""Spikes of very many dies as arrays: draws, rest states and runs are made on a graphics processor.

`spikes_on_gpu(machine, dies)` gives what runs of a machine on each die leave, but without a result for each:
their waveforms are not kept. Draws, rest states, steps and spikes are those of `circuits.solver.lanes`. While
the runs are on the way, the processor tells from the rest states' modes which are stable.

Runs differ in length: some dies spike over and over, and the last ones of these would keep few threads busy
for long. So all runs stop at a number of steps that most do not reach. Those that do are begun again with
more, and together. Those that would take still more, as their spikes tell, dies whose rest state is not
found or not stable, and runs that fail, are done by the processor meanwhile, and counted.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, on_die
from circuits.lowering.on_dies import coefficients_on_dies, differ_in_transistors
from circuits.programs import gpu
from circuits.silicon.die import Die
from circuits.silicon.draws_on_gpu import normals_on_gpu
from circuits.solver.batch import samples
from circuits.solver.lanes.layout import (
    DONE,
    FAILED,
    TERM,
    Found,
    Jobs,
    Wiring,
    dense,
    jobs_of,
    moving_of,
    wiring,
)
from circuits.solver.lanes.on_gpu import Batch
from circuits.solver.lanes.rest import begins_at_rest, decays, nominal_rests
from circuits.solver.lanes.simulate import fits
from circuits.solver.operating_point import charge_matrix
from circuits.solver.transient import DEFAULT_RTOL, MAX_STEPS, Runner, simulate

_TOGETHER = 100_000  # dies that go to the device at once; ours
_AHEAD = 2  # such groups that are on the way; ours
_DRAWN = 16384  # dies that are drawn at once; ours
_MODES = 1024  # rest states of which a thread of the processor finds the modes at once; ours
_SHORT, _LONG = 4096, 24576  # steps of a run at most, at first and then; ours
_TELLING = 3  # spikes that tell how a run goes on; ours


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
    moved = [
        p._replace(die=p.die + k, again=p.again + k, failed={k + j: why for j, why in p.failed.items()})
        for p, k in zip(parts, first, strict=True)
    ]
    return _joined(moved, np.concatenate([p.steps for p in parts]))


def _part(machine: Machine, rtol: float, dies: Sequence[Die]) -> SpikesOfDies:
    """Spikes of as many dies as go to the device at once."""
    with gpu.stream():
        return _on_device(machine, rtol, dies)


def _on_device(machine: Machine, rtol: float, dies: Sequence[Die]) -> SpikesOfDies:
    runner = Runner(machine, (), rtol)
    ports = tuple(runner.labels)
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

    found = list(Batch(w, jobs, len(dies), given, most=_SHORT).all_found(tell_stable))
    good = stable & (found[-1].state == DONE)
    first = _spikes(ports, found, good, np.arange(len(dies)))
    longer = stable & _stopped(found, _SHORT) & (_steps_to_end(found, jobs.stop) <= _LONG)
    with ThreadPoolExecutor(1) as processor:
        others = np.flatnonzero(~good & ~longer)
        waiting = processor.submit(_by_themselves, machine, ports, rtol, dies, others)
        more = np.flatnonzero(longer)
        later, failing = _longer(w, jobs, given, ports, more)
        parts = [first, later, waiting.result(), _by_themselves(machine, ports, rtol, dies, failing)]
    steps = first.steps.copy()
    for which, part in zip((more, others, failing), parts[1:], strict=True):
        steps[which] = part.steps
    return _joined(parts, steps)


def _longer(
    w: Wiring, jobs: Jobs, given: Mapping[str, Any], ports: tuple[str, ...], dies: I64
) -> tuple[SpikesOfDies, I64]:
    """Spikes of dies that take more steps, and those whose runs fail."""
    if not dies.size:
        return _no_spikes(ports), dies
    own = {name: array[dies] for name, array in given.items()}
    found = list(Batch(w, jobs, dies.size, own, most=_LONG).all_found())
    good = found[-1].state == DONE
    return _spikes(ports, found, good, dies), dies[~good]


def _spikes(ports: tuple[str, ...], found: Sequence[Found], good: Bools, dies: I64) -> SpikesOfDies:
    """What runs have left that came to a good end; dies: which die each run is of."""
    time, run, port = (
        np.concatenate([getattr(part, name) for part in found])
        for name in ("spike_time", "spike_job", "spike_index")
    )
    own = good[run]
    return _no_spikes(ports)._replace(
        time=time[own], die=dies[run[own]], port=port[own], steps=found[-1].steps
    )


def _no_spikes(ports: tuple[str, ...]) -> SpikesOfDies:
    none = np.zeros(0, dtype=np.int64)
    return SpikesOfDies(ports, np.zeros(0), none, none, np.zeros((0, 3)), none, {})


def _stopped(found: Sequence[Found], most: int) -> Bools:
    """Whether each run failed for want of steps."""
    last = found[-1]
    return np.asarray((last.state == FAILED) & (last.steps[:, :2].sum(axis=1) >= most))


def _steps_to_end(found: Sequence[Found], stop: float) -> F64:
    """How many steps each run takes if it goes on spiking as it does; 0 of those with few spikes.

    Up to its first spike it is taken to have made as many steps as half of those that have come to an end.
    """
    count, last = len(found[-1].state), found[-1]
    begun, reached, spikes = np.full(count, stop), np.zeros(count), np.zeros(count)
    for part in found:
        np.minimum.at(begun, part.spike_job, part.spike_time)
        np.maximum.at(reached, part.spike_job, part.spike_time)
        np.add.at(spikes, part.spike_job, 1.0)
    steps, over = last.steps[:, :2].sum(axis=1), last.state == DONE
    usual = float(np.median(steps[over])) if over.any() else 0.0
    rest = (steps - usual) * (stop - reached) / np.where(spikes >= _TELLING, reached - begun, np.inf)
    return np.where(spikes >= _TELLING, steps + rest, 0.0)


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


def _by_themselves(
    machine: Machine, ports: tuple[str, ...], rtol: float, dies: Sequence[Die], which: I64
) -> SpikesOfDies:
    """Spikes of some of the dies, by the processor."""
    time, die, port, failed = [np.zeros(0)], [which[:0]], [which[:0]], {}
    steps = np.zeros((which.size, 3))
    found = samples(partial(simulate, rtol=rtol, record=()), machine, [dies[k] for k in which])
    for at, (k, sample) in enumerate(zip(which.tolist(), found, strict=True)):
        if sample.value is None:
            failed[k] = sample.reason
            continue
        for j, name in enumerate(ports):
            own = sample.value.spikes[name]
            time.append(own)
            die.append(np.full(own.size, k))
            port.append(np.full(own.size, j))
        done = sample.value.steps
        steps[at] = done.accepted, done.rejected, done.iterations
    return SpikesOfDies(
        ports, np.concatenate(time), np.concatenate(die), np.concatenate(port), steps, which, failed
    )


def _joined(parts: Sequence[SpikesOfDies], steps: F64) -> SpikesOfDies:
    """Spikes of several parts, die after die; steps: of each die."""
    time, die, port, again = (
        np.concatenate([getattr(p, name) for p in parts]) for name in ("time", "die", "port", "again")
    )
    failed = {k: why for p in parts for k, why in p.failed.items()}
    order = np.lexsort((time, die))
    again.sort()
    return SpikesOfDies(parts[0].ports, time[order], die[order], port[order], steps, again, failed)
