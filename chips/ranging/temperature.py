"""The ranging chip at another temperature: voltages stay, and a release under way moves with the inhibition.

What a release waits for is the rest of a charge, which stays what it is, and is lost at the new temperature's
current: the time that is left moves in proportion to t_inh. In the compiled chip all neurons are awake from
then on until the next call, since what it knows beforehand of sleeping ones holds at one temperature.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.ranging.kernel import ASLEEP, LOOKING, Chip, Plan, forget_seen, new_plan
from chips.ranging.law import Neurons
from chips.ranging.neuron_kernel import EARLY_STOP, NOW, RELEASE, RUN_ON, advance, call, echo
from chips.ranging.noise import Jitter, most
from circuits.arrays import F64


class Conditions(NamedTuple):
    """Neurons of a compiled chip at a temperature, with what is known of them beforehand.

    neurons: their t_inh is written anew at every call where there is noise; t_inh: without noise, s; jitter:
    None without noise.
    """

    neurons: Neurons
    plan: Plan
    t_inh: F64
    jitter: Jitter | None


def conditions_of(neurons: Neurons, jitter: Jitter | None) -> Conditions:
    """Return what a compiled chip needs of neurons at a temperature; jitter: there, None without noise."""
    plan, t_inh = new_plan(neurons), neurons.t_inh
    if jitter is not None:
        # the chip writes t_inh at every call; an echo is too early only where it is for nearly all
        neurons = neurons._replace(t_inh=t_inh.copy())
        plan = plan._replace(early=np.maximum(plan.early - most(jitter), 0.0))
    return Conditions(neurons, plan, t_inh, jitter)


def move_releases(states: F64, now: float, ratio: F64) -> None:
    """Move the releases of neurons, float64[n, columns], that come after `now` s.

    ratio: t_inh at the new temperature over that at the old one, float64[n].
    """
    ahead = states[:, RELEASE] > now
    states[ahead, RELEASE] = now + (states[ahead, RELEASE] - now) * ratio[ahead]


def moved(chip: Chip, old: Conditions, new: Conditions, now: float) -> Chip:
    """Return a compiled chip as it goes on at `now` s at another temperature.

    What is due before has been taken. A spike that is too near to call is counted once.
    """
    states = np.stack([_at(chip, old, k, now) for k in range(chip.due.size)])
    move_releases(states, now, new.t_inh / old.t_inh)
    jitter = chip.jitter
    if new.jitter is not None:
        jitter = new.jitter._replace(relaxation=jitter.relaxation, last=jitter.last, calls=jitter.calls)
    # looked at when the run goes on, by the new numbers
    after = chip._replace(
        base=states.copy(), ahead=states, due=np.full(chip.due.size, now),
        phase=np.full(chip.due.size, LOOKING), jitter=jitter, calm=chip.calm.copy(), lead=chip.lead.copy(),
        again=chip.again.copy(),
    )  # fmt: skip
    forget_seen(after)  # at the old temperature
    return after


def _at(chip: Chip, on: Conditions, k: int, now: float) -> F64:
    """State of neuron k at `now` s, float64[columns]; of a sleeping one from its last call on."""
    if chip.phase[k] != ASLEEP:
        state: F64 = chip.base[k].copy()
        state[EARLY_STOP] = RUN_ON
        advance(on.neurons, k, state, now)
        return state
    state, called = on.plan.rest[k].copy(), float(chip.last[0])
    state[NOW] = called if called > -math.inf else now
    if called > -math.inf:
        call(on.neurons, k, state)
    heard = chip.echoes[np.argsort(chip.echoes[:, 0], kind="stable")]
    for time, level in heard[heard[:, 0] >= state[NOW]]:
        advance(on.neurons, k, state, time)
        echo(on.neurons, k, state, on.neurons.v_ex_max[k] if np.isnan(level) else level)
    advance(on.neurons, k, state, now)
    return state
