"""The verb `noctule simulate --analysis ac`: transfer from a source about the rest state of a block."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.arrays import C128, F64
from circuits.errors import ParameterError
from circuits.gradient.small_signal.spectrum import Spectrum
from circuits.measure.branch import voltage_nodes
from circuits.measure.current import current_in, current_names
from circuits.measure.grammar import currents_in
from circuits.measure.measure import Measure, Reading, read_measures
from circuits.measure.unit import AMPERE, PLAIN, VOLT, unit_named, value_text
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.small_signal import Response, ac, source_column
from netlists.ngspice import small_signal as ngspice
from system.cli.deadline import deadline_of
from system.cli.deck_measures import own_cards, own_moves, taken
from system.cli.measure_output import measured_document
from system.cli.output import plain, print_json, print_table
from system.cli.simulate_verb import Simulate
from system.cli.small_signal_picture import draw_bode
from system.cli.small_signal_runs import (
    Run,
    cell_of,
    dataset_of,
    frequencies_of,
    grid_of,
    head_of,
    label_of,
    place_of,
    print_failures,
    row_of,
    runs_of,
)
from system.cli.spectrum_card import record_of, transfers
from system.files.writing import write_netcdf_atomic, write_text_atomic
from system.notice import say
from system.options.block import Choice
from system.plot import check_picture, save_picture

if TYPE_CHECKING:
    import xarray as xr


def ac_command(asked: Simulate) -> None:
    """Print the transfer from the source `--source` to all nodes, or to those of `--node`.

    Without a source it is the answer to a deck's own AC values. Raises `ParameterError` where there are none.
    """
    check_picture(asked.plot)
    nodes, frequency = asked.node or None, frequencies_of(asked)

    def from_source(point: OperatingPoint, source: str, drawn: Sequence[str]) -> Response:
        if asked.engine != "native":
            return _by_ngspice(point, source, asked, nodes, drawn)
        answer = ac(point, source, frequency, nodes or voltage_nodes(point.machine))
        return _with_currents(answer, point, drawn)

    moves_of, currents = _moves_once(asked.block), _Currents(asked)

    def solve(point: OperatingPoint, choice: Choice) -> Response:
        drawn = currents.of(point, choice)
        if asked.source is not None:
            return from_source(point, asked.source, drawn)
        moves = moves_of(choice)
        if not moves:
            raise ParameterError("--source: not given, --analysis ac needs one; name a source, as v_rest")
        return _together([from_source(point, source, drawn) for source in moves], list(moves.values()))

    every = runs_of(asked, solve)
    runs = [replace(run, answer=None if run.answer is None else _of_nodes(run.answer)) for run in every]
    found = [(run, run.answer) for run in runs if run.answer is not None]
    if asked.csv is not None:
        write_text_atomic(asked.csv, _ac_csv(found))
    if asked.netcdf is not None:
        write_netcdf_atomic(asked.netcdf, _ac_dataset(runs))
    known = found[0][1].nodes
    shown = nodes or [n for n in found[0][0].choice.block.plotted if n in known] or known
    save_picture(asked.plot, lambda figure: draw_bode([(label_of(r), a) for r, a in found], shown, figure))
    measures = _measures(asked, *found[0], currents.known)
    readings = [_readings(measures, run.answer) for run in every]
    document = {
        **head_of(asked, runs), "engine": asked.engine, "source": found[0][1].source,
        "unit": found[0][1].unit, "frequency_Hz": found[0][1].frequency,
        "runs": [_ac_run(run, own) for run, own in zip(runs, readings, strict=True)],
    }  # fmt: skip
    if asked.as_json:
        print_json(document)
    else:
        _print_ac(found, shown)
        rows = [
            (label_of(run), each.name, each.reason or value_text(each.value, each.unit))
            for run, own in zip(runs, readings, strict=True)
            for each in own
        ]
        if rows:
            print_table("measures", ("run", "measure", "value"), rows)
        print_failures(runs)


def _moves_once(target: str) -> Callable[[Choice], Mapping[str, complex]]:
    """Give the AC values of a deck, which is read for the first die alone, since all have the same."""
    known: dict[str, complex] = {}

    def moves(choice: Choice) -> Mapping[str, complex]:
        if not known:
            known.update(own_moves(target, choice))
        return known

    return moves


class _Currents:
    """Currents that measures name, and which are known."""

    def __init__(self, asked: Simulate) -> None:
        self.asked, self.known, self.named = asked, frozenset[str](), tuple[str, ...]()

    def of(self, point: OperatingPoint, choice: Choice) -> tuple[str, ...]:
        """Those that are named, as `i(NAME)`; a deck is read for the first die alone: all have the same."""
        machine = point.machine
        if not self.known:
            names = current_names(machine)
            if self.asked.engine != "native":
                kinds = zip(machine.source_names, machine.source_quantities, strict=True)
                names = tuple(name for name, kind in kinds if kind == "voltage")
            self.known = frozenset(names)
            named = currents_in((*own_cards(self.asked.block, choice, "ac"), *self.asked.measure))
            self.named = tuple(f"i({name})" for name in named if name in self.known)
        return self.named


def _with_currents(answer: Response, point: OperatingPoint, names: Sequence[str]) -> Response:
    """A response with the transfers to some currents behind those to its nodes."""
    if not names:
        return answer
    spectrum, moves = Spectrum(point), ((answer.source, 1.0),)
    drawn = spectrum.transfers(moves, answer.frequency, [spectrum.probe(name) for name in names])
    return replace(answer, nodes=(*answer.nodes, *names), transfer=np.hstack([answer.transfer, drawn]))


def _of_nodes(answer: Response) -> Response:
    """A response without its currents."""
    count = sum(current_in(node) is None for node in answer.nodes)
    return replace(answer, nodes=answer.nodes[:count], transfer=answer.transfer[:, :count])


def _measures(
    asked: Simulate, run: Run[Response], answer: Response, currents: frozenset[str]
) -> tuple[Measure, ...]:
    """Measures of responses, whose axis is the frequency: a deck's own cards, and what is asked for."""
    units = {"V/V": (PLAIN, unit_named("S")), "V": (VOLT, AMPERE)}
    scope = transfers(answer.nodes, currents, *units.get(answer.unit, (unit_named("Ohm"), PLAIN)))
    own = taken(_own_cards(asked, run, answer), scope)
    return read_measures((*own, *asked.measure), scope)


def _own_cards(asked: Simulate, run: Run[Response], answer: Response) -> list[str]:
    """A deck's own cards, which are of the answer to its own AC values and of no other transfer."""
    cards, moves = own_cards(asked.block, run.choice, "ac"), own_moves(asked.block, run.choice)
    if cards and answer.unit != "V" and moves != {answer.source: 1.0}:
        rule = "of the deck's own AC values, which hold without --source"
        say(f"{cards[0]}: {rule}; .measure cards are left out")
        return []
    return cards


def _together(parts: Sequence[Response], values: Sequence[complex]) -> Response:
    """The answer to several AC values (V or A) at once, from the transfer of each source by itself."""
    total = sum(value * part.transfer for value, part in zip(values, parts, strict=True))
    return replace(parts[0], source=", ".join(p.source for p in parts), unit="V", transfer=np.asarray(total))


def _readings(measures: Sequence[Measure], answer: Response | None) -> list[Reading]:
    """What is measured of a response."""
    if answer is None:
        return []
    record = record_of(answer.frequency, dict(zip(answer.nodes, answer.transfer.T, strict=True)))
    return [each.of(record) for each in measures]


def _by_ngspice(
    point: OperatingPoint,
    source: str,
    asked: Simulate,
    nodes: Sequence[str] | None,
    currents: Sequence[str],
) -> Response:
    """The same by ngspice, on its grid: whole decades have both ends."""
    cards = point.machine.silicon.process.cards
    if cards:
        raise ParameterError(
            f"--engine: ngspice, which would take the cards of {cards}, of which a small signal is not"
            " made; take"
            " native"
        )
    column = source_column(point, source) - point.machine.kernel.unknowns
    unit = "V/V" if point.machine.source_quantities[column] == "voltage" else "V/A"
    names = voltage_nodes(point.machine) if nodes is None else tuple(nodes)
    for name in names:
        point.machine.column_of(name)  # refuses what is no node by name
    names = (*names, *currents)
    grid = ngspice.Decades(*grid_of(asked))
    deadline_s = deadline_of(asked.deadline, asked.engine)
    frequency, transfer = ngspice.ac(point, source, grid, names, deadline_s)
    return Response(source, unit, names, frequency, transfer)


def _ac_run(run: Run[Response], readings: Sequence[Reading]) -> dict[str, Any]:
    if run.answer is None:
        return place_of(run)
    names, transfer = run.answer.nodes, run.answer.transfer
    magnitude, phase = np.abs(transfer), phase_deg(transfer)
    nodes = {n: {"magnitude": magnitude[:, k], "phase_deg": phase[:, k]} for k, n in enumerate(names)}
    measured = [measured_document(each) for each in readings]
    return {**place_of(run), "nodes": plain(nodes), "measured": measured}


def phase_deg(transfer: C128) -> F64:
    """Give the phase of a transfer, degrees, float64[F, nodes], without jumps along the F frequencies."""
    return np.asarray(np.degrees(np.unwrap(np.angle(transfer), axis=0)))


def corner_frequency(frequency: F64, magnitude: F64) -> float | None:
    """Find the first frequency at which the magnitude is 3 dB below that at the first one, Hz.

    It is interpolated on logarithmic axes, and None where the magnitude never falls that far.

    Parameters
    ----------
    frequency : float64[F], Hz, rising.
    magnitude : float64[F], of the transfer to one node.
    """
    level = magnitude[0] / np.sqrt(2.0)
    below = np.flatnonzero(magnitude <= level)
    if not below.size or magnitude[0] == 0.0:
        return None
    k = int(below[0])
    x, y = np.log(frequency[k - 1 : k + 1]), np.log(magnitude[k - 1 : k + 1])
    return float(np.exp(np.interp(-np.log(level), -y, x)))


def _ac_csv(found: Sequence[tuple[Run[Response], Response]]) -> str:
    names = found[0][1].nodes
    head = ["temperature_C", "die", "frequency_Hz"]
    head += [cell_of(f"{n}_{what}") for n in names for what in ("magnitude", "phase_deg")]
    lines = [",".join(head)]
    for run, answer in found:
        pairs = np.stack([np.abs(answer.transfer), phase_deg(answer.transfer)], axis=2)
        for f, row in zip(answer.frequency, pairs.reshape(answer.frequency.size, -1), strict=True):
            lines.append(row_of(run, f, row))
    return "\n".join(lines) + "\n"


def _ac_dataset(runs: Sequence[Run[Response]]) -> xr.Dataset:
    """transfer_real, transfer_imaginary over temperature, die, frequency, node; NaN where one failed."""
    one = next(run.answer for run in runs if run.answer is not None)
    empty = np.full(one.transfer.shape, np.nan + 1j * np.nan)
    table = [empty if run.answer is None else run.answer.transfer for run in runs]
    dims = ("frequency", "node")
    parts = {"transfer_real": np.real(table), "transfer_imaginary": np.imag(table)}
    data = dataset_of(runs, {name: (dims, values, one.unit) for name, values in parts.items()})
    return data.assign_coords(frequency=one.frequency, node=list(one.nodes)).assign_attrs(source=one.source)


def _print_ac(found: Sequence[tuple[Run[Response], Response]], nodes: Sequence[str]) -> None:
    first = found[0][1]
    rows = []
    for run, answer in found:
        for k, node in enumerate(answer.nodes):
            if node in nodes:
                size = np.abs(answer.transfer[:, k])
                peak, corner = int(np.argmax(size)), corner_frequency(answer.frequency, size)
                at = "none in range" if corner is None else f"{corner:.5g} Hz"
                top = f"{size[peak]:.5g} at {answer.frequency[peak]:.3g} Hz"
                rows.append((label_of(run), node, f"{size[0]:.5g}", at, top, "yes" if run.stable else "NO"))
    what = "answer to the AC values of" if first.unit == "V" else "transfer from"
    title = f"{what} {first.source} ({first.unit}), {first.frequency[0]:g} to {first.frequency[-1]:g} Hz"
    columns = ("silicon", "node", "at the lowest:", "-3 dB of it:", "largest:", "stable")
    print_table(title, columns, rows)
