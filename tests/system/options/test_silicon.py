"""The same silicon in every command: lot, die, corner, place, and what JSON says of them."""

from typing import Any

import pytest

from chips.ranging import circuit as ranging_chip
from circuits.silicon.die import Die
from system.approach import run as approach
from system.approach.scenario import Scenario
from system.cli.command_line import main
from system.options.block import choose, describe_silicon
from system.options.silicon import SiliconChoice
from tests.refusals import command_refusals
from tests.system.conftest import RunJson

BLOCK = "rebound-neuron"
AT = ("--at", "ranging-chip/neuron[5]")
DIE = ("--lot", "B", "--die", "1003", "--corner", "ff", "--no-mismatch")


@pytest.mark.parametrize("command", [("show",), ("op",), ("simulate",), ("export", "-o", "-")])
def test_every_command_says_which_die(command: tuple[str, ...], run_json: RunJson) -> None:
    found = run_json(command[0], BLOCK, *command[1:], *DIE, *AT)
    said = {k: found[k] for k in ("lot", "die", "corner", "mismatch", "process_variation", "at")}
    assert said == {
        "lot": "B",
        "die": 1003,
        "corner": "ff",
        "mismatch": False,
        "process_variation": True,
        "at": "ranging_chip/neuron[5]",
    }


def test_the_nominal_die_is_the_default(run_json: RunJson) -> None:
    found = run_json("op", BLOCK)
    assert (found["die"], found["at"]) == (None, None)
    assert run_json("op", BLOCK, "--corner", "typical")["voltages_V"] == found["voltages_V"]
    assert run_json("op", BLOCK, "--lot", "Z")["voltages_V"] == found["voltages_V"]


def test_dies_lots_corners_and_places_differ_and_come_again(run_json: RunJson) -> None:
    variants = [
        (),
        ("--die", "1"),
        ("--die", "2"),
        ("--die", "1", "--lot", "B"),
        ("--die", "1", "--no-mismatch"),
        ("--die", "1", "--no-process-variation"),
        ("--corner", "ss"),
        ("--die", "1", "--at", "ranging-chip/neuron[2]"),
        ("--die", "1", "--at", "ranging-chip/neuron[3]"),
    ]
    found = [run_json("op", BLOCK, *v)["voltages_V"]["v_mem"] for v in variants]
    assert len(set(found)) == len(variants)
    assert [run_json("op", BLOCK, *v)["voltages_V"]["v_mem"] for v in variants[:3]] == found[:3]


def test_a_place_brings_biases_which_options_can_replace() -> None:
    there = choose(BLOCK, silicon=SiliconChoice(at="ranging-chip/neuron[5]"))
    assert there.circuit.bias("i_inh_tau").value == ranging_chip.I_INH_TAU[5]
    assert there.silicon.place == (("ranging_chip", ()), ("neuron", (5,)))
    changed = choose(BLOCK, ["axon-capacitance=200fF"], ["i_inh_tau=1nA"], silicon=SiliconChoice(at=AT[1]))
    assert changed.circuit.bias("i_inh_tau").value == 1e-9
    assert changed.circuit.bias("i_ex_tau").value == ranging_chip.I_EX_TAU[5]
    assert changed.circuit.device("axon.c_ax").parameters() == {"capacitance": 200e-15}
    assert describe_silicon(changed.silicon)["at"] == "ranging_chip/neuron[5]"


test_bad_silicon_is_one_line = command_refusals(
    "op",
    BLOCK,
    rows=[
        ("--die -1", "die: -1, must be a whole number"),
        ("--die 1.5", "--die"),
        ("--corner slow", "is not one of"),
        ("--at ranging-chip", "must be CHIP/INSTANCE; instances of ranging-chip are neuron[0:13]"),
        ("--at 'ranging-chip/neuron[13]'", "known are neuron[0:13]"),
        ("--at ranging-chip/neuron", "known are neuron[0:13]"),
        ("--at 'ranging-chip/neu ron[1]'", "not a node name"),
        ("--at 'rangin-chip/neuron[1]'", "did you mean ranging-chip"),
        ("--at 'ranging-chip/neuron[1]/membrane'", "is a membrane, must be a rebound_neuron"),
    ],
)


def test_the_title_of_a_netlist_names_the_die(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", BLOCK, "-o", "-", "--die", "7", *AT]) == 0
    title, *lines = capsys.readouterr().out.splitlines()
    assert "die A/7" in title
    assert "ranging_chip/neuron[5]" in title
    assert main(["export", BLOCK, "-o", "-", "--die", "8", *AT]) == 0
    assert capsys.readouterr().out.splitlines()[1:] != lines


def test_the_neurons_of_the_approach_are_the_chip_s() -> None:
    loop = approach.build(Scenario(die=Die(number=1003), codes="default"))
    for k in (0, 5):
        choice = choose(BLOCK, silicon=SiliconChoice(die=1003, at=f"ranging-chip/neuron[{k}]"))
        cell: Any = loop.parts[f"neuron[{k}]"]
        assert cell.machine.silicon == choice.silicon
        assert cell.machine.testbench.circuit == choice.circuit
    board: Any = loop.parts["centroid"]
    assert board.machine.silicon == choose("centroid-board", silicon=SiliconChoice(die=1003)).silicon


def test_an_approach_runs_on_a_die(run_json: RunJson) -> None:
    nominal, die = (
        run_json("run", "approach", "--duration", "0.25s", "--die", number) for number in ("nominal", "1000")
    )
    assert (nominal["die"], die["die"]) == (None, 1000)
    assert nominal["calls_s"] != die["calls_s"]
