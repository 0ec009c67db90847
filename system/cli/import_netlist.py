"""The verb `noctule import`: shows a netlist as a circuit and its testbench."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import inf
from pathlib import Path
from typing import Any, Literal

from circuits.brief import stated
from circuits.checks import implausible_allowed
from circuits.circuit import Bias, Port
from circuits.devices import Source
from circuits.errors import DataError, ParameterError
from circuits.silicon.silicon import Silicon
from netlists.read import Imported, read_netlist
from netlists.read.analysis import Analysis, NoiseSpectrum, OperatingPoint, SmallSignals, Sweep, Transient
from netlists.read.summary import summarise
from netlists.registry import Settings, load_dialect
from netlists.write.python import format_python
from system.cli.netlist_output import unwritten
from system.cli.output import print_json, print_line, print_table, quantity_cell
from system.cli.verbs import Import, NetlistReading
from system.files.writing import write_text_atomic

_WORDS = {Transient: "tran", OperatingPoint: "op", Sweep: "dc", SmallSignals: "ac", NoiseSpectrum: "noise"}
PYTHON = "python"
_FOREIGN_SHOWN = 40  # of more, the head is printed; JSON has all


def import_command(asked: Import) -> None:
    """Print what a netlist contains; files that it includes must lie in the folder `root`."""
    with implausible_allowed(asked.allow_implausible):
        imported = read_file(asked.file, asked.reading, "kept")
    if asked.output is not None:
        write_text_atomic(asked.output, _written(asked, imported))
    elif asked.to is not None:
        raise ParameterError(f"--to: {asked.to}, says what --output is; name a file too")
    document = _describe(asked.file, imported)
    if asked.as_json:
        print_json(document)
    else:
        _print(document)
        left = [*unwritten(imported)]
        if left and asked.output is not None:
            print_line(f"{asked.output}: not written: {', '.join(left)}; {asked.file} has them")


def _written(asked: Import, imported: Imported) -> str:
    """Text of what was read, in Python or in a dialect; raises `DataError` where it lacks cards."""
    refuse_foreign(imported)
    is_python = asked.to == PYTHON or (asked.to is None and Path(str(asked.output)).suffix == ".py")
    if imported.deviations and imported.silicon is None:
        first = next(iter(imported.deviations))
        raise DataError(f"{asked.file}: {first} has delvto or mulu0, which no circuit keeps; leave them out")
    if is_python:
        return format_python(
            imported.testbench, f"{imported.testbench.title}, read from {Path(asked.file).name}"
        )
    celsius = 27.0 if imported.temperature_c is None else imported.temperature_c
    silicon = imported.silicon or Silicon(temperature_c=celsius)
    settings = Settings(analysis="op" if imported.testbench.stop == inf else "tran")
    return load_dialect(asked.to or "ngspice").write(imported.testbench, silicon, settings)


def refuse_foreign(imported: Imported) -> None:
    """Raise `DataError` for a netlist with cards for ngspice only, with the first."""
    if imported.foreign:
        first = imported.foreign[0]
        raise DataError(f"{first.place}: {first.reason}; only what is all ours is written")


def read_file(
    path: str, reading: NetlistReading, foreign: Literal["refused", "kept"] = "refused"
) -> Imported:
    """Read the netlist in the file `path`; raises as `netlists.read.read_netlist`, which has `foreign`."""
    root = None if reading.root is None else Path(reading.root)
    return read_netlist(Path(path), root=root, dialect=reading.dialect, drop=reading.drop, foreign=foreign)


def _describe(file: str, imported: Imported) -> dict[str, Any]:
    circuit, bench = imported.circuit, imported.testbench
    summary = summarise(circuit)
    return {
        "file": file,
        "dialect": imported.dialect,
        "models": imported.models,
        "title": bench.title,
        "temperature_C": imported.temperature_c,
        "die": None if imported.silicon is None else str(imported.silicon.die),
        "circuit": circuit.name,
        "circuits": summary.circuits,
        "devices": summary.devices,
        "node_count": summary.nodes,
        "deviation_count": len(imported.deviations),
        "parasitic_count": len(imported.parasitics),
        "ports": [_stated(port) for port in circuit.ports],
        "biases": [_stated(bias) for bias in circuit.biases],
        "sources": [_source(source) for source in bench.sources],
        "stop_s": bench.stop,
        "analyses": [_analysis(each) for each in imported.analyses],
        "steps": [asdict(step) for step in imported.steps],
        "measures": [asdict(measure) for measure in imported.measures],
        "foreign": [asdict(card) for card in imported.foreign],
        "notes": [asdict(note) for note in imported.notes],
        "dropped": [asdict(note) for note in imported.dropped],
        "names": dict(imported.names),
    }


def _stated(part: Port | Bias) -> dict[str, Any]:
    return {name: getattr(part, name) for name in stated(part)}


def _source(source: Source) -> dict[str, Any]:
    waveform = {k: v for k, v in asdict(source.waveform).items() if not isinstance(v, list | tuple)}
    shape = type(source.waveform).__name__.lower()
    return {
        "name": source.name,
        "node": source.node,
        "quantity": source.quantity,
        "waveform": shape,
        **{k: float(v) for k, v in waveform.items() if isinstance(v, float | int)},
    }


def _analysis(analysis: Analysis) -> dict[str, Any]:
    values = asdict(analysis)
    return {"analysis": _WORDS[type(analysis)], **values, **values.pop("spectrum", {})}


def _print(document: Mapping[str, Any]) -> None:
    print_line(f"{document['file']}: {document['title']}")
    made = [document["models"] or "", document["die"] or ""]
    told = ", ".join(m for m in (document["dialect"], *made) if m)
    print_line(f"{told}; circuit {document['circuit']} of {len(document['circuits'])} in all\n")
    counts = [*document["devices"].items(), ("node", document["node_count"])]
    print_table("contents", ("what", "count:"), counts)
    ports = [(p["name"], p["kind"], p["direction"]) for p in document["ports"]]
    print_table("ports", ("name", "kind", "direction"), ports)
    units = {"voltage": "V", "current": "A"}
    sources = [
        (s["name"], s["node"], s["quantity"], s["waveform"], _value(s, units[s["quantity"]]))
        for s in document["sources"]
    ]
    print_table("sources", ("name", "node", "quantity", "waveform", "value:"), sources)
    runs = [(a["analysis"], ", ".join(f"{k}={v}" for k, v in a.items() if k != "analysis")) for a in
            document["analyses"]]  # fmt: skip
    print_table("analyses", ("analysis", "values"), runs)
    if document["steps"]:
        steps = [(s["place"], s["name"], ", ".join(f"{v:g}" for v in s["values"])) for s in document["steps"]]
        print_table("steps, which noctule sweep goes over", ("at", "of", "values"), steps)
    if document["measures"]:
        print_table("measures", ("analysis", "expression"), [tuple(m.values()) for m in document["measures"]])
    _print_foreign(document["foreign"])
    for title, key in (("not taken over", "notes"), ("dropped by --drop", "dropped")):
        if document[key]:
            rows = [(n["place"], n["what"], n["count"]) for n in document[key]]
            print_table(title, ("first at", "what", "count:"), rows)
    if document["names"]:
        print_table("names that were changed", ("here", "in the netlist"), list(document["names"].items()))


def _print_foreign(cards: Sequence[Mapping[str, Any]]) -> None:
    if not cards:
        return
    rows = [(c["place"], c["reason"]) for c in cards[:_FOREIGN_SHOWN]]
    print_table(f"{len(cards)} cards for ngspice only", ("at", "why"), rows)
    if len(cards) > _FOREIGN_SHOWN:
        print_line(f"{len(cards) - _FOREIGN_SHOWN} more; --json has all")


def _value(source: Mapping[str, Any], unit: str) -> str:
    return quantity_cell(source["value"], unit) if "value" in source else ""
