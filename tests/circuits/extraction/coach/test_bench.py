"""The bench of the teaching chip, and numbers of its process."""

from __future__ import annotations

import numpy as np

from circuits.extraction.coach.bench import bounded, process_of, process_unknowns
from circuits.extraction.coach.unknown import before
from circuits.silicon.process import ROLLS_180


def test_a_number_below_zero_is_the_one_that_the_process_has() -> None:
    prior = before(process_unknowns(ROLLS_180))
    drawn = {name: mean - 4.0 * sd for name, mean, sd in zip(prior.names, prior.mean, prior.sd, strict=True)}
    model = process_of(drawn, ROLLS_180).n
    for number in ("mobility_reduction", "early_rise", "surface_potential"):
        assert getattr(model, number) == bounded(f"n.{number}", np.array(drawn[f"n.{number}"]))
    assert model.mobility_reduction == 0.0
    for name in ("n.mu_cox", "n.v_t0 1/L", "differential_pair.m1.v_t0"):  # which may be below zero
        assert bounded(name, np.array(-1.0)) == -1.0
