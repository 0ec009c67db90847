"""A deck's own sweep `.dc`, and any of its analyses in ngspice where only that has all of its cards."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.checks import implausible_allowed
from circuits.circuit import GROUND
from circuits.devices.source import Constant
from circuits.errors import DataError, ParameterError, unknown_name
from circuits.lowering.kernel import Machine
from circuits.measure.branch import branches, is_followed, voltage_nodes
from circuits.measure.measure import Reading, read_measures
from circuits.measure.scope import Scope, TableRecord, device_currents
from circuits.measure.unit import unit_named, value_text
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.sweep import dc_sweep, direct_current
from circuits.testbench import Testbench
from netlists.ngspice.deck import Ran, run_deck
from netlists.ngspice.run import Waveforms
from netlists.read import Imported, read_netlist
from netlists.read.analysis import TEMPERATURE, VARIED, NoiseSpectrum, SmallSignals, Sweep
from netlists.read.foreign import REMEDY
from netlists.read.note import Foreign
from netlists.read.text.name import circuit_name
from system.cli.block_choice import choose_block, read_with, refuse_steps
from system.cli.deadline import deadline_of
from system.cli.deck_measures import of_analysis, taken
from system.cli.measure_output import measured_document
from system.cli.output import print_json, print_line, print_table, quantity_cell, working
from system.cli.shared_options import BlockValues, Engine
from system.cli.simulate_verb import Simulate
from system.cli.verbs import Op
from system.files.writing import write_text_atomic
from system.notice import say
from system.options.block import Choice
from system.options.target import deck_of
from system.plot import COLOURS, check_picture, save_picture, sized_axes

_SHOWN = 40  # vectors of a deck that are printed; CSV and JSON have all
_DRAWN = len(COLOURS)
_DROP = re.compile(r"leave it out by `drop=([^`]*)`")  # of Python, and what the command line has for it
_BRANCH = re.compile(r"^(.*)#branch$")  # ngspice's name of a current; # begins a comment in a table
_AXES = {"": "", "time": "s", "v-sweep": "V", "i-sweep": "A", "res-sweep": "Ohm", "temp-sweep": "degC"}


def is_foreign(target: str, engine: Engine) -> bool:
    """Whether a target is a deck that ngspice is to run as it stands, since only it has all cards."""
    deck = deck_of(target)
    if deck is None or engine != "ngspice" or not deck.path.is_file():
        return False
    with implausible_allowed():
        foreign = read_netlist(deck.path, foreign="kept").foreign
    _refuse_varied(foreign)
    refuse_steps(target)
    return bool(foreign)


def refuse_foreign(target: str) -> None:
    """Raise `DataError` for a deck with cards that only ngspice has; it names the first, and what to do."""
    deck = deck_of(target)
    if deck is None or not deck.path.is_file():
        return
    with implausible_allowed():
        foreign = read_netlist(deck.path, foreign="kept").foreign
    if foreign:
        _refuse_varied(foreign)
        first, more = foreign[0], len(foreign) - 1
        others = f" ({more} more: noctule import {target})" if more else ""
        reason = _DROP.sub(rf"leave it out by noctule import {target} --drop \1 -o mine.py", first.reason)
        reason = reason.removesuffix(f"; {REMEDY}")
        raise DataError(f"{first.place}: {reason}{others}; run it with --engine ngspice")


def _refuse_varied(foreign: Sequence[Foreign]) -> None:
    """Raise `DataError` for a card of several circuits, which ngspice has not either."""
    for card in foreign:
        if card.text.split()[0].lower() in VARIED:
            raise DataError(f"{card.place}: {card.reason}")


def simulated_as_deck(asked: Simulate) -> bool:
    """Say whether a target was run as a deck, as it is for `.dc`, and in ngspice where only that can.

    Raises `DataError` for a deck that only ngspice can run, of which another engine is asked for.
    """
    if asked.analysis == "dc" or is_foreign(asked.block, asked.engine):
        _simulate_deck(asked)
        return True
    refuse_foreign(asked.block)
    return False


def _simulate_deck(asked: Simulate) -> None:
    """Run a deck's `.tran` or `.dc` in ngspice as it stands, or its `.dc` in the native solver."""
    check_picture(asked.plot)
    if asked.spikes is not None:
        raise ParameterError("--spikes: not of a deck as it stands, which watches no node; write --csv")
    if asked.view is not None or asked.output is not None:
        raise ParameterError("--view: not of a deck as it stands, whose devices are ngspice's; write --csv")
    if is_foreign(asked.block, asked.engine):
        _refuse_values(asked.values)
        found = _as_it_stands(asked.block, _ran(asked.analysis), asked.deadline, asked.raw)
        with implausible_allowed():
            deck = read_netlist(Path(asked.block), foreign="kept")
        unit = _AXES[found.axis_name]
    elif asked.engine == "ngspice":
        raise ParameterError(
            "--engine: ngspice, must be native for --analysis dc of our own devices; leave it out"
        )
    else:
        refuse_foreign(asked.block)
        found, deck, unit = _swept(asked)
    measured = _readings(found, unit, deck, asked.measure)
    _tell(asked.block, asked.engine, found, asked.csv, measured, as_json=asked.as_json)
    save_picture(asked.plot, lambda figure: _draw(found, asked.block, figure))


def _readings(found: Waveforms, unit: str, deck: Imported, asked: Sequence[str]) -> list[Reading]:
    """What the deck's own cards, and what is asked for, measure of a run along an axis of a unit."""
    cards = of_analysis(deck, found.analysis)
    if not cards and not asked:
        return []
    steps = np.diff(found.axis)
    if steps.any() and not ((steps >= 0.0).all() or (steps <= 0.0).all()):
        if asked:
            raise ParameterError("--measure: of a sweep of two sources, must be of one; sweep one at a time")
        say(f"{cards[0]}: of a sweep of two sources, which is no curve; .measure cards are left out")
        return []
    volts = {n: v for n, v in found.values.items() if _unit(n) == "V"}
    amps = {n.removesuffix("#branch"): v for n, v in found.values.items() if n.endswith("#branch")}
    amps = {n: -v if circuit_name(n) in deck.turned else v for n, v in amps.items()}  # as the circuit has it
    scope = Scope(frozenset(volts), frozenset(amps), axis=unit_named(unit))
    record = TableRecord(found.axis, volts, amps)
    return [each.of(record) for each in read_measures((*taken(cards, scope), *asked), scope)]


def op_deck(asked: Op) -> None:
    """Solve a deck's operating point in ngspice as it stands."""
    _refuse_values(asked.values)
    found = _as_it_stands(asked.block, "op", None, None)
    _tell(asked.block, asked.engine, found, asked.csv, (), as_json=asked.as_json)


def with_own_spectrum(asked: Simulate) -> Simulate:
    """What is asked for of small signals or noise; a deck's own `.ac` or `.noise` says the rest."""
    deck = deck_of(asked.block)
    if deck is None or asked.analysis not in {"ac", "noise"}:
        return asked
    choice = choose_block(asked.block, asked.values, asked.silicon, asked.stimulus, asked.begin)
    with implausible_allowed(asked.silicon.allow_implausible):
        found = read_with(deck, choice)
    kind = SmallSignals if asked.analysis == "ac" else NoiseSpectrum
    card = next((a for a in found.analyses if isinstance(a, kind)), None)
    source, node = asked.source, asked.node
    if isinstance(card, NoiseSpectrum):
        ends = (card.output,) if card.reference == GROUND else (card.output, card.reference)
        source, node = source or circuit_name(card.source), node or ends
    elif list(found.moved.values()) == [1.0]:
        source = source or next(iter(found.moved))
    spectrum = card.spectrum if isinstance(card, NoiseSpectrum) else card
    given = replace(asked, source=source, node=node)
    if spectrum is None or spectrum.low == 0.0:
        return given
    return replace(
        given,
        low=asked.low or f"{spectrum.low!r}Hz",
        high=asked.high or f"{spectrum.high!r}Hz",
        points=asked.points or _a_decade(spectrum),
    )


def _a_decade(spectrum: SmallSignals) -> int | None:
    """Frequencies a decade, as dense as the deck's; as many as are usual for those of equal steps."""
    if spectrum.scale == "lin":
        return None
    return spectrum.points if spectrum.scale == "dec" else math.ceil(spectrum.points * math.log2(10.0))


def _ran(analysis: str) -> Ran:
    if analysis == "tran":
        return "tran"
    if analysis == "dc":
        return "dc"
    raise ParameterError(f"--analysis: {analysis}, of a deck in ngspice as it stands must be tran or dc")


def _refuse_values(values: BlockValues) -> None:
    if values.param:
        raise ParameterError(f"--param: {values.param[0]}, not of a deck as it stands; edit its .param card")


def _as_it_stands(target: str, analysis: Ran, deadline: str | None, raw: str | None) -> Waveforms:
    deck = deck_of(target)
    if deck is None or deck.name:
        raise ParameterError(f"{target}: only a whole deck runs as it stands; name the file alone")
    if raw is not None:
        raise ParameterError("--raw: not of a deck as it stands; write --csv")
    with working(f"running {deck.path.name} in ngspice"):
        return run_deck(deck.path, analysis, deadline_s=deadline_of(deadline, "ngspice"))


def _swept(asked: Simulate) -> tuple[Waveforms, Imported, str]:
    """The deck's first `.dc` card, solved natively, the deck, and the unit of the source that moves first."""
    deck = deck_of(asked.block)
    if deck is None or deck.name:
        raise ParameterError(
            "--analysis: dc, that of a deck's own .dc card; name a deck, or use noctule sweep"
        )
    choice = choose_block(asked.block, asked.values, asked.silicon, asked.stimulus, asked.begin)
    with implausible_allowed(asked.silicon.allow_implausible):
        found = read_with(deck, choice)
    sweep = next((a for a in found.analyses if isinstance(a, Sweep)), None)
    if sweep is None:
        raise DataError(f"{deck.path.name}: no .dc card; add one, as .dc vin 0 5 0.1")
    with working(f"sweeping {asked.block}"):
        axis, volts = _curves(found, sweep, choice)
    values = {name: np.array(volts[name]) for name in volts}
    inner = sweep.sources[0]
    fed = {s.name for s in choice.testbench().sources if s.quantity == "current"}
    is_current = {circuit_name(inner), f"{circuit_name(inner)}[0]"} & fed
    unit = "degC" if inner == TEMPERATURE else "A" if is_current else "V"
    return Waveforms("dc", inner, axis, values, axis.size, ()), found, unit


def _curves(found: Imported, sweep: Sweep, choice: Choice) -> tuple[F64, dict[str, list[float]]]:
    inner, *outer = (_points(*each) for each in zip(sweep.start, sweep.stop, sweep.step, strict=True))
    axis: list[float] = []
    volts: dict[str, list[float]] = {}
    for held in product(*outer):
        given = dict(zip(sweep.sources[1:], held, strict=True))
        for value, point in _branch(found, sweep.sources[0], inner, given, choice):
            axis.append(value)
            for node, v in point.items():
                volts.setdefault(node, []).append(v)
    return np.array(axis), volts


def _branch(
    found: Imported, name: str, values: F64, held: dict[str, float], choice: Choice
) -> Iterator[tuple[float, dict[str, float]]]:
    """Values of the inner source, and the voltages, V, of all nodes there."""
    silicon = choice.silicon
    if TEMPERATURE in held:
        silicon = replace(silicon, temperature_c=held[TEMPERATURE])
    bench = choice.testbench()
    for source, value in held.items():
        if source != TEMPERATURE:
            bench = _held(bench, circuit_name(source), _turned(found, source, value))
    if name == TEMPERATURE:
        for celsius in values:
            point = operating_point(bench, replace(silicon, temperature_c=float(celsius)))
            yield float(celsius), _named(point.voltages(), point.machine) | _at(_supplies(found, point), 0)
        return
    if _is_floating(bench, circuit_name(name)):
        near: dict[str, float] | None = None
        for value in values:
            held_at = _held(bench, circuit_name(name), float(value))
            point = operating_point(held_at, silicon, near)
            near = {node: v for node, v in point.voltages().items() if node != GROUND}
            yield float(value), _named(point.voltages(), point.machine) | _at(_supplies(found, point), 0)
        return
    swept = dc_sweep(bench, circuit_name(name), [_turned(found, name, v) for v in values], silicon)
    supplies = _supplies(found, swept)
    for k, value in enumerate(values):
        volts = dict(zip(swept.nodes, swept.voltage[k].tolist(), strict=True))
        yield float(value), _named(volts, swept.machine) | _at(supplies, k)


def _held(bench: Testbench, name: str, value: float) -> Testbench:
    """The testbench with a source at a constant value."""
    if _is_floating(bench, name):
        return _held(_held(bench, f"{name}[0]", value), f"{name}[1]", -value)
    if name not in {source.name for source in bench.sources}:
        raise unknown_name(f"{bench.title} source", name, [source.name for source in bench.sources])
    held = (replace(s, waveform=Constant(value), direct=None) if s.name == name else s for s in bench.sources)
    return replace(bench, sources=tuple(held))


def _named(volts: dict[str, float], machine: Machine) -> dict[str, float]:
    """Voltages of nodes, V, and currents of elements as ngspice calls them, `l1#branch`, A."""
    currents = {f"{name}#branch": g * volts[node] for node, (name, g) in branches(machine).items()}
    return {node: volts[node] for node in voltage_nodes(machine)} | currents


def _at(currents: dict[str, F64], k: int) -> dict[str, float]:
    return {name: float(current[k]) for name, current in currents.items()}


def _supplies(found: Imported, point: OperatingPoint | direct_current.Sweep) -> dict[str, F64]:
    """Currents of sources of voltage at ground, A, float64[N], as ngspice calls them and with its signs."""
    sources = [s for s in found.testbench.sources if s.quantity == "voltage" and not is_followed(s.node)]
    currents = device_currents(point, [s.name for s in sources])
    signs = {s.name: -1.0 if s.name in found.turned else 1.0 for s in sources}
    return {f"{name}#branch": signs[name] * current for name, current in currents.items()}


def _turned(found: Imported, source: str, value: float) -> float:
    """A source's value as the circuit has it, which may see it from its other end."""
    return -value if circuit_name(source) in found.turned else float(value)


def _is_floating(bench: Testbench, source: str) -> bool:
    """Whether a current flows between two nodes, which are a source each."""
    return f"{source}[1]" in {each.name for each in bench.sources}


def _points(start: float, stop: float, step: float) -> F64:
    if step == 0.0 or (stop - start) * step < 0.0:
        raise DataError(f".dc: from {start:g} to {stop:g} by {step:g}, the step must lead there; correct it")
    return np.asarray(start + step * np.arange(int((stop - start) / step + 1e-9) + 1), dtype=np.float64)


def _unit(name: str) -> str:
    return "A" if name.endswith("#branch") or "[i" in name else "V"


def _tell(
    target: str,
    engine: Engine,
    found: Waveforms,
    csv: str | None,
    measured: Sequence[Reading],
    *,
    as_json: bool,
) -> None:
    if csv is not None:
        write_text_atomic(csv, _table(found))
    vectors = [
        {"name": n, "unit": _unit(n), "min": float(v.min()), "max": float(v.max()), "last": float(v[-1])}
        for n, v in found.values.items()
    ]
    if as_json:
        head = {"block": target, "engine": engine, "analysis": found.analysis}
        readings = [measured_document(each) for each in measured]
        print_json(
            {**head, "axis": found.axis_name or None, "points": found.steps, "vectors": vectors,
             "measured": readings}
        )  # fmt: skip
        return
    columns = ("last",) if found.analysis == "op" else ("min", "max", "last")
    rows = [(v["name"], *(quantity_cell(_digits(v[c]), str(v["unit"])) for c in columns)) for v in vectors]
    title = f"{Path(target).name}: {found.analysis} in {engine}, {found.steps} points"
    print_table(title, ("vector", *(f"{c}:" for c in columns)), rows[:_SHOWN])
    if len(rows) > _SHOWN:
        print_line(f"{len(rows) - _SHOWN} more vectors; --csv FILE or --json has all")
    if measured:
        told = ((each.name, each.reason or value_text(each.value, each.unit)) for each in measured)
        print_table("measures", ("measure", "value"), [*told])


def _digits(value: Any) -> float:
    return float(f"{value:.6g}")


def _table(found: Waveforms) -> str:
    """All vectors as CSV: the axis first, where there is one; a row a point."""
    named = {_BRANCH.sub(r"i(\1)", n) + f"_{_unit(n)}": v for n, v in found.values.items()}
    if found.axis_name:
        named = {("time_s" if found.axis_name == "time" else found.axis_name): found.axis, **named}
    text = io.StringIO()
    table = np.column_stack(list(named.values()))
    np.savetxt(text, table, fmt="%.12g", delimiter=",", header=",".join(named), comments="")
    return text.getvalue()


def _draw(found: Waveforms, target: str, figure: Any) -> None:
    """Fill `figure` with the first voltages over the axis."""
    axes = sized_axes(figure, 7.0, 4.0)
    shown = [n for n in found.values if _unit(n) == "V"][:_DRAWN]
    for name, colour in zip(shown, COLOURS, strict=False):
        axes.plot(found.axis, found.values[name], color=colour, label=name)
    axes.set(xlabel="time (s)" if found.axis_name == "time" else found.axis_name, ylabel="voltage (V)")
    axes.set_title(f"{Path(target).name}, {found.analysis}", fontsize=9.0)
    axes.legend()
