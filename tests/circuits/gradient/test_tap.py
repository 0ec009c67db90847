"""What an integral of a square moves by with its points, against differences of what measures read."""

from types import SimpleNamespace

import numpy as np
import pytest

from circuits.gradient.tap import _squares, at_ends, parts_between
from circuits.measure.signal import Signal, integral

ROWS, NUDGE = 12, 1e-6


@pytest.mark.parametrize("span", [(0.0, np.inf), (1.13, 4.03)], ids=("whole", "window"))
def test_square_of_parabolas_moves_with_values_and_times_of_points(span):
    rng = np.random.default_rng(1)
    time, y = np.cumsum(rng.uniform(0.1, 1.0, ROWS)), rng.normal(size=ROWS)
    time -= time[0]
    order = np.full(ROWS, 2)
    order[:2], order[6] = (0, 1), 1  # the solver begins anew at row 5
    span = (span[0], min(span[1], time[-1]))

    def at(times, values):
        signal = Signal(times, values, np.append(order[1:] == 1, True))
        return integral(signal, span[0], min(span[1], times[-1]), power=2)

    def difference(of):
        nudges = NUDGE * np.eye(ROWS)[1:-1]
        return np.array([(of(n) - of(-n)) / (2.0 * NUDGE) for n in nudges])

    value, by, along = _squares(SimpleNamespace(time=time, order=order), y, span)
    assert value == pytest.approx(at(time, y), rel=1e-12)
    np.testing.assert_allclose(by[1:-1], difference(lambda n: at(time, y + n)), atol=1e-8)
    np.testing.assert_allclose(along[1:-1], difference(lambda n: at(time + n, y)), atol=1e-8)


@pytest.mark.parametrize("span", [(0.0, np.inf), (1.13, 4.03), (1.3, 1.31)], ids=("whole", "window", "step"))
def test_integral_of_lines_moves_with_times_of_points_and_with_its_ends(span):
    rng = np.random.default_rng(2)
    time, y, charge = np.cumsum(rng.uniform(0.1, 1.0, ROWS)), rng.normal(size=ROWS), rng.normal(size=ROWS)
    time -= time[0]
    span = (span[0], min(span[1], time[-1]))

    def parts(times, ends):
        return parts_between(SimpleNamespace(time=times), *ends)

    def at(times, ends=span):
        part = parts(times, ends)
        return float(part.before @ y[:-1] + part.after @ y[1:] + part.share @ np.diff(charge))

    straight = Signal(time, y, np.ones(ROWS, np.bool_))
    plain = parts(time, span)
    assert plain.before @ y[:-1] + plain.after @ y[1:] == pytest.approx(integral(straight, *span), rel=1e-12)
    along = plain.along(y[:-1], y[1:], np.diff(charge))
    nudges = NUDGE * np.eye(ROWS)[1:-1]
    wanted = [(at(time + n) - at(time - n)) / (2.0 * NUDGE) for n in nudges]
    np.testing.assert_allclose(along[1:-1], wanted, atol=1e-7)
    flows = np.diff(charge) / np.diff(time)
    own = at_ends(SimpleNamespace(time=time), span, y[:-1] + flows, y[1:] + flows)
    assert [name for name, _ in own] == ["begin", "end"]
    if span[0] > 0.0:
        for (_, slope), move in zip(own, ((NUDGE, 0.0), (0.0, NUDGE)), strict=True):
            more, less = ((span[0] + s * move[0], span[1] + s * move[1]) for s in (1.0, -1.0))
            assert slope == pytest.approx((at(time, more) - at(time, less)) / (2.0 * NUDGE), rel=1e-6)
