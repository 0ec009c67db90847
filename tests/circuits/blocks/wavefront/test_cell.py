"""The wavefront cell fires once, remembers the first arrival and blocks the later ones."""

import pytest

from circuits.blocks.wavefront.cell import ARRIVAL, BLOCK, INPUTS, NAMES, Params, build
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Pulse
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from tests.circuits.blocks.values import number

DEFAULTS = BLOCK.defaults


def run(silicon: Silicon | None = None, **stimuli: float | None) -> Result:
    return simulate(BLOCK.testbench(build(), DEFAULTS | stimuli, 5.0), silicon)


@pytest.mark.parametrize("k", range(INPUTS))
def test_every_input_fires_the_cell_and_is_remembered(k: int) -> None:
    result = run(first=k, second=(k + 3) % INPUTS)
    assert BLOCK.outcome(result) == NAMES[k]
    found = BLOCK.measures(result)
    assert found["bits"] == 1 << k
    # four gates after an edge of 5 ns
    assert 0.0 < number(found["delay_s"]) < 10e-9
    assert result.spikes["fired"].size == 1


@pytest.mark.parametrize("temperature", [-20.0, 85.0])
def test_it_works_cold_and_hot_on_a_die(temperature: float) -> None:
    result = run(Silicon(AMI_1500_IDEAL, temperature_c=temperature, die=Die(number=1003)))
    assert BLOCK.outcome(result) == "E"
    assert result.spikes["fired"].size == 1


def test_the_start_fires_it_and_points_nowhere() -> None:
    result = run(first=None, second=1, start=1.0)
    assert BLOCK.outcome(result) == "start"
    assert BLOCK.measures(result)["bits"] == 0.0
    assert result.spikes["fired"][0] == pytest.approx(ARRIVAL, abs=20e-9)


def test_it_is_silent_without_an_arrival() -> None:
    result = run(first=None, second=None)
    assert BLOCK.outcome(result) == "none"
    assert BLOCK.measures(result)["delay_s"] is None
    assert result["quiet"][-1] == pytest.approx(5.0, abs=1e-3)


def test_arrivals_within_the_window_both_set_their_bits_and_later_ones_do_not() -> None:
    assert BLOCK.outcome(run(lag=0.0)) == "E+SW"
    assert BLOCK.outcome(run(lag=0.8e-9)) == "E+SW"
    assert BLOCK.outcome(run(lag=2e-9)) == "E"
    assert BLOCK.outcome(run(lag=-2e-9)) == "SW"


def test_the_bus_is_asked_until_it_answers() -> None:
    result = run()
    assert result.spikes["request"].size == 1
    assert result.spikes["request"][0] - result.spikes["fired"][0] < 5e-9
    assert result["request"][-1] == pytest.approx(0.0, abs=1e-3)
    assert result["fired"][-1] == pytest.approx(5.0, abs=1e-3)


def test_a_blocked_cell_neither_fires_nor_asks() -> None:
    bench = BLOCK.testbench(build(), DEFAULTS, 5.0)
    blocked = (*bench.sources, Source("v_blocked", "v_blocked", Constant(5.0)))
    result = simulate(Testbench("blocked", bench.circuit, blocked, bench.stop, bench.watch))
    assert result.spikes["fired"].size == 0
    assert result.spikes["request"].size == 0


def test_it_fires_again_after_a_reset_that_comes_while_the_arrival_is_still_there() -> None:
    circuit: Circuit = build()
    off = Constant(0.0)
    reset = Pulse(0.0, 5.0, (40e-6,), 10e-6, 0.1e-6, 0.1e-6)
    first = Pulse(0.0, 5.0, (20e-6,), 22e-6, 5e-9, 5e-9)  # ends 2 us into the reset, as an axon does
    again = Pulse(0.0, 5.0, (60e-6,), 20e-6, 5e-9, 5e-9)
    waves = {"reset": reset, "arrive[0]": first, "arrive[3]": again, "start": off, "acknowledge": off}
    waves |= {f"arrive[{k}]": off for k in range(INPUTS) if k not in (0, 3)}
    sources = (Source("vdd", "vdd", Constant(5.0)), *(Source(n, n, w) for n, w in waves.items()))
    rest = {"quiet": 5.0, "waiting": 5.0, **{f"input[{k}].held": 5.0 for k in range(INPUTS)}}
    watch = ("fired", "first[0]", "first[3]")
    result = simulate(Testbench("twice", circuit, sources, 80e-6, watch, rest))
    assert result.spikes["fired"] == pytest.approx([20e-6, 60e-6], abs=20e-9)
    assert [result.spikes[f"first[{k}]"].size for k in (0, 3)] == [1, 1]
    assert result["first[0]"][-1] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("name", ["first", "second"])
def test_an_input_that_is_none_is_refused(name: str) -> None:
    with pytest.raises(ParameterError, match=f"{name}: 8, must be an input from 0 to 7"):
        run(**{name: 8.0})


def test_a_reset_that_would_lose_is_refused() -> None:
    with pytest.raises(ParameterError, match="precharge_width"):
        Params(precharge_width=3e-6)
    with pytest.raises(ParameterError, match="keeper_length"):
        Params(keeper_length=1.5e-6)
