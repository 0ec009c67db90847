"""The file of a die: what is written is read again, and what is wrong is one line."""

import pytest

from circuits.errors import DataError, ParameterError
from circuits.silicon.die import Die
from circuits.silicon.sampling import Sampling
from system.options.block import read_die
from system.options.die.file import read_die_file, with_die, write_die_file
from system.options.silicon import SiliconChoice

EDITED = (
    Die("B", 1003, "ss", process=False, variation="full")
    .only("chip/neuron[2]", "process")
    .healed("chip/*.m1")
    .with_("chip/neuron[2].m3", "v_t0", 0.0123456789)
    .with_("chip/neuron[2].c", "capacitance", -0.03)
)


@pytest.mark.parametrize("die", [Die(), EDITED])
def test_round_trip(die, tmp_path):
    write_die_file(tmp_path / "die.toml", die)
    assert read_die_file(tmp_path / "die.toml") == die
    assert read_die(with_die(SiliconChoice(die=str(tmp_path / "die.toml")))) == die


def test_values_have_units(tmp_path):
    path = tmp_path / "die.toml"
    path.write_text('[[deviation]]\npath = "a.b"\nparameter = "v_t0"\nvalue = "12mV"\n'
                    '[[deviation]]\npath = "a.b"\nparameter = "beta"\nvalue = "3%"\n')  # fmt: skip
    assert [e.value for e in read_die_file(path).edits] == [0.012, 0.03]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("heal = 3\n", "heal"),
        ("number = 3\n", "number"),
        ('corner = "cold"\n', "corner"),
        ("die = -1\n", "whole number"),
        (
            '[[deviation]]\npath = "a"\nparameter = "v_t0"\nvalue = "12"\n',
            r"a\.v_t0: \"12\", must be a voltage",
        ),
        ('[[deviation]]\npath = "a"\nparameter = "size"\nvalue = "12"\n', r"a\.size, must end with one of"),
        ("lot = \n", "die.toml"),
        ("", r'states nothing, must state a die; lot = "A" alone is the nominal die'),
        ("\n# a comment\n", "states nothing"),
    ],
)
def test_refusals_name_the_file(text, told, tmp_path):
    path = tmp_path / "die.toml"
    path.write_text(text)
    with pytest.raises(DataError, match=told) as refused:
        read_die_file(path)
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_nominal_die_is_written_as_a_file_that_states_it(tmp_path):
    path = tmp_path / "die.toml"
    write_die_file(path, Die())
    assert path.read_text() == 'lot = "A"\n'
    assert read_die_file(path) == Die()


def test_file_and_other_options_do_not_both_state_the_die(tmp_path):
    write_die_file(tmp_path / "die.toml", Die(number=4))
    with pytest.raises(ParameterError, match=r"lot: B, .* states the die"):
        with_die(SiliconChoice(die=str(tmp_path / "die.toml"), lot="B"))
    with pytest.raises(ParameterError, match='die: "three", must be a whole number'):
        with_die(SiliconChoice(die="three"))


def test_die_of_a_plan_is_not_written(tmp_path):
    with pytest.raises(ParameterError, match="its own draws"):
        write_die_file(tmp_path / "die.toml", Die(number=0, sampling=Sampling("p", 0, {}, [[]])))


def test_a_path_that_means_no_device_is_told_of_the_option_that_states_it(refused, tmp_path):
    path = tmp_path / "die.toml"
    path.write_text('die = 1003\nheal = ["nothing.m1"]\n')
    for option, value in (
        ("--heal", "nothing.m1"),
        ("--only", "nothing.m1"),
        ("--deviate", "nothing.m1.v_t0=1mV"),
        ("--die", str(path)),
    ):
        told = refused("op", "rebound-neuron", option, value)
        assert told.startswith(f"{option}: nothing.m1, is the path of no device")
