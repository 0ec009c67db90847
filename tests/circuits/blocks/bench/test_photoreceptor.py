"""The photoreceptor gives U_T over kappa an e-fold, over decades of light, and is fast by its gain."""

import pytest

from circuits.blocks.bench.photoreceptor import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

IDEAL = Silicon(ROLLS_180_IDEAL)
SIZES = Params()


def numbers(params: Params = SIZES, **knobs: float) -> dict[str, float | None]:
    return BLOCK.measures(simulate(BLOCK.bench(BLOCK.build(params), **knobs), IDEAL))


@pytest.mark.parametrize("photocurrent", [1e-12, 100e-12])
@pytest.mark.parametrize("step", [-1.0, 2.0])
def test_an_e_fold_of_light_is_u_t_over_kappa(photocurrent: float, step: float) -> None:
    found = numbers(photocurrent=photocurrent, step=step, duration=0.2)
    # at 739 pA moderate inversion adds a percent
    assert found["gain_V"] == pytest.approx(IDEAL.thermal_voltage / ROLLS_180_IDEAL.n.kappa, rel=0.02)
    assert found["follower_gain"] == pytest.approx(ROLLS_180_IDEAL.p.kappa, rel=0.01)


def test_more_light_is_faster() -> None:
    slow, fast = (numbers(photocurrent=i, step=0.1, duration=0.2)["rise_s"] for i in (1e-13, 1e-12))
    assert 5.0 < slow / fast < 12.0  # as the photocurrent, while the photodiode's node is the slowest


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"photocurrent: 0 A, must be > 0"):
        BLOCK.bench(photocurrent=0.0)
    with pytest.raises(ParameterError, match=r"step: 30 e-folds, must be within 20 either way"):
        BLOCK.bench(step=30.0)
    assert BLOCK.outcome(simulate(BLOCK.bench(step=0.0), IDEAL)) == "still"
    assert BLOCK.outcome(simulate(BLOCK.bench(step=-1.0), IDEAL)) == "darker"
