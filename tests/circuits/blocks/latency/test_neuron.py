"""Equation (9) by the circuit, at other temperatures and kinds of biases, and on dies."""

import pytest

from circuits.bias import rebias
from circuits.blocks.latency.neuron import BLOCK, Params, build
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from tests.circuits.blocks.values import number
from tests.refusals import refusals

DEFAULTS = BLOCK.defaults
E_0, CHARGE = 2.5e-9, 10e-12 * 2.0  # A; C_mem V_ref, C
SILICON = Silicon(AMI_1500_IDEAL)


def measured(circuit: Circuit, silicon: Silicon, **stimuli: float | None) -> dict[str, float | None]:
    return BLOCK.measures(simulate(BLOCK.testbench(circuit, DEFAULTS | stimuli, 5.0), silicon))


@pytest.mark.parametrize(
    "times", [(3e-3, None, None), (3e-3, 6e-3, None), (2e-3, 2e-3, 5e-3), (0.0, 7e-3, 7.5e-3)]
)
def test_the_latency_is_that_of_equation_9(times: tuple[float | None, ...]) -> None:
    found = measured(build(), SILICON, **dict(zip(("first", "second", "third"), times, strict=True)))
    known = [t for t in times if t is not None]
    expected = (CHARGE + E_0 * sum(known)) / (len(known) * E_0)
    # the requirement; parasitics of the membrane are 0.7 % of it, the ping's width 0.1 %
    assert found["latency_s"] == pytest.approx(expected, rel=0.02)


def test_a_step_lasts_20_ms() -> None:
    # 1.1 % of parasitics on the timer
    assert measured(build(), SILICON)["step_s"] == pytest.approx(20e-3, rel=0.02)


def test_nothing_heard_is_nothing_said() -> None:
    found = measured(build(), SILICON, first=None, second=None)
    assert found["latency_s"] is None
    assert found["step_s"] is None


def test_fixed_gates_slow_down_in_the_cold_and_generators_do_not() -> None:
    cold, warm = (Silicon(AMI_1500_IDEAL, t) for t in (0.0, 60.0))
    gate = build()
    generator = rebias(gate, {}, "ideal")
    late = [measured(gate, s)["latency_s"] for s in (cold, SILICON, warm)]
    assert number(late[0]) > 1.5 * number(late[1]) > 1.5 * number(late[2])
    steady = [measured(generator, s)["latency_s"] for s in (cold, warm)]
    # T is 4.5 ms of mean arrival and 4 ms of charging, which goes as 1 / T, from 273 to 333 K: +-10 %
    assert steady[0] == pytest.approx(4.5e-3 + 4e-3 * 300.15 / 273.15, rel=0.02)
    assert steady[1] == pytest.approx(4.5e-3 + 4e-3 * 300.15 / 333.15, rel=0.02)


def test_dies_differ_and_a_die_is_the_same_again() -> None:
    def latency(number: int) -> float | None:
        return measured(build(), Silicon(AMI_1500_IDEAL, die=Die(number=number)))["latency_s"]

    assert latency(7) == latency(7)
    assert latency(7) != latency(8)


test_sizes_that_cannot_be_are_refused = refusals(
    ParameterError,
    lambda sizes: Params(**sizes),
    [
        ({"membrane_capacitance": 0.0}, "membrane_capacitance: 0 F, must be > 0"),
        ({"synapses": 0}, "synapses: 0, must be a whole number from 1 to 64"),
    ],
)
