"""A network on the NEF chip at another temperature: all voltages stay.

A filter's state is a ratio of currents, `s`; the voltage behind it, below the supply, is

    v = middle + fold ln s,   fold = U_T power / kappa_p

(`chips.nef.model.Filters`), from which the other temperature's s follows. A membrane's u is its voltage over
its swing from reset to threshold, and the reset moves too; of a refractory period that runs the same share is
left. What accumulators hold, and the spikes that wait, are numbers and events, which have no temperature.
"""

from __future__ import annotations

from chips.nef.build import Built
from chips.nef.kernel import ChipNet, ChipState
from chips.nef.model import Filters, NeuronLaw
from circuits.arrays import F64


def carried(state: ChipState, old: Built, new: Built) -> ChipState:
    """Return the state of a network's chip as it goes on at another temperature.

    Both networks are the same one with the same codes, as `chips.nef.build.moved` makes them.
    """
    if old.chip is None or new.chip is None:
        return state
    u, rest = moved_neurons(state.base.u, state.base.rest, old.chip, new.chip)
    return state._replace(base=state.base._replace(u=u, rest=rest), s=_filtered(state.s, old, new))


def moved_neurons(u: F64, rest: F64, old: ChipNet | NeuronLaw, new: ChipNet | NeuronLaw) -> tuple[F64, F64]:
    """Return membranes and what is left of refractory periods, s, of the same neurons elsewhere.

    A membrane is as far above its floor, which is ground, as it was; charges are as swings are.
    """
    return new.floor + (u - old.floor) * (_swing(old) / _swing(new)), rest * (new.refractory / old.refractory)


def _swing(neurons: ChipNet | NeuronLaw) -> F64:
    """What a spike charges, thresholds s, float64[n]: a swing times the membrane's capacitance."""
    return 1.0 / neurons.speed if isinstance(neurons, ChipNet) else neurons.charge


def _filtered(s: F64, old: Built, new: Built) -> F64:
    """The state of the filters, float64[lanes], from the voltages that stay."""
    if old.placed is None or old.where is None or new.where is None:
        return s
    analog, tau = old.placed.analog, old.placed.tau
    here, there = (where.filters(tau[analog]) for where in (old.where, new.where))
    found = s.copy()
    found[analog] = moved_filters(s[analog], here, there)
    return found


def moved_filters(s: F64, old: Filters, new: Filters) -> F64:
    """Return the state of the same filters elsewhere, by the voltages of v_syn, which stay."""
    return new.of_volts(old.volts(s))
