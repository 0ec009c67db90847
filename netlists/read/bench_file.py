"""A testbench of a sub-circuit from a TOML file: what drives its ports, and how long.

    title = "an inverter"                     # optional
    stop = "20us"                             # length of a transient; without it there is none
    watch = ["out"]                           # nodes whose spikes are looked for

    [voltages]                                # at each port what stands behind a V card's nodes
    vdd = "5"
    in = "pulse(0 5 1u 10n 10n 5u 20u)"

    [currents]                                # likewise, into the port
    bias = "10n"

    [start]                                   # where the operating point is looked for, V, as .nodeset
    out = "5"

    [initial]                                 # what nodes are held at until time 0, V, as .ic
    out = "0"

Text of sources is SPICE's, so that `M` is milli; `stop` has its unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from pathlib import Path

from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Quantity
from circuits.errors import DataError, unknown_name
from circuits.silicon.toml_file import read_toml
from circuits.testbench import Testbench
from circuits.units import parse_quantity
from netlists.read.card import Card
from netlists.read.expression.scope import Scope
from netlists.read.limits import DEFAULT_LIMITS
from netlists.read.note import Notes
from netlists.read.waveform import Span, read_waveform

_TABLES = ("voltages", "currents", "start", "initial")
_KEYS = ("title", "stop", "watch", *_TABLES)


def read_bench_file(path: Path, circuit: Circuit) -> Testbench:
    """Read the testbench of a circuit.

    Parameters
    ----------
    path
        The TOML file.
    circuit
        The circuit whose ports it drives.

    Raises
    ------
    DataError
        The file cannot be read, is no TOML, or a source's text is none.
    UnknownNameError
        A key that no such file has, or a port that the circuit does not have.
    ParameterError
        A stop time that is none.
    """
    given = read_toml(path, "a testbench's TOML file")
    for key in given:
        if key not in _KEYS:
            raise unknown_name(f"{path}: key", key, _KEYS)
    tables = {name: _table(path, name, given.get(name, {})) for name in _TABLES}
    stop = parse_quantity(str(given["stop"]), "s", f"{path}: stop") if "stop" in given else inf
    span = Span(None if stop == inf else stop / 1000.0, None if stop == inf else stop)
    sources = [
        *_sources(path, circuit, tables["voltages"], "voltage", span),
        *_sources(path, circuit, tables["currents"], "current", span),
    ]
    start, initial = (_voltages(path, name, tables[name]) for name in ("start", "initial"))
    title, watch = str(given.get("title", circuit.name)), tuple(map(str, given.get("watch", ())))
    return Testbench(title, circuit, tuple(sources), stop, watch, start, initial)


def _table(path: Path, name: str, value: object) -> dict[str, str]:
    if not isinstance(value, dict):
        raise DataError(f"{path}: {name} is no table; write [{name}] and a line a port")
    return {port: str(text) for port, text in value.items()}


def _sources(
    path: Path, circuit: Circuit, table: Mapping[str, str], quantity: Quantity, span: Span
) -> list[Source]:
    known = [element for port in circuit.ports for element in port.elements()]
    found = []
    for port, text in table.items():
        if port not in known:
            raise unknown_name(f"{path}: port", port, known)
        card = Card(f"v{port} {port} 0 {text}", path.name, 1)
        waveform, direct = read_waveform(card, card.words()[3:], Scope(DEFAULT_LIMITS), span, Notes())
        found.append(Source(port, port, waveform, quantity, direct))
    return found


def _voltages(path: Path, name: str, table: Mapping[str, str]) -> dict[str, float]:
    scope = Scope(DEFAULT_LIMITS)
    return {
        node: scope.number(Card(text, path.name, 1), f"{name}.{node}", text) for node, text in table.items()
    }
