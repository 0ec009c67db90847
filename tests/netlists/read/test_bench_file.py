"""A sub-circuit's testbench from a TOML file."""

from pathlib import Path

import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Resistor, Source
from circuits.devices.source import Constant, Pulse
from circuits.errors import CircuitError
from circuits.testbench import Testbench
from netlists.read.bench_file import read_bench_file

CIRCUIT = Circuit("half", (Port("a", "analog"), Port("b", "analog")), (Resistor("r", "a", "b", 1e3),))
FILE = """title = "driven"
stop = "10us"
watch = ["b"]
[voltages]
a = "pulse(0 5 1u 1n 1n 2u 100u)"
[currents]
b = "-10u"
[start]
b = "1m"
[initial]
b = 0.5
"""


def read(text: str, folder: Path) -> Testbench:
    path = folder / "bench.toml"
    path.write_text(text)
    return read_bench_file(path, CIRCUIT)


def test_it_drives_ports_by_the_text_of_spice(tmp_path: Path) -> None:
    bench = read(FILE, tmp_path)
    assert (bench.title, bench.stop, bench.watch) == ("driven", 1e-5, ("b",))
    assert bench.sources == (
        Source("a", "a", Pulse(0.0, 5.0, (1e-6,), 2e-6, 1e-9, 1e-9)),
        Source("b", "b", Constant(-1e-5), "current"),
    )
    assert (bench.start, bench.initial) == ({"b": 1e-3}, {"b": 0.5})
    assert read("[voltages]\na = 1\n", tmp_path).stop == float("inf")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("stop = ", "no TOML"),
        ("end = 1", "key end: unknown"),
        ("voltages = 1", "voltages is no table"),
        ("[voltages]\nc = 1", "port c: unknown; known are a, b"),
        ("[voltages]\na = 'exp(0 1)'", "exp: not supported"),
        ("[voltages]\na = 'x'", "unknown parameter"),
        ("stop = '1V'", "stop"),
        ("[start]\na = 'b'", "start.a"),
    ],
)
def test_what_is_none_is_refused_in_a_line(text: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(CircuitError, match=says):
        read(text, tmp_path)
