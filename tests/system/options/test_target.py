"""A target is a name, a file or an object, and every one is a block by the same way."""

from pathlib import Path

import pytest
from PySpice.Spice.Netlist import Circuit as TheirCircuit

from circuits.circuit import Circuit
from circuits.errors import CircuitError, ParameterError
from circuits.registry import load_block
from circuits.silicon.process import ROLLS_180
from circuits.solver.operating_point import operating_point
from system.options.block import choose
from system.options.silicon import SiliconChoice
from system.options.target import file_of, load_target, split_place
from tests.refusals import refusals
from tests.system.options.mine import FOLLOWER


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "mine.py").write_text(FOLLOWER)
    (tmp_path / "broken.py").write_text("x = 1\ndef f(:\n")
    (tmp_path / "fails.py").write_text("x = 1\nraise KeyError('gone')\n")
    (tmp_path / "exits.py").write_text("import sys\nsys.exit(3)\n")
    (tmp_path / "small.py").write_text(
        "from circuits.silicon.process import ROLLS_180\nfrom mine import CIRCUIT\nPROCESS = ROLLS_180\n"
    )
    (tmp_path / "odd.py").write_text("from mine import CIRCUIT\nPROCESS = 3\n")
    (tmp_path / "rc.cir").write_text("an rc\nr1 a b 1k\nc1 b 0 1p\nv1 a 0 1\n.tran 1n 1u\n.end\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_name_a_file_and_an_object_are_blocks() -> None:
    assert load_target("rebound-neuron") is load_block("rebound-neuron")
    assert load_target(load_block("rebound-neuron")) is load_block("rebound-neuron")
    assert load_target("mine.py:follower").name == "mine.py:follower"
    assert load_target("rc.cir").name == "rc.cir"
    made = choose("mine.py:CIRCUIT").circuit
    assert choose(made).circuit == made == choose("mine.py:integrator").circuit


def test_options_reach_a_function_s_arguments() -> None:
    found = choose("mine.py:follower", ["w=4um"], ["i_b=20nA"], stimuli=["step_V=0.3V"])
    assert found.circuit.device("tail").width == 4e-6
    assert found.circuit.bias("i_b").value == 20e-9
    bench = found.testbench()
    assert bench.circuit == found.circuit
    assert bench.sources[1].waveform.value[-1] == 2.3
    slow = choose("mine.py:follower", silicon=SiliconChoice(process="rolls-180"), stimuli=["low_V=1V"])
    assert slow.testbench().sources[0].waveform.value == ROLLS_180.v_dd


def test_a_circuit_of_pyspice_is_one() -> None:
    theirs = TheirCircuit("divider")
    theirs.V("in", "a", theirs.gnd, 2.0)
    theirs.R(1, "a", "b", 1e3)
    theirs.R(2, "b", theirs.gnd, 1e3)
    for target in (theirs, lambda: theirs):
        found = choose(target)
        point = operating_point(found.testbench(), found.silicon)
        assert point.voltages()["b"] == pytest.approx(1.0)


def test_a_block_stands_at_a_place_in_a_chip_of_a_file() -> None:
    there = choose("mine.py:integrator", silicon=SiliconChoice(at="mine.py:pair/cell[1]", die=3))
    assert there.circuit.bias("i_b").value == 20e-9
    assert there.silicon.place == (("pair", ()), ("cell", (1,)))
    assert split_place("a/b.py:pair/cell[1]/x") == ("a/b.py:pair", ["cell[1]", "x"])
    assert split_place("ranging-chip/neuron[2]") == ("ranging-chip", ["neuron[2]"])


def test_a_file_says_its_process_and_imports_its_neighbours() -> None:
    found = choose("small.py:CIRCUIT", stimuli=["v_in=1V"])
    assert found.silicon.process == ROLLS_180
    assert isinstance(found.circuit, Circuit)


def test_prints_of_a_user_s_code_go_to_stderr(capsys: pytest.CaptureFixture[str]) -> None:
    load_target("mine.py:chatty")
    out, err = capsys.readouterr()
    assert out == ""
    assert "hello" in err


def test_files_are_known_by_their_names() -> None:
    assert file_of("a/mine.py:x") == Path("a/mine.py")
    assert file_of("a/deck.SP:amp") == Path("a/deck.SP")
    assert file_of("rebound-neuron") is None
    assert file_of(load_block("rebound-neuron")) is None


test_what_is_no_target_is_refused = refusals(
    CircuitError,
    load_target,
    [
        ("nothing.py:f", r"nothing\.py: No such file or directory"),
        ("nothing.cir", r"nothing\.cir: no such file"),
        ("mine.py", r"mine\.py: which name, must follow as mine\.py:NAME; it has .*integrator, follower"),
        ("mine.py:folower", r"mine\.py: name folower: unknown; did you mean follower\?"),
        ("mine.py:broken", r"mine\.py:\d+: ZeroDivisionError: division by zero; mend the file"),
        ("mine.py:other", r"mine\.py:other: is of type int, must be a Circuit, Testbench, Block"),
        ("mine.py:PORTS", r"mine\.py:PORTS: is of type tuple, must be a Circuit"),
        ("mine.py:sized", r"mine\.py:sized: argument w: has no default"),
        ("broken.py:f", r"broken\.py:2: invalid syntax; mend the file"),
        ("fails.py:f", r"fails\.py:2: KeyError: 'gone'; mend the file"),
        ("exits.py:f", r"exits\.py:2: SystemExit: 3; mend the file"),
        ("odd.py:CIRCUIT", r"odd\.py: PROCESS is of type int, must be a Process"),
        ("rc.cir:amp", r"rc\.cir: subcircuit amp: unknown"),
        ("reboundneuron", "block reboundneuron: unknown; did you mean rebound-neuron"),
        (3, "int: is of type int, must be a Circuit"),
    ],
)


def test_an_error_of_a_file_names_it_once(tmp_path: Path) -> None:
    (tmp_path / "load.py").write_text(
        "from circuits.api import Circuit, Port, Resistor\n"
        "def f(ohm=1e3):\n"
        '    return Circuit("f", (Port("a", "analog"),), (Resistor("r", "a", "0", ohm),))\n'
    )
    with pytest.raises(ParameterError, match=r"^load\.py:3: r\.resistance: -1 Ohm, must be > 0"):
        choose("load.py:f", ["ohm=-1"])


def test_a_process_stated_without_second_order_effects_is_said_to_run_with_them(tmp_path: Path) -> None:
    file = tmp_path / "plain.py"
    file.write_text(
        "from circuits.api import Circuit, Port, ROLLS_180_IDEAL, Resistor\nPROCESS = ROLLS_180_IDEAL\n"
        "ONE = Circuit('one', (Port('v', 'analog'),), (Resistor('r', 'v', '0', 1e6),))\n"
    )
    with pytest.warns(UserWarning, match="without second-order effects and runs with them; choose law ideal"):
        found = choose(f"{file}:ONE", stimuli=["v=1V"])
    assert found.silicon.process == ROLLS_180
    choose(f"{file}:ONE", stimuli=["v=1V"], silicon=SiliconChoice(law="ideal"))
