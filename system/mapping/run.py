"""A mapped network run on a die, beside the network that was asked for and what the mapping makes of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chips.aer import Events
from chips.rolls.chip import STEP, RollsChip
from circuits.circuit import BiasKind
from circuits.errors import DataError, ParameterError
from circuits.silicon.silicon import Silicon
from system.mapping.distance import Distance, distance
from system.mapping.dynamics import Trains, asked, check_addresses, chosen, population_rates, rates_of
from system.mapping.dynamics import run as run_equations
from system.mapping.network import Network
from system.mapping.rolls.mapped import Mapped

SETTLING = 0.1  # s, before rates are counted; ours
AFTER = 0.1  # s of a run behind its last event; ours


@dataclass(frozen=True, slots=True)
class MappedRun:
    """What a run leaves.

    Attributes
    ----------
    asked, expected, chip : Trains
        Spikes of the network that was asked for, of what the mapping makes of it, and of the die, numbered as
        in the network.
    rates : dict
        Mean rate of each population in these three, Hz, by `asked`, `expected` and `chip`.
    from_asked, from_expected : Distance
        How far the die is from either.
    begin, duration : float
        When counting begins, and the end, s.
    lost_in, lost_out, held : int
        Events that the buses lost; how often a filter was at the end of its table.
    later : int
        Events that were given for times at or after the end, which were not sent.
    cautions : tuple of str
        What the chip tells of itself.
    """

    asked: Trains
    expected: Trains
    chip: Trains
    rates: dict[str, dict[str, float]]
    from_asked: Distance
    from_expected: Distance
    begin: float
    duration: float
    lost_in: int
    lost_out: int
    held: int
    later: int
    cautions: tuple[str, ...]


def check_channels(network: Network, events: Events, where: str) -> None:
    """Raise `DataError` for an event on a channel that no input of the network has; where: its file."""
    inputs = ", ".join(p.name for p in network.inputs) or "no input"
    check_addresses(events, network.channels, where, f" of {inputs}")
    if events.times.size and events.times[0] < 0.0:
        raise DataError(f"{where}: event 0 at {events.times[0]:g} s, must be at 0 s or later")


def run_mapped(
    mapped: Mapped, events: Events, silicon: Silicon, duration: float | None = None, *,
    kind: BiasKind = "generator", temperature: Callable[[float], float] | None = None,
) -> MappedRun:  # fmt: skip
    """Run a mapped network.

    Parameters
    ----------
    mapped
        The network on its chip.
    events
        Events of its inputs; addresses are channels, one input after the other.
    silicon
        Process, temperature and die.
    duration
        Of the run, s; until a little after the last event unless given.
    kind
        Kind of the biases.
    temperature
        Temperature of the chip over time (s), degC; the silicon's unless given.

    Raises
    ------
    ParameterError
        The run is not longer than what it takes to settle.
    """
    last = float(events.times[-1]) if events.times.size else 0.0
    end = STEP * np.ceil((last + AFTER if duration is None else duration) / STEP - 1e-9)
    if not end > SETTLING:
        raise ParameterError(f"duration: {end:g} s, must be > {SETTLING:g} s, after which rates are counted")
    mine = events.times < end
    given = Events(events.times[mine], events.addresses[mine])
    chip = RollsChip(mapped.program, silicon, kind)
    spikes, _ = chip.run(chip.at_rest(), end, mapped.events(given), temperature)
    network, n = mapped.network, mapped.network.neurons
    runs = {
        "asked": run_equations(asked(network), given, end),
        "expected": run_equations(mapped.dynamics(), given, end),
        "chip": chosen(Trains(spikes.times, spikes.neurons), mapped.neurons.tolist()),
    }
    rates = {k: population_rates(network, rates_of(t, n, SETTLING, end)) for k, t in runs.items()}
    away = [distance(network, runs["chip"], runs[k], SETTLING, end) for k in ("asked", "expected")]
    return MappedRun(
        **runs, rates=rates, from_asked=away[0], from_expected=away[1], begin=SETTLING, duration=float(end),
        lost_in=spikes.lost_in, lost_out=spikes.lost_out, held=spikes.held, later=int((~mine).sum()),
        cautions=chip.cautions(),
    )  # fmt: skip
