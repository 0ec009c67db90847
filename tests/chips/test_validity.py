"""Outside a box a run is refused, or goes on and is told; one rule for every model."""

from __future__ import annotations

import math
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import replace

import pytest

from chips.latency.chip import LatencyChip
from chips.latency.errors import usual_design
from chips.latency.model import usual_biases
from chips.model import MODELS, Model, load_model
from chips.nef.chip import NefChip
from chips.rolls.validity import check_supply
from chips.selection.model import selection
from chips.validity import outside_boxes, require_area, require_inside
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

BOX = (-10.0, 65.0)


def test_inside_nothing_happens() -> None:
    with outside_boxes("refuse") as left:
        for value in (*BOX, 27.0):
            require_inside("chip.temperature", value, BOX, "degC")
    assert left.texts() == ()


@pytest.mark.parametrize("value", [-10.1, 65.1, math.nan, math.inf])
def test_outside_is_refused_with_path_value_side_and_remedy(value: float) -> None:
    said = rf"chip\.temperature: {value:.3g} degC, must be -10 to 65 degC, where .* measured; use the trans"
    with pytest.raises(ParameterError, match=said) as alone:
        require_inside("chip.temperature", value, BOX, "degC")
    assert "outside" not in str(alone.value)  # nobody has asked how to go on
    with outside_boxes("refuse"), pytest.raises(ParameterError, match=f"{said}.*, or give `outside=warn`"):
        require_inside("chip.temperature", value, BOX, "degC")


def test_a_warning_goes_on_and_tells_the_worst_of_every_side_once() -> None:
    with outside_boxes("warn") as left:
        for value in (70.0, 90.0, 80.0, 27.0):
            require_inside("chip.temperature", value, BOX, "degC")
        require_area("chip", 0.1, 0.25)
        with outside_boxes("refuse"), pytest.raises(ParameterError):
            require_area("chip", 0.01, 0.25)
    measured = "where the behavioural model was measured"
    assert left.texts() == (
        f"chip.temperature: 90 degC, must be -10 to 65 degC, {measured}",
        f"chip.area: 0.1 times the circuits', must be at least 0.25 times the circuits', {measured}",
    )


@pytest.mark.parametrize("area", [0.0, -1.0, math.inf, math.nan])
def test_an_area_that_is_none_is_refused_whatever_is_asked(area: float) -> None:
    with outside_boxes("warn"), pytest.raises(ParameterError, match=r"chip\.area: .* must be > 0 and finite"):
        require_area("chip", area, 0.25)


def test_a_thread_with_the_context_has_the_answer() -> None:
    with outside_boxes("warn") as left, ThreadPoolExecutor(1) as executor:
        executor.submit(copy_context().run, require_inside, "chip.area", 3.0, (0.0, 1.0), "").result()
    assert len(left.texts()) == 1


@pytest.mark.parametrize("model", [load_model(name) for name in MODELS], ids=lambda m: m.name)
def test_every_measured_model_goes_on_outside_its_box_where_that_is_asked(model: Model) -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=110.0)
    with pytest.raises(ParameterError, match="temperature: 110 degC, must be"):
        model.load(silicon)
    # a hearing that is deaf says so
    with outside_boxes("warn") as left, warnings.catch_warnings(action="ignore"):
        assert model.load(silicon) is not None
    assert any("temperature: 110 degC" in text for text in left.texts())


def test_areas_below_those_that_were_measured_are_outside() -> None:
    design = usual_design()
    for least, make in (
        (0.25, lambda area: selection(Silicon(AMI_1500_IDEAL), area=area)),
        (0.125, lambda area: LatencyChip(design, usual_biases(design), Silicon(AMI_1500_IDEAL), area=area)),
        (0.03, lambda area: NefChip(area=area).at(27.0)),
    ):
        assert make(least) is not None
        with pytest.raises(ParameterError, match=f"area: .* must be at least {least:g} times the circuits'"):
            make(0.9 * least)


def test_closed_forms_were_held_at_one_supply() -> None:
    low = replace(AMI_1500_IDEAL, v_dd=4.0)
    with pytest.raises(ParameterError, match=r"selection\.supply: 4 V, must be 5 V, where the behavioural"):
        selection(Silicon(low))
    with pytest.raises(ParameterError, match=r"rolls_chip\.supply: 1\.5 V, must be 1\.8 V, where"):
        check_supply(replace(ROLLS_180_IDEAL, v_dd=1.5))


def test_a_value_just_outside_is_told_with_the_digits_that_show_it() -> None:
    with pytest.raises(ParameterError, match=r"chip\.temperature: 65\.04 degC, must be -10 to 65 degC"):
        require_inside("chip.temperature", 65.04, BOX, "degC")
    with pytest.raises(ParameterError, match=r"chip\.temperature: 65\.1 degC, must"):
        require_inside("chip.temperature", 65.123, BOX, "degC")
