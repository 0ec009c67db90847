"""Networks on ROLLS: their levels, inputs and leaks in the program, and what the chip cannot do."""

import numpy as np
import pytest

from chips.rolls.chip import RollsChip
from chips.rolls.program.address import PAPER_VIRTUAL
from chips.rolls.program.bias_file import DIRECT_CURRENT, BiasTable, default_biases, resting_biases
from chips.rolls.program.network import Network, PopulationInput, network_program
from chips.rolls.program.population import Population, all_to_all, one_to_one
from chips.rolls.program.words import program_of_words, program_words, virtual_columns
from circuits.circuit import BiasKind
from circuits.errors import ParameterError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

A, B = Population("a", (5, 6)), Population("b", (20, 9, 8))


def test_levels_stand_at_post_and_pre() -> None:
    levels = Network((A, B), (all_to_all(A, B, 3), all_to_all(B, A, -1))).levels()
    assert {(int(i), int(j)): int(levels[i, j]) for i, j in np.argwhere(levels)} == {
        **{(post, pre): 3 for post in B.neurons for pre in A.neurons},
        **{(post, pre): -1 for post in A.neurons for pre in B.neurons},
    }


def test_the_program_has_levels_inputs_and_leaks() -> None:
    inputs = (PopulationInput("ear", B, 3), PopulationInput("stop", B, 1, inhibitory=True))
    network = Network((A, B), (one_to_one(A, B.part(0, 2), 4),), inputs, slow=(A, B.part(1, 2)))
    program = network_program(network)
    assert program.levels[20, 5] == program.levels[9, 6] == 4
    assert program.tau1 == (5, 6, 9)
    assert virtual_columns(program)["ear"].tolist() == [[512, 513, 514]] * 3
    assert program.biases == resting_biases()
    written = program_of_words(program_words(program), inputs=program.inputs)
    assert (written.levels == network.levels()).all()
    assert written.tau1 == program.tau1


def test_projections_may_agree_or_leave_out_pairs_but_not_differ() -> None:
    first, second = one_to_one(A, B.part(0, 2), 2), all_to_all(A, B.part(0, 1), 2)
    assert Network((A, B), (first, second)).levels()[20].tolist().count(2) == 2
    with pytest.raises(
        ParameterError,
        match=r"a -> b: level -1 from neuron 5 to 20, must be 2 as in a -> b\[0:2\]; a synapse has one level",
    ):
        Network((A, B), (first, all_to_all(A, B, -1)))


def test_populations_must_be_disjoint_named_and_on_the_chip() -> None:
    with pytest.raises(
        ParameterError, match=r"population.c: neuron 6 is in a too, must be in one population"
    ):
        Network((A, Population("c", (6, 7))))
    with pytest.raises(ParameterError, match=r"population.a: given twice"):
        Network((A, Population("a", (1,))))
    with pytest.raises(ParameterError, match=r"population.d: neuron 256, must be 0 to 255; the chip has 256"):
        Network((Population("d", (255, 256)),))
    assert Network((A, B))["b"] is B
    with pytest.raises(UnknownNameError, match="population c: unknown; known are a, b"):
        Network((A, B))["c"]


def test_ends_that_are_in_no_population_are_refused() -> None:
    stray = Population("stray", (99,))
    with pytest.raises(ParameterError, match="a -> stray: neuron 99 of stray, must be in a population"):
        Network((A,), (all_to_all(A, stray, 1),))
    with pytest.raises(ParameterError, match="input ear: neuron 99 of stray"):
        Network((A,), (), (PopulationInput("ear", stray),))
    with pytest.raises(ParameterError, match="slow leak: neuron 99 of stray"):
        Network((A,), slow=(stray,))


def test_what_the_biases_and_virtual_synapses_lack_is_refused_by_the_program() -> None:
    network = Network((A, B), (all_to_all(A, B, 2),), (PopulationInput("stop", B, inhibitory=True),))
    with pytest.raises(
        ParameterError, match=r"program.levels\[8, 5\]: 2, .*NPA_WEIGHT_EXC0_P has fine code 0"
    ):
        network_program(network, default_biases().with_code("NPA_WEIGHT_EXC0_P", 2, 0))
    with pytest.raises(
        ParameterError, match=r"inputs.stop: 1 inhibitory virtual synapses of neuron 8, .* <= 0"
    ):
        network_program(network, virtual=PAPER_VIRTUAL)


def chip_on(number: int | None, kind: BiasKind, biases: BiasTable | None = None) -> RollsChip:
    network = Network((A, B), (all_to_all(A, B, 2),), slow=(B,))
    return RollsChip(
        network_program(network, biases), Silicon(ROLLS_180_IDEAL, 27.0, Die(number=number)), kind
    )


KINDS: list[BiasKind] = ["gate", "ideal", "generator"]


@pytest.mark.parametrize(
    ("number", "kind"),
    [*((None, kind) for kind in KINDS), (3, "gate"), (1000, "ideal"), (1001, "generator"), (1002, "gate")],
)
def test_a_network_rests_on_the_default_biases(number: int | None, kind: BiasKind) -> None:
    chip = chip_on(number, kind)
    assert not chip.restless().any()
    assert chip.run(chip.at_rest(), 0.1)[0].times.size == 0
    assert not [text for text in chip.cautions() if "without any input" in text]


@pytest.mark.parametrize(("number", "kind"), [(None, "gate"), *((3, kind) for kind in KINDS)])
def test_a_chip_that_does_not_rest_says_so_first(number: int | None, kind: BiasKind) -> None:
    chip = chip_on(number, kind, default_biases())
    assert chip.cautions()[0].startswith("neurons: 256 of 256 fire without any input; turn IF_DC_P down")
    assert chip.run(chip.at_rest(), 0.1)[0].times.size > 0


def test_the_resting_biases_differ_from_the_control_softwares_in_the_direct_current_alone() -> None:
    theirs, ours = default_biases().codes(), resting_biases().codes()
    assert {name for name in theirs if theirs[name] != ours[name]} == {DIRECT_CURRENT}
    assert resting_biases().is_off(DIRECT_CURRENT)
