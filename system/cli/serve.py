"""The verb `noctule serve`: a live chip at a port, and at the end what became of all events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from chips.live.chip import LiveChip
from chips.live.table import open_chip
from chips.nef.network.network import Network as NefNetwork
from chips.rolls.program.bias_file import resting_biases
from chips.rolls.program.network import Network, network_program
from chips.rolls.program.program import Program
from circuits.errors import ParameterError
from circuits.units import parse_quantity
from system.cli.output import print_json, print_line
from system.cli.rolls_program_file import PUSHBOT, read_program
from system.cli.serve_verb import Serve
from system.mapping.network_file import SUFFIX
from system.mapping.program_file import read_program_file
from system.mapping.rolls.mapped import own_events
from system.notice import say
from system.options.block import read_die
from system.options.code import code_of, guarded, load_as, load_code
from system.options.noise import silicon_noise
from system.options.silicon import SiliconChoice
from system.pushbot.network.biases import pushbot_biases
from system.rolls.options import bias_table
from system.rover.cost_map import load_map
from system.stream.server import EventServer


def serve_command(asked: Serve) -> None:
    """Serve a chip until Ctrl-C, the end of `duration`, or with `once` until its clients have gone."""
    duration = None if asked.duration is None else _time(asked.duration, "--duration")
    tick = _time(asked.tick, "--tick")
    with EventServer(
        chip_of(asked), f"{asked.host}:{asked.port}", udp=asked.udp, pace=asked.pace, tick=tick,
        form=asked.format, to=asked.to, mapped=asked.map,
    ) as server:  # fmt: skip
        over = "UDP" if asked.udp else "TCP"
        place = server.place
        say(f"{server.hub.chip.path} listens at {place}, {over}, {asked.format} format, {asked.pace} pace")
        with suppress(KeyboardInterrupt):
            server.run(duration, once=asked.once, tell=say)
        report = server.report()
    leave(report, as_json=asked.as_json)


def chip_of(asked: Serve) -> LiveChip:
    """Return the chip that is to be served; raises what `open_chip` and the readers of its files do."""
    code = code_of(asked.chip)
    if code is None:
        given = {**_program(asked), "bias_kind": asked.bias_kind}
        noise = silicon_noise(asked.silicon_noise, asked.seed)
        if noise is not None:
            given["noise"] = noise
        celsius = parse_quantity(asked.silicon.celsius, "degC", "--temperature")
        return open_chip(asked.chip, read_die(asked.silicon), celsius, **given)
    if asked.program is not None or asked.silicon != SiliconChoice():
        raise ParameterError(f"{code}: opens a chip with its program on its die; leave these options out")
    found = load_code(code)
    opened = guarded(found, code.path)() if callable(found) else found
    if not isinstance(opened, LiveChip):
        raise ParameterError(f"{code}: gives a {type(opened).__name__}, must be a chip of open_chip")
    return opened


def leave(report: Mapping[str, Any], *, as_json: bool) -> None:
    """Print what a server did."""
    if as_json:
        print_json(report)
        return
    events = {name: count for name, count in report["events"].items() if count}
    slipped = f", {report['slipped_s']:.3g} s slipped" if report["slipped_s"] else ""
    print_line(f"{report['chip']}: {report['time_s']:.6g} s, {report['clients']} clients{slipped}")
    print_line(", ".join(f"{name} {count}" for name, count in events.items()) or "no events")
    print_line("on the chip: " + (", ".join(f"{k} {n}" for k, n in report["on_chip"].items()) or "no counts"))


def _program(asked: Serve) -> dict[str, Any]:
    """What a chip needs besides its silicon, as `open_chip` takes it."""
    reader = _READERS.get(asked.chip)
    if reader is None and (asked.program or asked.bias_file):
        raise ParameterError(f"--program, --bias-file: {asked.chip} has none; leave them out")
    if asked.bias_file is not None and asked.chip != "rolls":
        raise ParameterError(f"--bias-file: {asked.bias_file}, only rolls has one; leave it out")
    if reader is None:
        return {}
    if asked.program is None:
        raise ParameterError(f"--program: not given, {asked.chip} needs one; see noctule serve --help")
    return reader(asked.program, asked.bias_file)


def _rolls(text: str, biases: str | None) -> dict[str, Any]:
    code = code_of(text)
    if text.endswith(SUFFIX):
        if biases is not None:
            raise ParameterError(f"--bias-file: {biases}, the program of {text} has its own; leave it out")
        mapped = read_program_file(text)
        return {"program": mapped.program, "own": own_events(mapped)}
    if code is None:
        usual = pushbot_biases(law="full") if text == PUSHBOT else resting_biases()
        return {"program": read_program(text, usual if biases is None else bias_table(biases))}
    if biases is not None:
        raise ParameterError(f"--bias-file: {biases}, the program of {code} has its own; leave it out")
    found = load_code(code)
    if isinstance(found, Network):
        found = network_program(found)
    if not isinstance(found, Program):
        raise ParameterError(f"{code}: is a {type(found).__name__}, must be a Program or a Network of rolls")
    return {"program": found}


def _nef(text: str, _: str | None) -> dict[str, Any]:
    network = load_as(text, NefNetwork)
    if network is None:
        raise ParameterError(f"--program: {text}, must be FILE.py:NAME of a network on the NEF chip")
    return {"network": network}


def _wavefront(text: str, _: str | None) -> dict[str, Any]:
    return {"costs": load_map(text).costs}


_READERS: Mapping[str, Callable[[str, str | None], dict[str, Any]]] = {
    "rolls": _rolls,
    "nef-chip": _nef,
    "wavefront-chip": _wavefront,
}


def _time(text: str, name: str) -> float:
    seconds = parse_quantity(text, "s", name)
    if not seconds > 0.0:
        raise ParameterError(f"{name}: {seconds:g} s, must be > 0; give more time")
    return seconds
