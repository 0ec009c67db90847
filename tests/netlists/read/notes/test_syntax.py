"""What a reader of notes sees in each dialect."""

import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, ControlledSource, Device, Resistor
from circuits.devices.source import Constant, Source
from circuits.errors import DataError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.read.card import Card
from netlists.read.limits import Limits
from netlists.read.note import Notes
from netlists.read.notes.syntax import Syntax, syntax_of
from netlists.registry import DIALECTS

DEVICES: tuple[Device, ...] = (
    Capacitor("c_m_", "v[3]", "0", 1e-15),
    Resistor("r", "gnd", "v[1]", 2.0),
    ControlledSource("g", "a", "0", "v[0]", "time", -1.0),
)


def syntax(dialect: str) -> Syntax:
    found = syntax_of(dialect)
    assert found is not None
    return found


@pytest.mark.parametrize("dialect", sorted(set(DIALECTS) - {"verilog-a"}))  # whose devices all have notes
def test_plain_devices_are_read_from_their_lines(dialect: str) -> None:
    own = syntax(dialect)
    for device in DEVICES:
        lines = own.dialect.devices["ekv"](device, Silicon(AMI_1500_IDEAL))
        found = [own.simple(Card(line, "a.cir", 1)) for line in lines]
        if not (dialect == "cdl" and isinstance(device, ControlledSource)):  # a black box there
            assert found == [device]


@pytest.mark.parametrize("dialect", sorted(set(DIALECTS) - {"verilog-a"}))
def test_a_part_of_a_device_is_no_plain_device(dialect: str) -> None:
    own = syntax(dialect)
    name = "c" + own.dialect.naming.part("m1", "gb")
    text = f"{name} (a b) capacitor c=1.0" if dialect == "spectre" else f"{name} a b 1.0"
    assert own.simple(Card(text, "a.cir", 1)) is None


@pytest.mark.parametrize("dialect", sorted(set(DIALECTS) - {"cdl", "verilog-a"}))  # which have no run
def test_the_run_is_read(dialect: str) -> None:
    own = syntax(dialect)
    circuit = Circuit("c", (Port("a", "supply"),), (Resistor("r", "a", "0", 1.0),))
    bench = Testbench("t", circuit, (Source("a", "a", Constant(1.0)),), 2e-3)
    cards = list(own.write(bench, Silicon(AMI_1500_IDEAL, temperature_c=60.0), "ekv", {}))
    controls = own.run(
        [card for card in cards if own.is_control(card) and card.text != ".end"], Limits(), Notes()
    )
    assert controls.span.stop == 2e-3
    assert controls.temperature_c == 60.0


def test_a_long_word_is_read_once() -> None:
    card = Card("save " + "vdd" * 500_000, "a.cir", 1)
    assert syntax("spectre").run([card], Limits(), Notes()).analyses == []


def test_a_damaged_line_is_refused() -> None:
    with pytest.raises(DataError, match=r"a\.cir:1: rx a b c: must be 2 nodes and a number"):
        syntax("ngspice").simple(Card("rx a b c", "a.cir", 1))


def test_no_other_dialect() -> None:
    assert syntax_of("verilog") is None
