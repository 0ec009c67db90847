"""The cards `.measure ac` of a deck as measures of small signals that have gradients."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from circuits.errors import ParameterError
from circuits.gradient.small_signal.transfer import OfSpectrum
from circuits.measure.branch import voltage_nodes
from circuits.measure.measure import Measure, read_measures
from circuits.measure.scope import Scope, TableRecord
from circuits.measure.unit import PLAIN, VOLT, unit_named
from system.cli.deck import with_own_spectrum
from system.cli.deck_measures import own_cards, own_moves, taken
from system.cli.simulate_verb import Simulate
from system.cli.small_signal_runs import frequencies_of

if TYPE_CHECKING:
    from circuits.arrays import C128, F64
    from circuits.lowering.kernel import Machine
    from system.options.block import Choice


def spectrum_cards(asked: Simulate, choice: Choice, machine: Machine) -> dict[str, OfSpectrum]:
    """Give the measures of a whole deck's `.measure ac` cards by name; none of any other target.

    They read the answer to the deck's own AC values at the frequencies of its first `.ac`. A card that names
    what the circuit does not have is told and left out. Raises `ParameterError` for cards of a deck without
    such values.
    """
    cards, moves = own_cards(asked.block, choice, "ac"), dict(own_moves(asked.block, choice))
    if not moves and cards:
        raise ParameterError(f"{cards[0]}: no source of {asked.block} has an AC value; write as v1 in 0 ac 1")
    given, nodes = with_own_spectrum(asked), voltage_nodes(machine)
    unit = VOLT
    if given.source is not None:
        number = machine.source_names.index(given.source)
        unit = PLAIN if machine.source_quantities[number] == "voltage" else unit_named("Ohm")
    scope = Scope(frozenset(nodes), frozenset(), axis=unit_named("Hz"), voltage=unit, transfer=True)
    grid = tuple(frequencies_of(given).tolist())
    return {
        each.name: OfSpectrum(each.name, tuple(moves.items()), nodes, grid, partial(_taken, each), each.unit)
        for each in read_measures(taken(cards, scope), scope)
    }


def _taken(measure: Measure, frequency: F64, transfer: Mapping[str, C128]) -> tuple[float, str]:
    """A measure's number in its unit, and why it has none."""
    voltages: Any = transfer
    found = measure.of(TableRecord(frequency, voltages, {}))
    return found.value, found.reason
