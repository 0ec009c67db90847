"""Numbers of a transistor that follow its size: in the law, in a netlist, in its notes and in a file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.devices import Transistor
from circuits.devices.transistor import drain_current
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, Process, at_temperature
from circuits.silicon.silicon import NO_DEVIATION, Silicon
from circuits.silicon.size import SizeTerms, from_numbers, to_numbers
from netlists.dialects.ngspice import format_device
from netlists.write.annotation import silicon_notes, to_silicon

TERMS = SizeTerms(
    0.5e-6, 20e-6, 0.5e-6, 10e-6, v_t0=(5e-8, -1e-14, 1e-9, 1e-15), kappa=(-1e-8, 0.0, 1e-9, 0.0),
    mu_cox=(-1e-7, 0.0, 0.0, 0.0), early_field=(1.0, 0.0, 0.0, 0.0), mobility_reduction=(1e-7, 0.0, 0.0, 0.0),
    v_t0_drift=(1e-11, 0.0, 0.0, 0.0), mobility_exponent=(1e-8, 0.0, 0.0, 0.0),
)  # fmt: skip
SIZED: Process = replace(ROLLS_180, name="sized", n=replace(ROLLS_180.n, size=TERMS))
VOLTS = (1.0, np.linspace(0.2, 1.8, 9), 0.1)


@pytest.mark.parametrize("temperature_c", [-20.0, 27.0, 85.0])
def test_a_device_has_the_law_of_a_model_that_was_made_for_its_size(temperature_c: float) -> None:
    width, length = 2e-6, 1e-6
    m, powers = SIZED.n, np.array([1e6, 1e12, 0.5e6, 0.5e12])
    more = {name: float(powers @ getattr(TERMS, name)) for name in ("v_t0", "kappa", "mu_cox", "early_field",
            "mobility_reduction", "v_t0_drift", "mobility_exponent")}  # fmt: skip
    alike = replace(
        m, size=None, mu_cox=m.mu_cox * np.exp(more.pop("mu_cox")),
        **{name: getattr(m, name) + by for name, by in more.items()},
    )  # fmt: skip
    laws = [at_temperature(model, replace(SIZED, n=model), temperature_c) for model in (m, alike)]
    one, other = (drain_current(law, "n", width, length, *VOLTS) for law in laws)
    np.testing.assert_allclose(one, other, rtol=1e-12)
    plain = drain_current(replace(laws[0], size=None), "n", width, length, *VOLTS)
    assert np.all(np.abs(one / plain - 1.0) > 0.01)


def test_a_size_outside_of_the_terms_is_refused_with_their_limits() -> None:
    law = Silicon(SIZED).law("n")
    with pytest.raises(ParameterError, match=r"length: 0\.3 um, must be within 0\.5 to 10 um"):
        law.of_size(1e-6, 0.3e-6)
    with pytest.raises(ParameterError, match=r"^a\.m\.length: 0\.3 um"):
        TERMS.check(1e-6, 0.3e-6, "a.m")
    assert law.of_any_size(1e-6, 0.3e-6).v_t0 > law.v_t0
    with pytest.raises(ParameterError, match="width: 30 um"):
        law.of_size(np.array([1e-6, 30e-6]), np.array([1e-6, 1e-6]))


def test_a_netlist_has_the_law_of_each_size_and_its_notes_give_the_process_back() -> None:
    silicon = Silicon(SIZED)
    texts = [
        format_device(Transistor("m", "n", "d", "g", "s", "0", 2e-6, length), silicon, NO_DEVIATION)
        for length in (1e-6, 2e-6)
    ]
    assert texts[0] != texts[1]
    first = next(line for line in texts[0] if line.startswith("bm "))
    specific = float(first.split("i=")[1].split("*")[0])
    assert specific == pytest.approx(silicon.law("n").of_size(2e-6, 1e-6).square_current * 2.0, rel=1e-12)
    assert to_silicon(silicon_notes(silicon)).process == replace(SIZED, components=ROLLS_180.components)


def test_terms_as_numbers_and_back() -> None:
    assert from_numbers(to_numbers(TERMS)) == TERMS
    assert from_numbers(to_numbers(None)) is None
    with pytest.raises(ValueError, match="3 numbers"):
        from_numbers((1.0, 2.0, 3.0))
    with pytest.raises(ParameterError, match=r"size\.v_t0: 2 coefficients"):
        replace(TERMS, v_t0=(1.0, 2.0))


def test_a_process_without_terms_says_nothing_of_them() -> None:
    assert "size" not in repr(ROLLS_180)
    assert "cards" not in repr(ROLLS_180)
    assert "size=SizeTerms(" in repr(SIZED)
