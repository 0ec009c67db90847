"""`noctule serve`: a chip of any kind at a port; what became of all events is printed when it ends."""

from __future__ import annotations

import json
import re
from pathlib import Path
from threading import Thread

import pytest

from circuits.errors import CircuitError
from system.cli import serve
from system.cli.serve import chip_of
from system.cli.serve_verb import Serve
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
