"""The model chooses what the transistors choose, on the same devices of the same dies."""

import numpy as np
import pytest

from chips.selection.kernel import Selection, decide
from chips.selection.measure import random_profile
from chips.selection.model import MARGIN, decision, selection, selection_errors
from chips.selection.whole_kernel import NOBODY
from circuits.bias import rebias
from circuits.blocks.selection import winner_take_all as block
from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

SMALL = block.Params(cells=8)
NONE = np.full(8, block.STANDING)


def excitation(contrast: float, n: int = 8) -> np.ndarray:
    """Two cells in the middle, which see as many neighbours, the others at 0.7."""
    found = np.full(n, 35e-9)
    found[n // 2 - 1], found[n // 2] = 50e-9, 50e-9 * (1.0 - contrast)
    return found


def test_without_deviations_the_greatest_current_wins() -> None:
    chip = selection(Silicon(AMI_1500_IDEAL))
    excite, risk = np.full(block.CELLS, 30e-9), np.full(block.CELLS, block.STANDING)
    excite[20], excite[7] = 52e-9, 60e-9
    assert decision(chip, excite, risk).winner == 7
    risk[9] = 60e-9  # e^-1 of it reaches cell 7
    found = decision(chip, excite, risk)
    assert found.winner == 20
    scratch = np.empty((4, block.CELLS))
    decide(chip, excite, risk, scratch)
    rows = np.exp(-((np.arange(-3, 4) / 2.0) ** 2)) @ risk[4:11]
    assert scratch[0, 7] == pytest.approx(60e-9 - rows, rel=1e-12)


@pytest.mark.parametrize("contrast", [0.1, 0.01, 0.001])
def test_the_time_is_that_of_the_circuit(contrast: float) -> None:
    """Eight cells without deviations: within 5 %, the overlaps' coupling and the inverters."""
    excite = excitation(contrast)
    circuit = block.build(SMALL)
    bench = block.decision_testbench(circuit, excite, NONE, block.RELEASE + 20e-6 + 1e-6 / contrast, 5.0)
    solved = simulate(bench, Silicon(AMI_1500_IDEAL))
    found = decision(selection(Silicon(AMI_1500_IDEAL), SMALL), excite, NONE)
    assert block.lines_high(solved).tolist() == [found.winner]
    assert found.time == pytest.approx(block.decision_time(solved), rel=0.05)


@pytest.mark.parametrize("temperature", [-20.0, 27.0, 85.0])
@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
def test_a_die_decides_as_its_transistors(kind: str, temperature: float) -> None:
    """A contrast of 1 % is less than the spread of cells: who wins is the die's."""
    circuit = rebias(block.build(SMALL), kind=kind)
    excite = excitation(0.01)
    for number in (1000, 1001, 1002):
        silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature, die=Die(number=number))
        found = decision(selection(silicon, SMALL, circuit), excite, NONE)
        assert found.certain
        stop = block.RELEASE + 2.0 * found.time + 10e-6
        solved = simulate(block.decision_testbench(circuit, excite, NONE, stop, 5.0), silicon)
        assert block.lines_high(solved).tolist() == [found.winner]
        # the record of the model's docstring has 11 % rms at -20 degC, where long decisions weigh most
        assert found.time == pytest.approx(block.decision_time(solved), rel=0.25)


def test_dies_choose_differently() -> None:
    excite = excitation(0.01)
    chips = [selection(Silicon(AMI_1500_IDEAL, die=Die(number=n)), SMALL) for n in range(1000, 1020)]
    assert {decision(chip, excite, NONE).winner for chip in chips} >= {3, 4}


def test_the_gains_are_those_of_the_transistor_level() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1002, process=False))
    chip = selection(silicon, SMALL)
    machine = to_kernel(
        block.decision_testbench(block.build(SMALL), excitation(0.1), NONE, 1e-3, 5.0), silicon
    )
    t = machine.kernel.transistors
    labels = [
        g.label(k)
        for g in machine.flat.groups
        if isinstance(g.device, Transistor)
        for k in range(g.nodes.shape[1])
    ]

    def shift(name: str) -> float:
        k = labels.index(name)
        model = AMI_1500_IDEAL.n if t.sign[k] > 0.0 else AMI_1500_IDEAL.p
        return float((t.v_t0[k] - model.v_t0) * t.kappa[k] * 2.0 * t.inverse_2ut[k])

    for k in (0, 5):
        apart = shift(f"cell[{k}].my") - shift(f"cell[{k}].mx")
        assert chip.excite_threshold[k] == pytest.approx(apart, abs=1e-12)
        assert chip.cell_threshold[k] == pytest.approx(shift(f"cell[{k}].m1"), abs=1e-12)
        assert chip.share_threshold[k] == pytest.approx(shift(f"cell[{k}].m2"), abs=1e-12)
    # cell 2 takes the risk of cell 4 with mg2_5
    apart = shift("mg2_5") - shift("cell[4].mk")
    assert chip.risk_threshold[2, 5] == pytest.approx(apart, abs=1e-12)
    assert chip.risk_threshold[0, 0] == 0.0  # there is no cell -3


def test_a_larger_area_spreads_less_by_pelgrom() -> None:
    small, large = (selection(Silicon(AMI_1500_IDEAL, die=Die(number=1000)), area=a) for a in (1.0, 4.0))
    assert large.excite_threshold == pytest.approx(0.5 * small.excite_threshold)
    assert large.risk_threshold == pytest.approx(0.5 * small.risk_threshold)


def test_the_time_diverges_at_a_tie_and_the_answer_is_not_certain() -> None:
    chip = selection(Silicon(AMI_1500_IDEAL), SMALL)
    times = [decision(chip, excitation(c), NONE).time for c in (1e-4, 1e-5)]
    assert times[1] / times[0] == pytest.approx(10.0, rel=0.02)
    tie = decision(chip, excitation(0.0), NONE)
    assert tie.time == np.inf
    assert tie.margin == 0.0
    assert not tie.certain
    assert decision(chip, excitation(2.0 * MARGIN), NONE).certain


def test_nobody_wins_where_the_risks_are_above_all_excitations() -> None:
    found = decision(selection(Silicon(AMI_1500_IDEAL), SMALL), np.full(8, 5e-9), np.full(8, 20e-9))
    assert (found.winner, found.time, found.certain) == (NOBODY, np.inf, False)


def test_every_random_profile_has_an_answer() -> None:
    generator = np.random.default_rng(1)
    chip: Selection = selection(Silicon(AMI_1500_IDEAL, die=Die(number=1003)))
    for _ in range(200):
        profile = random_profile(generator)
        found = decision(chip, profile.excite, profile.risk)
        assert 0 <= found.winner < block.CELLS
        assert found.time > 0.0
        assert found.margin >= 0.0


def test_what_is_none_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"selection\.area: 0 times the circuits', must be > 0"):
        selection(Silicon(AMI_1500_IDEAL), area=0.0)
    with pytest.raises(ParameterError, match=r"selection\.currents: .* must be \(8,\) both"):
        decision(selection(Silicon(AMI_1500_IDEAL), SMALL), np.ones(6), np.ones(8))


def test_temperatures_at_which_nothing_was_measured_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"selection.temperature: 90 degC, must be -20 to 85 degC"):
        selection(Silicon(AMI_1500_IDEAL, 90.0))


def test_the_record_tells_the_model_s_errors() -> None:
    errors = selection_errors()
    assert errors["pairs"] == 240.0
    assert errors["winners_differ"] == 0.0
    assert errors["time_rms_relative"] < 0.12  # 11.3 % over 300 pairs at -20 degC, the worst
