"""A mapped network run on a die, beside the network that was asked for and what the mapping makes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.aer import Events
from chips.rolls.chip import STEP, RollsChip
from circuits.circuit import BiasKind
from circuits.errors import DataError, ParameterError
from circuits.silicon.silicon import Silicon
from system.mapping.clock import own_rates, with_own
from system.mapping.distance import Distance, distance
from system.mapping.dynamics import Trains, asked, check_addresses, chosen, population_rates, rates_of
from system.mapping.dynamics import run as run_equations
from system.mapping.network import Network
from system.mapping.rolls.filters import AT
from system.mapping.rolls.mapped import Mapped

SETTLING = 0.1  # s, before rates are counted; ours
AFTER = 0.1  # s of a run behind its last event; ours
OFF, FEW = 0.1, 2.0  # of a rate, or Hz, by which a mapped population may be off before it is told; ours


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
        Rates that the mapping loses, and what the chip tells of itself.
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
    """Raise `DataError` for an event on a channel of no input, or of one that sends by itself.

    where : the events' file.
    """
    inputs = ", ".join(p.name for p in network.inputs) or "no input"
    check_addresses(events, network.channels, where, f" of {inputs}")
    own = own_rates(network)[events.addresses]
    if own.any():
        k = int(np.flatnonzero(own)[0])
        raise DataError(
            f"{where}: event {k} of address {events.addresses[k]}, must be of a channel of outside; this one"
            f" sends {own[k]:g} a second by itself, leave it out"
        )
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
        Events of its inputs from outside; addresses are channels, one input after the other.
    silicon
        Process, temperature and die.
    duration
        Of the run, s; until a little after the last event, and after it has settled, unless given.
    kind
        Kind of the biases.
    temperature
        Temperature of the chip over time (s), degC; the silicon's unless given.

    Raises
    ------
    ParameterError
        The run is not longer than what it takes to settle.
    """
    last = max(float(events.times[-1]) if events.times.size else 0.0, SETTLING)
    end = STEP * np.ceil((last + AFTER if duration is None else duration) / STEP - 1e-9)
    if not end > SETTLING:
        raise ParameterError(f"duration: {end:g} s, must be > {SETTLING:g} s, after which rates are counted")
    mine = events.times < end
    given = with_own(mapped.network, Events(events.times[mine], events.addresses[mine]), 0.0, float(end))
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
    cautions = *short_of(mapped, given, float(end), rates["asked"], rates["expected"]), *chip.cautions()
    return MappedRun(
        **runs, rates=rates, from_asked=away[0], from_expected=away[1], begin=SETTLING, duration=float(end),
        lost_in=spikes.lost_in, lost_out=spikes.lost_out, held=spikes.held, later=int((~mine).sum()),
        cautions=cautions,
    )  # fmt: skip


def short_of(
    mapped: Mapped, given: Events, end: float, asked: Mapping[str, float], expected: Mapping[str, float]
) -> tuple[str, ...]:
    """A caution where populations fire as mapped at other rates than asked for, with what to do; else none.

    given : all events, until `end`, s; asked, expected : mean rates by population, Hz.
    """
    off = {name: (expected[name] - rate) / max(rate, FEW) for name, rate in asked.items()}
    wrong = _wrong(asked, expected)
    if not wrong:
        return ()
    worst = max(wrong, key=lambda name: abs(off[name]))
    more = f", and {len(wrong) - 1} more populations" if len(wrong) > 1 else ""
    told = (
        f"{worst}: {expected[worst]:.3g} Hz as mapped where {asked[worst]:.3g} Hz were asked for"
        f" ({off[worst]:+.0%}){more}"
    )
    if worst in _wrong(asked, _straight(mapped, given, end)):
        return (f"{told}; its neurons, time constants or weights are others, as noctule show tells",)
    told += "; the current of the chip's synapses is a power of what comes in"
    middle = float(np.exp(np.log(mapped.dynamics().cells.unit).mean()))
    if not all(np.isclose(each.pivot, AT * middle) for each in mapped.filters):
        return (f"{told}, as noctule show tells of each kind",)
    remedy = (
        f"as asked for at {AT:g} times what fires a neuron: give noctule map usual events as its input, or"
        " map_on their usual_rates, and it is so at theirs"
    )
    return (f"{told}, {remedy}",)


def _wrong(asked: Mapping[str, float], got: Mapping[str, float]) -> list[str]:
    """Populations whose rate is off by more than `OFF` of it and `FEW`."""
    return [name for name, rate in asked.items() if abs(got[name] - rate) > max(OFF * rate, FEW)]


def _straight(mapped: Mapped, given: Events, end: float) -> dict[str, float]:
    """Mean rates as mapped, Hz, were the filters' currents what comes in and no power of it."""
    dynamics = mapped.dynamics()
    filters = tuple(replace(each, power=1.0) for each in dynamics.filters)
    trains = run_equations(replace(dynamics, filters=filters), given, end)
    return population_rates(mapped.network, rates_of(trains, mapped.network.neurons, SETTLING, end))
