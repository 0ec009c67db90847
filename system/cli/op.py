"""The verb `noctule op`: the operating point of a block, node by node and device by device."""

from __future__ import annotations

import csv as comma_separated
import io
from collections.abc import Mapping, Sequence

import numpy as np

from circuits.devices import Diode
from circuits.errors import ParameterError, unknown_name
from circuits.lowering.kernel import to_kernel
from circuits.measure.branch import branches, is_followed, voltage_nodes
from circuits.measure.scope import device_currents
from circuits.solver.beginning import disturbance
from circuits.solver.device_table import resistor_table_at, transistor_table_at
from circuits.solver.operating_point import OperatingPoint, operating_point
from system.cli.beginning_output import disturbance_document
from system.cli.block_choice import choose_block
from system.cli.deck import is_foreign, op_deck, refuse_foreign
from system.cli.output import plain, print_json, print_line, print_table, quantity_cell, working
from system.cli.verbs import Op
from system.files.writing import write_text_atomic
from system.options.begun import read_voltages
from system.options.block import describe_silicon, silicon_line
from system.options.cards import cards_lines

HIGHEST_START = 100.0  # V; from farther away Newton's iteration only wanders
LEAST_SUFFIX = 1e-15  # a smaller value is printed with its exponent
DEVICES_SHOWN = 200  # of a larger circuit the head is printed; CSV and JSON have all

_CURRENT, _TEXT = "current_A", ("name", "type", "inversion", "region")
# columns of a transistor: name in JSON and CSV, heading and unit in print
_COLUMNS = {
    "name": ("device", ""),
    "type": ("type", ""),
    _CURRENT: ("I", "A"),
    "inversion_coefficient": ("IC", ""),
    "g_m_S": ("g_m", "S"),
    "g_m_over_i_d_per_V": ("g_m/I_D (1/V)", ""),
    "g_ds_S": ("g_ds", "S"),
    "v_ds_V": ("|V_DS|", "V"),
    "v_ds_sat_V": ("V_DSsat", "V"),
    "headroom_V": ("headroom", "V"),
    "inversion": ("inversion", ""),
    "region": ("region", ""),
}

Row = Mapping[str, object]


def op_command(asked: Op) -> None:
    """Print the operating point of a block with its stimuli at 0 s, by node and by device.

    The current of a transistor is that into its drain, which is negative for a conducting pFET; the current
    of a resistor flows from its first node to its second, that of a diode from anode to cathode. The other
    columns are those of `circuits.solver.device_table`.
    """
    if is_foreign(asked.block, asked.engine):
        op_deck(asked)
        return
    refuse_foreign(asked.block)
    if asked.engine != "native":
        raise ParameterError(f"--engine: {asked.engine}, only for a deck with cards of its own; leave it out")
    choice = choose_block(asked.block, asked.values, asked.silicon, asked.stimulus)
    given = read_voltages(asked.start, "--start")
    with working("solving"):
        machine = to_kernel(choice.testbench(), choice.silicon)
        _check_start(given, machine.names[1:])
        point = operating_point(machine, start=given or None)
    if asked.csv is not None:
        write_text_atomic(asked.csv, _device_csv(point))
    if asked.as_json:
        print_json(
            {
                "block": choice.block.name,
                **describe_silicon(choice.silicon),
                "stimuli": choice.stimuli,
                "start_V": given,
                **_state(point),
                "other_states": [_state(other) for other in point.others],
            }
        )
    else:
        _print(point)


def _device_rows(point: OperatingPoint) -> list[Row]:
    """Rows by device: transistors with all columns, resistors and diodes with their current.

    They are nan where undefined.
    """
    t, r = transistor_table_at(point), resistor_table_at(point)
    numbers = (
        t.drain_current, t.inversion_coefficient, t.transconductance, t.efficiency, t.output_conductance,
        t.drain_source, t.saturation, t.headroom,
    )  # fmt: skip
    kinds = (f"{polarity}fet" for polarity in t.polarity)
    columns = (t.name, kinds, *(n.tolist() for n in numbers), t.inversion, t.region)
    rows: list[Row] = [dict(zip(_COLUMNS, row, strict=True)) for row in zip(*columns, strict=True)]
    for name, current in zip(r.name, r.current.tolist(), strict=True):
        rows.append({"name": name, "type": "resistor", _CURRENT: current})
    for name, found in device_currents(point, point.machine.flat.labels(Diode)).items():
        rows.append({"name": name, "type": "diode", _CURRENT: float(found[0])})
    return rows


def _device_csv(point: OperatingPoint) -> str:
    """The table by device as CSV; an empty cell where a column has no meaning."""
    text = io.StringIO()
    writer = comma_separated.DictWriter(text, list(_COLUMNS), restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(plain(_device_rows(point)))
    return text.getvalue()


def _check_start(start: Mapping[str, float], nodes: Sequence[str]) -> None:
    for node, voltage in start.items():
        if node not in nodes:
            raise unknown_name("node", node, nodes)
        if not abs(voltage) <= HIGHEST_START:
            limit = f"must be within -{HIGHEST_START:g} to {HIGHEST_START:g} V"
            raise ParameterError(f"{node}: {voltage:g} V, {limit}; start near the supply's range")


def _state(point: OperatingPoint) -> dict[str, object]:
    left = None if point.stable else disturbance_document(disturbance(point))
    return {
        "stable": point.stable,
        "disturbance": left,
        "voltages_V": _voltages(point),
        "element_currents_A": _element_currents(point),
        "devices": plain(_device_rows(point)),
        "source_currents_A": _source_currents(point),
    }


def _voltages(point: OperatingPoint) -> dict[str, float]:
    """Voltage of each node that stands for no current, V."""
    every = point.voltages()
    return {node: every[node] for node in voltage_nodes(point.machine)}


def _element_currents(point: OperatingPoint) -> dict[str, float]:
    """What flows through each element that has a node for its current, from its first node on, A."""
    every = point.voltages()
    return {name: g * every[node] for node, (name, g) in branches(point.machine).items()}


def _source_currents(point: OperatingPoint) -> dict[str, float]:
    """What each source of the testbench, and each behind a bias, delivers into its node, A, by its name."""
    machine = point.machine
    found = device_currents(point, machine.source_names)
    into = {"voltage": -1.0, "current": 1.0}  # a source of voltage is told what flows into it
    kinds = zip(machine.source_names, machine.source_quantities, strict=True)
    followed = {s.name for s in machine.testbench.sources if is_followed(s.node)}
    return {n: into[kind] * float(found[n][0]) for n, kind in kinds if n not in followed}


def _print(point: OperatingPoint) -> None:
    states = (point, *point.others)
    nodes, table = list(_voltages(point)), [list(_voltages(s).values()) for s in states]
    headings = ["node", "voltage (V):", *("other state (V):" for _ in point.others)]
    silicon = point.machine.silicon
    title = f"operating point at {silicon_line(silicon)}"
    print_table(
        title, headings, [(n, *(f"{v:.6f}" for v in row)) for n, *row in zip(nodes, *table, strict=True)]
    )
    _print_devices(_device_rows(point))
    flows = [(name, _cell(_CURRENT, current)) for name, current in _element_currents(point).items()]
    if flows:
        print_table("inductors and sources between two nodes", ("element", "I:"), flows)
    rows = [(name, _cell(_CURRENT, current)) for name, current in _source_currents(point).items()]
    print_table("sources", ("source", "delivers:"), rows)
    for line in cards_lines(silicon, "native"):
        print_line(line)
    print_line(f"the state is {_stability(point)}")
    for other in point.others:
        print_line(f"without the start another state is found, which is {_stability(other)}")


def _print_devices(rows: Sequence[Row]) -> None:
    if not rows:
        return
    headings = [heading if k in _TEXT else f"{heading}:" for k, (heading, _) in _COLUMNS.items()]
    shown = [[_cell(k, row.get(k)) for k in _COLUMNS] for row in rows[:DEVICES_SHOWN]]
    print_table(f"{len(rows)} devices", headings, shown)
    if len(rows) > DEVICES_SHOWN:
        print_line(f"{len(rows) - DEVICES_SHOWN} more devices; --csv FILE or --json has all")


def _cell(column: str, value: object) -> str:
    """Four digits with the column's unit."""
    if not isinstance(value, float):
        return "" if value is None else str(value)
    if np.isnan(value):
        return ""
    unit = _COLUMNS[column][1]
    if 0.0 < abs(value) < LEAST_SUFFIX:
        return f"{value:.3e}{unit}"
    return quantity_cell(float(f"{value:.4g}"), unit)


def _stability(point: OperatingPoint) -> str:
    if point.stable:
        return "stable"
    found = disturbance(point)
    return f"not stable: the smallest disturbance leaves it, and a run begins with {found.what}"
