"""The verb `noctule map`: a network is put on a chip, and the command `noctule show PROGRAM.toml`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from circuits.errors import ParameterError
from circuits.units import format_quantity, parse_quantity
from system.cli.map_verb import Map
from system.cli.nef_program import document_of_values, size_of_values
from system.cli.output import print_json, print_line, print_table, working
from system.mapping.certify.ends import output_names
from system.mapping.chips import (
    AnyMapped,
    AnyNetwork,
    map_on,
    read_any,
    read_any_program,
    write_any_program,
)
from system.mapping.dynamics import Usual, usual_rates
from system.mapping.nef.picture import draw_values
from system.mapping.network import Network
from system.mapping.nir.read import SUFFIX, Judged, Times, judged, read_graph
from system.mapping.picture import draw_program
from system.mapping.program_file import check_program_path
from system.mapping.report import Finding, counted
from system.mapping.rolls.mapped import Mapped
from system.mapping.run import check_channels
from system.plot import check_picture, save_picture
from system.spikes.read import read_spikes

FOREVER = 1.0  # s, of a membrane: three times as long as the longest of ROLLS; ours


def map_command(asked: Map) -> None:
    """Put a network on a chip, print what it makes of it, and write the program."""
    check_picture(asked.plot)
    check_program_path(asked.output)
    network = read_any(asked.network, _times(asked))
    nodes = judged(read_graph(asked.network)) if asked.network.lower().endswith(SUFFIX) else ()
    if nodes and asked.graph_unit is None:
        _check_seconds(network)
    with working(f"mapping on {asked.chip}"):
        mapped = map_on(asked.chip, network, _usual(network, asked.input))
    write_any_program(asked.output, asked.chip, mapped)
    _draw(asked.plot, mapped)
    if asked.as_json:
        told = {"network": asked.network, "file": asked.output, "nodes": [each._asdict() for each in nodes]}
        print_json({**told, **document_of(mapped)})
        return
    if nodes:
        print_table(f"{asked.network}, node by node", Judged._fields, nodes)
    print_program(f"{asked.network} on {asked.chip}", mapped)
    verbs = "show, run and export" if isinstance(mapped, Mapped) else "show and run"
    print_line(f"{asked.output}: written, for noctule {verbs}")


def _times(asked: Map) -> Times:
    """What a graph's numbers mean."""
    unit, event = (
        None if text is None else parse_quantity(text, "s", name)
        for text, name in ((asked.graph_unit, "graph_unit"), (asked.graph_event, "graph_event"))
    )
    return Times(1.0 if unit is None else unit, event)


def _check_seconds(network: AnyNetwork) -> None:
    """Raise `ParameterError` for a membrane that no chip has, as of a graph that counts otherwise."""
    for p in network.populations if isinstance(network, Network) else ():
        if p.tau >= FOREVER:
            raise ParameterError(
                f"{p.name}.tau: {p.tau:g} s, no chip has such a membrane; say what 1 is of the graph's times,"
                " as by `graph_unit=1ms`"
            )


def _usual(network: AnyNetwork, path: str | None) -> Usual | None:
    """Rates of a network under the events of a file, None without one."""
    if path is None:
        return None
    if not isinstance(network, Network):
        raise ParameterError(f"input: {path}, a network of values is met at all of them; leave it out")
    events = read_spikes(path)
    check_channels(network, events, path)
    if not events.times.size or not events.times[-1] > 0.0:
        raise ParameterError(f"{path}: no events after 0 s, must have some; leave it out")
    return usual_rates(network, events, float(events.times[-1]))


def show_program(path: str, given: Sequence[str], plot: str | None, *, as_json: bool) -> None:
    """Print what a chip makes of a network, and draw where it stands.

    given : options of a block that were given. Raises `ParameterError` for any of them.
    """
    if given:
        raise ParameterError(f"{given[0]}: {path} is a program, which has its own; leave it out")
    check_picture(plot)
    mapped = read_any_program(path)
    _draw(plot, mapped)
    if as_json:
        print_json({"file": path, **document_of(mapped)})
    else:
        print_program(path, mapped)


def _draw(plot: str | None, mapped: AnyMapped) -> None:
    draw = partial(draw_program, mapped) if isinstance(mapped, Mapped) else partial(draw_values, mapped)
    save_picture(plot, draw)


def document_of(mapped: AnyMapped) -> dict[str, Any]:
    """Give what both commands tell by the names that JSON has for it."""
    if not isinstance(mapped, Mapped):
        return document_of_values(mapped)
    return {
        "chip": "rolls",
        "neurons": mapped.network.neurons,
        "synapses": int((mapped.program.levels != 0).sum()),
        "channels": mapped.network.channels,
        "populations": [{"name": p.name, "first": p.first, "slow_leak": p.slow} for p in mapped.placed],
        "filters": [
            {"name": f.name, "tau_s": f.tau, "power": f.power, "weights_A": f.weights}
            for f in mapped.filters
        ],
        **counted(mapped.findings),
        "findings": [asdict(f) for f in mapped.findings],
    }  # fmt: skip


def print_program(title: str, mapped: AnyMapped) -> None:
    """Print a mapping: what is exact, what is approximate, and by how much."""
    columns = ("where", "what", "how", "asked:", "got:", "off:", "note")
    print_table(title, columns, [_row(f) for f in mapped.findings])
    if not isinstance(mapped, Mapped):
        print_line(size_of_values(mapped))
        if mapped.network.probes:
            _print_outputs(output_names(mapped.network))
        return
    used = int((mapped.program.levels != 0).sum())
    print_line(
        f"{mapped.network.neurons} of 256 neurons, {used} synapses on"
        f" {np.unique(mapped.program.levels[mapped.program.levels != 0]).size} of 8 levels,"
        f" {mapped.network.channels} channels of inputs"
    )
    if mapped.network.probes:  # a graph of NIR comes back in the order of the alphabet
        _print_outputs([probe.name for probe in mapped.network.probes])


def _print_outputs(names: Sequence[str]) -> None:
    told = ", ".join(f"{k} {name!r}" for k, name in enumerate(names))
    print_line(f"outputs by their labels, as train and certify count them: {told}")


def _row(found: Finding) -> tuple[str, ...]:
    cells = ["" if x is None else format_quantity(x, found.unit) for x in (found.asked, found.got)]
    return (found.where, found.what, found.how, *cells, f"{found.error:+.1%}", found.note)
