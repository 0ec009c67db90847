"""Spikes for the difference of both ears, and for nothing else."""

from itertools import pairwise

import pytest

from circuits.bias import rebias
from circuits.blocks.lso.lso_neuron import BLOCK, Params, build
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

DEFAULTS = BLOCK.defaults
QUIET: dict[str, float | None] = dict.fromkeys(DEFAULTS)
AT = 0.5e-3


def run(
    circuit: Circuit | None = None, silicon: Silicon | None = None, duration: float = 6e-3,
    **stimuli: float | None,
) -> Result:  # fmt: skip
    bench = BLOCK.testbench(circuit or build(), QUIET | stimuli | {"duration": duration}, 5.0)
    return simulate(bench, silicon or Silicon(AMI_1500_IDEAL))


def count(*args: object, **stimuli: float | None) -> float:
    found = BLOCK.measures(run(*args, **stimuli))["spikes"]  # type: ignore[arg-type]
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("excited", "inhibited", "spikes"),
    # 2.4 spikes an input without dead time and parasitics, which take 0.1 of them
    [(1, 0, 2), (2, 0, 4), (2, 1, 2), (1, 1, 0), (1, 2, 0), (2, 2, 0), (0, 0, 0)],
)
def test_spikes_are_for_the_difference_of_the_ears(excited: int, inhibited: int, spikes: int) -> None:
    given = {f"excite_{k + 1}": AT for k in range(excited)}
    given |= {f"inhibit_{k + 1}": AT for k in range(inhibited)}
    assert count(**given) == spikes


def test_the_first_spike_and_the_step_are_those_of_the_equations() -> None:
    found = BLOCK.measures(run(excite_1=AT))
    # C V_ref / I = 1.667 ms; parasitics of the membrane are 3 %, the comparator takes 10 us
    assert found["latency_s"] == pytest.approx(AT + 10e-12 / 6e-9, rel=0.04)
    # 1.5 % of parasitics, and the event's own 10 us
    assert found["step_s"] == pytest.approx(4e-3, rel=0.02)
    assert BLOCK.outcome(run()) == "silent"


@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
def test_counts_stay_where_temperature_moves_currents(kind: str) -> None:
    circuit = rebias(build(), {}, kind)  # type: ignore[arg-type]
    for celsius, duration in ((0.0, 15e-3), (60.0, 6e-3)):
        silicon = Silicon(AMI_1500_IDEAL, celsius)
        assert count(circuit, silicon, duration, excite_1=AT, excite_2=AT) in {4.0, 5.0}
        assert count(circuit, silicon, duration, excite_1=AT, excite_2=AT, inhibit_1=AT) == 2.0


def test_dies_differ_and_a_die_is_the_same_again() -> None:
    def latency(number: int) -> float | None:
        return BLOCK.measures(run(None, Silicon(AMI_1500_IDEAL, die=Die(number=number)), excite_1=AT))[
            "latency_s"
        ]

    assert latency(7) == latency(7)
    assert latency(7) != latency(8)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"timer_capacitance: 0 F, must be > 0"):
        Params(timer_capacitance=0.0)
    with pytest.raises(ParameterError, match=r"inhibitions: 0, must be a whole number from 1 to 64"):
        Params(inhibitions=0)
    with pytest.raises(ParameterError, match=r"excite_2: 0.0005 s, there is one synapse"):
        run(build(Params(excitations=1)), excite_2=AT)


@pytest.mark.parametrize("celsius", [-10.0, 27.0, 60.0])
@pytest.mark.parametrize(("n", "p"), [(-0.1, 0.07), (0.1, -0.07), (-0.1, -0.07), (0.1, 0.07)])
def test_a_spike_empties_the_membrane_on_any_die(celsius: float, n: float, p: float) -> None:
    """Fixed gates make currents a tenth or ten times as large there."""
    die = Die(number=3).with_("process.n", "v_t0", n).with_("process.p", "v_t0", p)
    found = run(silicon=Silicon(AMI_1500, celsius, die), duration=40e-3, excite_1=AT, excite_2=AT)
    spikes = found.spikes["spike"]
    assert spikes.size > 1
    for begin, end in pairwise(spikes):
        between = (found.time > begin) & (found.time < end)
        assert found["v_mem"][between].min() < 1e-3
