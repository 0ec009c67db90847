"""The cards `.measure ac` of a deck as measures of small signals that have gradients."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from circuits.errors import ParameterError
from circuits.gradient.small_signal.transfer import OfSpectrum
from circuits.measure.branch import voltage_nodes
from circuits.measure.current import current_in, current_names
from circuits.measure.grammar import currents_in
from circuits.measure.measure import Measure, read_measures
from circuits.measure.scope import Scope, TableRecord
from circuits.measure.unit import AMPERE, PLAIN, VOLT, Unit, unit_named
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

    They read the answer of nodes and currents to the deck's own AC values at the frequencies of its first
    `.ac`. A card that names what the circuit does not have is told and left out. Raises `ParameterError` for
    cards of a deck without such values.
    """
    cards, moves = own_cards(asked.block, choice, "ac"), dict(own_moves(asked.block, choice))
    if not moves and cards:
        raise ParameterError(f"{cards[0]}: no source of {asked.block} has an AC value; write as v1 in 0 ac 1")
    given, nodes = with_own_spectrum(asked), voltage_nodes(machine)
    units = VOLT, AMPERE
    if given.source is not None:
        number = machine.source_names.index(given.source)
        from_voltage = machine.source_quantities[number] == "voltage"
        units = (PLAIN, unit_named("S")) if from_voltage else (unit_named("Ohm"), PLAIN)
    known = frozenset(current_names(machine))
    scope = transfers(nodes, known, *units)
    grid = tuple(frequencies_of(given).tolist())
    read = (*nodes, *(f"i({name})" for name in currents_in(cards) if name in known))
    return {
        each.name: OfSpectrum(each.name, tuple(moves.items()), read, grid, partial(_taken, each), each.unit)
        for each in read_measures(taken(cards, scope), scope)
    }


def _taken(measure: Measure, frequency: F64, transfer: Mapping[str, C128]) -> tuple[float, str]:
    """A measure's number in its unit, and why it has none."""
    found = measure.of(record_of(frequency, transfer))
    return found.value, found.reason


def transfers(nodes: Iterable[str], currents: frozenset[str], voltage: Unit, current: Unit) -> Scope:
    """Give the names of measures of small signals: nodes and currents, and their units."""
    return Scope(
        frozenset(nodes), currents, axis=unit_named("Hz"), voltage=voltage, current=current, transfer=True
    )


def record_of(frequency: F64, transfer: Mapping[str, C128]) -> TableRecord:
    """Give transfers over frequency, complex128[F], of nodes and of `i(NAME)`, as measures see them."""
    found: Any = ({}, {})
    for node, values in transfer.items():
        name = current_in(node)
        found[name is not None][node if name is None else name] = values
    return TableRecord(frequency, *found)
