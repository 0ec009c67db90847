"""The bench sees what the model does: windows, and who answers alone."""

from __future__ import annotations

import numpy as np

from chips.ranging.calibration.bench import PERIOD, Bench
from chips.ranging.chip import shipped_model
from chips.ranging.model import neurons_on, with_biases
from chips.ranging.response import tune
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

SILICON = Silicon(AMI_1500)
WIDE = {"i_rslope": 195e-12, "i_rtau": 175e-12, "v_rest": 1.5, "v_th": 2.602, "v_ex_max": 4.21}


def _bench() -> Bench:
    return Bench(shipped_model(AMI_1500, "generator"), SILICON)


def test_neurons_answer_within_their_facilitating_intervals() -> None:
    bench = _bench()
    told = tune(neurons_on(with_biases(bench.model, WIDE), SILICON))
    middle = 0.5 * (told.first + told.last)
    answers = bench.answers(WIDE, middle) > 0
    assert answers.diagonal().all()
    assert not (bench.answers(WIDE, told.last + 1e-3) > 0).diagonal().any()
    assert bench.seconds == 2 * 14 * PERIOD


def test_a_slope_that_is_too_steep_makes_neurons_answer_a_call_alone() -> None:
    bench = _bench()
    assert not bench.call_alone(WIDE).any()
    assert bench.call_alone({**WIDE, "i_rslope": 600e-12}).all()
    assert not bench.echo_alone(WIDE).any()
    assert bench.echo_alone({**WIDE, "v_ex_max": 3.9}).all()


def test_noise_goes_on_from_one_measurement_to_the_next() -> None:
    bench, edges = _bench(), np.full(200, 6.0e-3)
    first, second = (bench.answers({}, edges) for _ in range(2))
    again = _bench().answers({}, edges)
    assert np.array_equal(first, again)
    assert first.any(axis=1).all() or not np.array_equal(first, second)
