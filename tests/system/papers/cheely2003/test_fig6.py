"""Figure 6: shares of pairs follow from the intervals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.blocks.bias import chain as bias_chain
from circuits.blocks.sonar.tuning import NeuronClass, Tuning, tune
from circuits.lowering.kernel import Machine
from system.papers.cheely2003 import fig6 as cheely2003_fig6
from system.papers.cheely2003.fig6 import JITTER, LONGEST, PAIRS, Curves, jittered


def test_jitter_is_keyed_by_neuron_and_has_the_stated_size() -> None:
    delay = np.linspace(0.0, 30e-3, 121)
    pairs = jittered(delay, 3)
    assert pairs.shape == (121, PAIRS)
    assert np.array_equal(pairs, jittered(delay, 3))
    assert not np.array_equal(pairs, jittered(delay, 4))
    off = pairs - delay[:, None]
    # 12,100 draws: a relative error of 0.6 %
    assert off.std() == pytest.approx(JITTER, rel=0.03)
    assert abs(off.mean()) < 0.05 * JITTER


def test_a_wrong_interval_is_found_by_direct_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    first = cheely2003_fig6.neurons(bias_chain.LINEAR)[:1]

    def late(machine: Machine) -> Tuning:
        tuning = tune(machine)
        return replace(tuning, first=tuning.first + 0.1e-3)

    def wrong() -> int:
        delay = np.linspace(0.0, LONGEST, 121)
        return cheely2003_fig6._curves(bias_chain.LINEAR, delay, 5e-3, lambda _: None).wrong

    monkeypatch.setattr(cheely2003_fig6, "neurons", lambda _: first)
    assert wrong() == 0
    monkeypatch.setattr(cheely2003_fig6, "tune", late)
    assert wrong() > 0


def test_distance_from_a_line() -> None:
    tunings = tuple(Tuning(NeuronClass.WORKS, d - 1e-3, d + 1e-3) for d in (2e-3, 5e-3, 12e-3))
    curves = Curves(np.zeros(1), np.zeros((3, 1)), tunings, 0, 0)
    assert curves.off_line == pytest.approx(0.2)
    assert curves.width == pytest.approx(np.full(3, 2e-3))
