"""Data sheets of behavioural neurons."""

import numpy as np
import pytest

from chips.ranging import circuit as ranging_chip
from chips.ranging.model import model_of, neurons_on
from chips.ranging.record import record_of
from chips.ranging.sheet import rebound_sheet
from chips.validity import outside_boxes
from circuits.blocks.sonar import rebound_neuron
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

SILICON = Silicon(AMI_1500_IDEAL, die=Die(number=1003), temperature_c=35.0)


def test_figures_are_those_of_the_model_on_this_die() -> None:
    circuit = ranging_chip.build()
    sheet = rebound_sheet(circuit, SILICON)
    neurons = neurons_on(model_of(circuit, SILICON.process), SILICON)
    assert sheet.shape == (13,)
    for k, figures in enumerate(sheet.figures):
        for name in set(figures) & set(neurons._fields):
            assert figures[name] == getattr(neurons, name)[k]
    assert len({figures["t_inh"] for figures in sheet.figures}) == 13


def test_branches_give_the_model_s_matrix_back() -> None:
    (figures,) = rebound_sheet(rebound_neuron.build(), Silicon(AMI_1500_IDEAL)).figures
    between = {(i, j): figures[f"c_{i}_{j}"] for i, j in (("mem", "r"), ("mem", "ex"), ("r", "ex"))}
    names = ("mem", "r", "ex")
    matrix = np.diag([figures[f"c_{name}"] for name in names])
    for (i, j), c in between.items():
        a, b = names.index(i), names.index(j)
        matrix[[a, b], [a, b]] += c
        matrix[[a, b], [b, a]] -= c
    model = model_of(rebound_neuron.build(), Silicon(AMI_1500_IDEAL).process)
    # inverted once and back: a few rounding errors of the largest entry
    np.testing.assert_allclose(matrix, model.capacitance, rtol=1e-12, atol=1e-27)


def test_remarks_have_the_box_and_every_measured_error() -> None:
    text = "\n".join(rebound_sheet(rebound_neuron.build(), SILICON).remarks)
    record = record_of()
    assert "numbers of one die at 35.0 degC" in text
    assert "valid at -10 to 65 degC" in text
    assert f"threshold shifts within {record.box.threshold:g} V" in text
    assert f"threshold by {record.margin:.3g} V" in text
    for name, value in record.errors.items():
        assert f"{name}: {value:.3g}" in text


def test_outside_the_box_is_refused_or_warned_of() -> None:
    hot = Silicon(AMI_1500_IDEAL, temperature_c=80.0)
    with pytest.raises(ParameterError, match="80 degC, must be -10 to 65 degC"):
        rebound_sheet(rebound_neuron.build(), hot)
    with outside_boxes("warn") as left:
        rebound_sheet(rebound_neuron.build(), hot)
    assert "80 degC" in left.texts()[0]
