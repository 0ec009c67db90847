"""The verb `noctule map`: a network is put on a chip, and the command `noctule show PROGRAM.toml`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from circuits.errors import ParameterError
from circuits.units import format_quantity
from system.cli.map_verb import Map
from system.cli.output import print_json, print_line, print_table, working
from system.mapping.chips import map_on, read_any
from system.mapping.dynamics import Usual, usual_rates
from system.mapping.network import Network
from system.mapping.picture import draw_program
from system.mapping.program_file import check_program_path, read_program_file, write_program
from system.mapping.report import Finding
from system.mapping.rolls.mapped import Mapped
from system.mapping.run import check_channels
from system.plot import check_picture, save_picture
from system.spikes.read import read_spikes

_HOW = ("approximate", "exact")


def map_command(asked: Map) -> None:
    """Put a network on a chip, print what it makes of it, and write the program."""
    check_picture(asked.plot)
    check_program_path(asked.output)
    network = read_any(asked.network)
    with working(f"mapping on {asked.chip}"):
        mapped = map_on(asked.chip, network, _usual(network, asked.input))
    write_program(asked.output, mapped)
    save_picture(asked.plot, partial(draw_program, mapped))
    if asked.as_json:
        print_json({"network": asked.network, "file": asked.output, **document_of(mapped)})
        return
    print_program(f"{asked.network} on {asked.chip}", mapped)
    print_line(f"{asked.output}: written, for noctule show, run and export")


def _usual(network: Network, path: str | None) -> Usual | None:
    """Rates of a network under the events of a file, None without one."""
    if path is None:
        return None
    events = read_spikes(path)
    check_channels(network, events, path)
    if not events.times.size:
        raise ParameterError(f"{path}: no events, must have some; leave it out")
    return usual_rates(network, events, float(events.times[-1]))


def show_program(path: str, given: Sequence[str], plot: str | None, *, as_json: bool) -> None:
    """Print what a chip makes of a network, and draw where it stands.

    given : options of a block that were given. Raises `ParameterError` for any of them.
    """
    if given:
        raise ParameterError(f"{given[0]}: {path} is a program, which has its own; leave it out")
    check_picture(plot)
    mapped = read_program_file(path)
    save_picture(plot, partial(draw_program, mapped))
    if as_json:
        print_json({"file": path, **document_of(mapped)})
    else:
        print_program(path, mapped)


def document_of(mapped: Mapped) -> dict[str, Any]:
    """Give what both commands tell by the names that JSON has for it."""
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
        **{how: sum(f.how == how for f in mapped.findings) for how in _HOW},
        "findings": [asdict(f) for f in mapped.findings],
    }  # fmt: skip


def print_program(title: str, mapped: Mapped) -> None:
    """Print a mapping: what is exact, what is approximate, and by how much."""
    columns = ("where", "what", "how", "asked:", "got:", "off:", "note")
    print_table(title, columns, [_row(f) for f in mapped.findings])
    used = int((mapped.program.levels != 0).sum())
    print_line(
        f"{mapped.network.neurons} of 256 neurons, {used} synapses on"
        f" {np.unique(mapped.program.levels[mapped.program.levels != 0]).size} of 8 levels,"
        f" {mapped.network.channels} channels of inputs"
    )


def _row(found: Finding) -> tuple[str, ...]:
    cells = ["" if x is None else format_quantity(x, found.unit) for x in (found.asked, found.got)]
    return (found.where, found.what, found.how, *cells, f"{found.error:+.1%}", found.note)
