"""The law of one device in kernels and over arrays, against the solver's law of many devices."""

import numpy as np
import pytest

from circuits.devices.channel import (
    channel,
    early,
    height_of,
    leaked,
    mobility,
    pinch_off_of,
    pinched,
    terms_of,
)
from circuits.devices.transistor import drain_current, drain_currents, transistor_arrays, transistor_work
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, ROLLS_180, Polarity, Process
from circuits.silicon.silicon import Silicon

WIDTH, LENGTH = 2e-6, 0.7e-6
PROCESSES = (AMI_1500_IDEAL, AMI_1500, ROLLS_180)


def _voltages(process: Process) -> np.ndarray:
    """Drain, gate, source of 300 operating points, drains below sources among them."""
    return np.random.default_rng(4).uniform(-0.1, process.v_dd, (300, 3))


@pytest.mark.parametrize("polarity", ["n", "p"])
@pytest.mark.parametrize("process", PROCESSES, ids=lambda p: f"{p.name}-{p.effects}")
def test_one_device_carries_what_the_solver_says_with_its_derivatives(
    process: Process, polarity: Polarity
) -> None:
    law = Silicon(process, 45.0).law(polarity)
    terms = terms_of(law, WIDTH, LENGTH, law.square_current * WIDTH / LENGTH, law.v_t0)
    points = _voltages(process)
    sign = 1.0 if polarity == "n" else -1.0
    arrays = transistor_arrays(
        np.arange(4, dtype=np.int32).reshape(4, 1),
        polarity,
        law,
        *(np.array([x]) for x in (WIDTH, LENGTH, 1.0)),
    )
    work = transistor_work(1)
    scale = 1e-20 + np.abs(drain_current(law, "n", WIDTH, LENGTH, *points.T))
    for k, (drain, gate, source) in enumerate(points):
        drain_currents(arrays, sign * np.array([drain, gate, source, 0.0]), work)
        current, by_drain, by_gate, by_source = channel(terms, drain, gate, source)
        assert current == pytest.approx(sign * work.current[0], abs=1e-11 * scale[k])
        steepest = np.abs(work.conductance).max()
        assert [by_drain, by_gate, by_source] == pytest.approx(
            work.conductance[:, 0].tolist(), abs=1e-10 * steepest
        )
        into, by_junction, by_its_gate = leaked(terms, drain, gate)
        assert into == pytest.approx(sign * work.junction[0, 0], rel=1e-11, abs=1e-30)
        assert by_junction == pytest.approx(work.junction_conductance[0, 0], rel=1e-10, abs=1e-30)
        assert by_its_gate == pytest.approx(work.junction_conductance[2, 0], rel=1e-10, abs=1e-30)


@pytest.mark.parametrize("process", PROCESSES, ids=lambda p: f"{p.name}-{p.effects}")
def test_functions_of_arrays_are_those_of_kernels_and_their_inverses(process: Process) -> None:
    law = Silicon(process).law("p")
    terms = terms_of(law, WIDTH, LENGTH, 1e-7, law.v_t0)
    gates = np.linspace(-0.2, process.v_dd, 40)
    v_p = pinch_off_of(law, gates - law.v_t0)
    assert v_p == pytest.approx([pinched(terms, g)[0] for g in gates], rel=1e-13)
    assert height_of(law, v_p) == pytest.approx(gates - law.v_t0, abs=1e-12)


def test_early_effect_and_mobility_are_the_factors_of_the_channel() -> None:
    law = Silicon(ROLLS_180).law("n")
    gate, drain = 0.5, 1.5
    whole = terms_of(law, WIDTH, LENGTH, 1e-7, law.v_t0)
    bare = whole._replace(early=0.0, reduction=0.0)
    v_p = float(pinch_off_of(law, gate - law.v_t0))
    roots = np.logaddexp(0.0, (v_p - np.array([0.0, drain])) / (2.0 * law.u_t)).sum()
    factor = float(early(law, LENGTH, drain, roots) * mobility(law, v_p))
    assert channel(whole, drain, gate, 0.0)[0] == pytest.approx(
        factor * channel(bare, drain, gate, 0.0)[0], rel=1e-12
    )
    assert factor != pytest.approx(1.0, rel=0.05)
