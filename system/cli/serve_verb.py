"""The verb `noctule serve`, with its options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from system.cli import shared_options as shared
from system.cli.shared_options import BlockValues
from system.cli.verb import argument, like
from system.option import option
from system.options.silicon import SiliconChoice


@dataclass(frozen=True, slots=True, kw_only=True)
class Serve:
    """Serve a chip's events to other programs, at a port.

    It talks over TCP or UDP, ends by Ctrl-C, and says what became of all events.
    """

    chip: str = argument(
        "CHIP",
        "A chip that is driven live, loopback without one, or FILE.py:NAME that opens one",
        names="chips.live.table:live_names",
    )
    bias_file: str | None = like(BlockValues, "bias_file")
    program: str | None = option(
        None,
        "Of rolls: what map made, a CSV of post,pre,level, pushbot, or FILE.py:NAME; of others: map, network",
        metavar="FILE",
    )  # fmt: skip
    bias_kind: Literal["gate", "ideal", "generator"] = option(
        "generator", "Fixed gates, ideal PTAT currents, or the bias generator"
    )
    silicon: SiliconChoice = shared.silicon_part(
        "at", "process", "law", "allow_implausible", "heal", "only", "deviate"
    )
    silicon_noise: Literal["off", "white", "all"] = option("off", "Of the chip's devices")
    seed: int = option(0, "Of that noise")
    pace: Literal["fast", "real"] = option("fast", "As fast as events come, or by the wall's clock")
    tick: str = option("1ms", "Time between two looks at the chip at real pace", metavar="TIME")
    port: int = option(8990, "Port to listen at; 0 is any that is free")
    host: str = option("127.0.0.1", "Address to listen at; the loopback alone unless given", metavar="HOST")
    udp: bool = option(default=False, about="Over UDP instead of TCP")
    format: Literal["noctule", "jaer"] = option("noctule", "Records of the stream")
    to: str | None = option(
        None, "Where spikes go over UDP; to those who send, unless given", metavar="HOST:PORT"
    )
    map: str | None = shared.file_option("CSV of from,to: clients' addresses, and the chip's")
    duration: str | None = option(None, "Wall-clock time after which it ends, as 10s", metavar="TIME")
    once: bool = option(default=False, about="End when the last client has gone")
    as_json: bool = shared.json_option()
