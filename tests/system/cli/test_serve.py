"""`noctule serve`: a chip of any kind at a port; what became of all events is printed when it ends."""

from __future__ import annotations

import json
import re
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from chips.aer import Events
from circuits.errors import CircuitError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.cli import serve
from system.cli.serve import chip_of
from system.cli.serve_verb import Serve
from system.mapping.network import Connection, Input, Network, Population
from system.mapping.program_file import write_program
from system.mapping.rolls.map import map_on_rolls
from system.mapping.run import run_mapped
from system.stream.client import EventStream
from tests.system.conftest import Run

SIDE = """
import numpy as np
from chips.api import open_chip
from chips.api.rolls import Network, Program

PROGRAM = Program(np.eye(256, dtype=np.int8))
NETWORK = Network(())

def wire():
    return open_chip("loopback")

NUMBER = 5
"""


def test_what_became_of_events_is_printed_at_the_end(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[dict[str, int]] = []
    talking: list[Thread] = []

    def talk(port: int) -> None:
        with EventStream(port) as stream:
            stream.send([1e-3, 2e-3], [5, 6])
            stream.end()
            told.append(stream.counts)

    def say(line: str) -> None:
        found = re.fullmatch(r"loopback listens at 127.0.0.1:(\d+), TCP, noctule format, fast pace", line)
        assert found is not None
        talking.append(Thread(target=talk, args=(int(found[1]),)))
        talking[0].start()

    monkeypatch.setattr(serve, "say", say)
    status, out, _ = run("serve", "loopback", "--port", "0", "--once", "--json")
    talking[0].join(timeout=60.0)
    assert (status, json.loads(out)["events"]["taken"], told[0]["sent"]) == (0, 2, 2)


def test_a_program_or_a_chip_comes_from_a_file_of_python(tmp_path: Path) -> None:
    side = tmp_path / "side.py"
    side.write_text(SIDE)
    assert chip_of(Serve(chip=f"{side}:wire")).inputs[0].name == "event"
    programs = [serve._program(Serve(chip="rolls", program=f"{side}:{n}")) for n in ("PROGRAM", "NETWORK")]
    assert [int(each["program"].levels.sum()) for each in programs] == [256, 0]


def test_a_mapped_network_served_has_the_events_that_its_inputs_send_by_themselves(tmp_path: Path) -> None:
    network = Network(
        (Population("cells", 4),),
        (Input("clock", 1, 800.0), Input("in", 1)),
        (Connection("clock", "cells", 0.4, tau=5e-3), Connection("in", "cells", 0.4, tau=5e-3)),
    )
    mapped = map_on_rolls(network)
    write_program(tmp_path / "program.toml", mapped)
    chip = chip_of(Serve(chip="rolls", program=str(tmp_path / "program.toml")))
    parts = [chip.advance(step) for step in (0.05, 0.0301, 0.1199, 0.1)]
    ran = run_mapped(mapped, Events(np.empty(0), np.empty(0, np.int64)), Silicon(ROLLS_180), 0.3)
    order = np.lexsort((ran.chip.neurons, ran.chip.times))
    assert ran.chip.times.size > 20
    assert np.concatenate([part.times for part in parts]) == pytest.approx(ran.chip.times[order], abs=1e-6)
    with pytest.raises(CircuitError, match=r"b\.csv, the program of .* has its own; leave it out"):
        chip_of(Serve(chip="rolls", program=str(tmp_path / "program.toml"), bias_file="b.csv"))


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"chip": "{side}:NUMBER"}, "NUMBER: gives a int, must be a chip of open_chip"),
        ({"chip": "{side}:wire", "program": "a.csv"}, "wire: opens a chip with its program on its die"),
        ({"chip": "rolls", "program": "{side}:NUMBER"}, "NUMBER: is a int, must be a Program or a Network"),
        ({"chip": "rolls", "program": "{side}:PROGRAM", "bias_file": "b.csv"}, "has its own; leave it out"),
        ({"chip": "rolls"}, "--program: not given, rolls needs one"),
        ({"chip": "nef-chip", "program": "net.txt"}, "net.txt, must be FILE.py:NAME of a network"),
        ({"chip": "ranging-chip", "program": "a.csv"}, "ranging-chip has none; leave them out"),
        ({"chip": "wavefront-chip", "program": "x", "bias_file": "b.csv"}, "only rolls has one"),
        ({"chip": "lso"}, "live chip lso: unknown"),
    ],
)
def test_what_cannot_be_opened_is_refused(options: dict[str, str], told: str, tmp_path: Path) -> None:
    side = tmp_path / "side.py"
    side.write_text(SIDE)
    given = {name: text.format(side=side) for name, text in options.items()}
    with pytest.raises(CircuitError, match=told):
        chip_of(Serve(**given))


def test_times_of_the_command_line_are_above_zero(run: Run) -> None:
    status, _, err = run("serve", "loopback", "--duration", "0s")
    assert (status, err) == (2, "noctule: --duration: 0 s, must be > 0; give more time\n")
