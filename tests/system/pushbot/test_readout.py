"""Equations (1) and (2) over windows: fixed, sliding, and factors that mean the same with all of them."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.pushbot.body import Factors
from system.pushbot.readout import LOOK, Counter, Readout, read

# spikes a neuron in a look: 40 of DL, 10 of DR, 100 Hz of sp
STEADY = np.array([40.0, 10.0, 100.0]) * LOOK


@pytest.mark.parametrize("window", [0.05, 0.1, 0.5])
@pytest.mark.parametrize("kind", ["fixed", "sliding"])
def test_a_steady_rate_gives_the_same_command_with_every_window(window: float, kind: str) -> None:
    readout = Readout(Factors(0.5, 2.0), window, kind)  # type: ignore[arg-type]
    counter = Counter()
    last = [read(readout, counter, STEADY) for _ in range(20)][-1]
    assert last is not None
    # in 500 ms: 50 spikes of sp, 20 - 5 of the drives
    assert last == pytest.approx((0.5 * 50.0, 2.0 * 15.0), rel=1e-12)


def test_a_fixed_window_commands_at_its_end_and_begins_anew() -> None:
    readout, counter = Readout(window=0.5, kind="fixed"), Counter()
    commands = [read(readout, counter, STEADY if k < 10 else np.zeros(3)) for k in range(20)]
    assert [k for k, c in enumerate(commands) if c is not None] == [9, 19]
    assert commands[19] == (0.0, 0.0)


def test_a_sliding_window_forgets_at_the_rate_of_its_length() -> None:
    readout, counter = Readout(window=0.5), Counter()
    for _ in range(10):
        read(readout, counter, STEADY)
    left = [read(readout, counter, np.zeros(3)) for _ in range(10)]
    speeds = [v for v, _ in left if v is not None] if None not in left else []
    assert speeds == pytest.approx([0.5 * 50.0 * (9 - k) / 10 for k in range(10)], abs=1e-9)


@pytest.mark.parametrize("window", [0.0, 0.07, -0.5])
def test_a_window_is_a_whole_number_of_looks(window: float) -> None:
    with pytest.raises(ParameterError, match="window"):
        Readout(window=window)


def test_another_kind_is_refused() -> None:
    with pytest.raises(ParameterError, match="readout: running, must be one of fixed, sliding, spikes"):
        Readout(kind="running")  # type: ignore[arg-type]
