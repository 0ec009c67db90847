"""The planted dominant device comes first, and every table sums to 100 %."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.sampling import labels
from system.study.statistics.contribution import (
    UNEXPLAINED,
    VarianceShare,
    block,
    contributions,
    device,
    grouped,
    kind,
    parameter,
    pareto,
    percentages,
    standardise,
)

NAMES = (
    *(f"chip.neuron[{k // 5}].part.m{k % 5}.{q}" for k in range(15) for q in ("v_t0", "beta")),
    *(f"process.{polarity}.shared.{q}" for polarity in "np" for q in ("v_t0", "beta")),
)
DOMINANT = "chip.neuron[1].part.m2"


def planted(samples: int) -> tuple[F64, F64, F64]:
    """Normals, a linear metric, and its gradient: one device has most, a process the next."""
    rng = np.random.default_rng(5)
    gradient = 0.05 * rng.standard_normal(len(NAMES))
    gradient[NAMES.index(f"{DOMINANT}.v_t0")] = 2.0
    gradient[NAMES.index(f"{DOMINANT}.beta")] = -1.0
    gradient[NAMES.index("process.n.shared.v_t0")] = 1.0
    z = rng.standard_normal((samples, len(NAMES)))
    return z, 3.0 + z @ gradient + 0.1 * rng.standard_normal(samples), gradient


def total(shares: tuple[VarianceShare, ...]) -> float:
    return sum(share.value for share in shares)


@pytest.mark.parametrize("known", [True, False])
def test_a_planted_dominant_device_comes_first(known: bool) -> None:
    z, y, gradient = planted(400)
    found = contributions(NAMES, z, y, gradient if known else None)
    first, second, *_ = grouped(found, device)
    assert found.model == ("gradients" if known else "linear")
    assert first.name == DOMINANT
    assert first.value == pytest.approx(5.0 / 6.06, abs=0.03)
    assert second.name == "process.n"
    assert grouped(found, block)[0].name == "chip.neuron[1].part"
    assert grouped(found, parameter)[0].name == "v_t0"
    assert [s.name for s in grouped(found, kind)] == ["mismatch", "process", UNEXPLAINED]


@pytest.mark.parametrize("key", [device, parameter, block, kind])
def test_shares_sum_to_one(key: object) -> None:
    z, y, gradient = planted(300)
    bent = y + 2.0 * z[:, 3] ** 2 + z[:, 1] * z[:, 2]
    for metric in (y, bent, np.random.default_rng(0).standard_normal(300)):
        for known in (gradient, None):
            shares = grouped(contributions(NAMES, z, metric, known), key)  # type: ignore[arg-type]
            assert total(shares) == pytest.approx(1.0, abs=1e-14)
            assert all(share.value >= -1e-14 for share in shares)
            assert sum(round(10.0 * p) for p in percentages(shares)) == 1000


def test_gradients_are_checked_by_regression() -> None:
    z, y, gradient = planted(400)
    found = contributions(NAMES, z, y, gradient)
    assert found.check is not None
    assert found.check < 0.02
    assert found.note == ""
    wrong = gradient.copy()
    wrong[0] = 0.6  # explains above 0.9 still, so it is believed, but the check shows it
    doubtful = contributions(NAMES, z, y, wrong)
    assert doubtful.check is not None
    assert doubtful.model == "gradients"
    assert doubtful.check > 0.04


def test_wrong_gradients_give_way_to_the_samples() -> None:
    z, y, gradient = planted(400)
    found = contributions(NAMES, z, y, gradient[::-1].copy())
    assert found.model == "linear"
    assert grouped(found, device)[0].name == DOMINANT


def test_a_planted_square_is_told_from_a_line() -> None:
    z, y, gradient = planted(1000)
    where = NAMES.index("chip.neuron[0].part.m1.beta")
    bent = y + 2.0 * (z[:, where] ** 2 - 1.0)
    found = contributions(NAMES, z, bent, gradient)
    assert found.model == "quadratic"
    assert found.r2 > 0.98
    assert found.squares == pytest.approx(8.0 / 14.06, abs=0.05)
    assert found.linear == pytest.approx(6.06 / 14.06, abs=0.05)
    assert found.linear + found.squares + found.interactions == pytest.approx(found.r2)
    assert grouped(found, device)[0].name == "chip.neuron[0].part.m1"


def test_few_samples_say_so() -> None:
    z, y, gradient = planted(30)
    found = contributions(NAMES, z, y, gradient)
    assert found.check is None
    assert "too few to check" in found.note
    with pytest.raises(ParameterError, match="must be >= 70 for 34 parameters"):
        contributions(NAMES, z, y)


def test_undefined_samples_are_left_out() -> None:
    z, y, gradient = planted(400)
    y[::4] = np.nan
    assert contributions(NAMES, z, y, gradient).samples == 300


@pytest.mark.parametrize("samples", [0, 1])
def test_no_variance_is_unexplained(samples: int) -> None:
    found = contributions(NAMES, np.zeros((samples, len(NAMES))), np.zeros(samples), np.ones(len(NAMES)))
    assert found.unexplained == 1.0


def test_shapes_must_fit() -> None:
    with pytest.raises(ParameterError, match=r"contributions: \(3, 4\) normals, must be samples 3 by 34"):
        contributions(NAMES, np.zeros((3, 4)), np.zeros(3))


def test_temperature_is_a_factor() -> None:
    z, y, gradient = planted(300)
    temperature = standardise(np.tile([0.0, 27.0, 60.0], 100))
    names = (*NAMES, "temperature")
    found = contributions(
        names, np.column_stack([z, temperature]), y + 10.0 * temperature, np.append(gradient, 10.0)
    )
    assert grouped(found, kind)[0].name == grouped(found, device)[0].name == "temperature"
    assert grouped(found, kind)[0].value == pytest.approx(100.0 / 106.06, abs=0.02)
    assert not standardise(np.full(5, 27.0)).any()


def test_names_are_those_of_the_draws() -> None:
    (one,) = labels((("chip", ()), ("neuron", (2,))), [(("inhibition", ()), ("mi5", ()))], "v_t0")
    assert (device(one), parameter(one)) == ("chip.neuron[2].inhibition.mi5", "v_t0")
    assert (block(one), kind(one)) == ("chip.neuron[2].inhibition", "mismatch")
    (shared,) = labels((("process", ()),), [(("n", ()),)], "shared.v_t0")
    assert (device(shared), parameter(shared)) == ("process.n", "process.n.v_t0")
    assert (block(shared), kind(shared)) == ("process", "process")
    assert parameter("process.p.beta") == "process.p.beta"


@given(st.lists(st.floats(1e-6, 1.0), min_size=1, max_size=30))
def test_rounded_percentages_sum_to_100(weights: list[float]) -> None:
    whole = sum(weights)
    shares = [VarianceShare(str(k), w / whole) for k, w in enumerate(weights)]
    found = percentages(shares)
    assert sum(round(10.0 * p) for p in found) == 1000
    assert all(abs(p - 100.0 * share.value) < 0.1 + 1e-9 for p, share in zip(found, shares, strict=True))


def test_the_picture_lumps_the_small_ones() -> None:
    z, y, gradient = planted(200)
    shares = grouped(contributions(NAMES, z, y, gradient), device)
    figure = Figure()
    FigureCanvasAgg(figure)
    ax = figure.subplots()
    pareto(shares, ax, most=3)
    named = [text.get_text() for text in ax.get_yticklabels()]
    assert named == [*(share.name for share in shares[:3]), f"{len(shares) - 4} others", UNEXPLAINED]
    assert sum(round(10.0 * patch.get_width()) for patch in ax.patches) == 1000  # type: ignore[attr-defined]
    figure.canvas.draw()
