"""Testbenches in ngspice on a foundry's cards, by the process that names them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.latency import tonic
from circuits.blocks.mos import inverter
from circuits.circuit import Circuit, Port
from circuits.devices.source import Constant, PiecewiseLinear, Source
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.process_file import foundry_process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate as native
from circuits.testbench import Testbench
from netlists.foundry import engine
from netlists.foundry.process import read_foundry
from netlists.ngspice import engine as plain
from netlists.ngspice import run as ngspice
from netlists.registry import Settings
from tests.netlists.foundry.test_process import needs

pytestmark = pytest.mark.usefixtures("ngspice_library")


def bench(length: float = 0.5, v_dd: float = 3.3) -> Testbench:
    """An inverter whose input rises to the supply in 1 us."""
    ports = (Port("in", "analog"), Port("out", "analog"), Port("vdd", "supply"))
    devices = tuple(inverter("i", "in", "out", width=1.0, length=length))
    circuit = Circuit("gate", ports, devices=devices)
    ramp = PiecewiseLinear((0.0, 1e-6, 2e-6), (0.0, v_dd, v_dd))
    sources = (Source("vin", "in", ramp), *_supply(v_dd))
    return Testbench("gate", circuit, sources, 2e-6, watch=("out",))


def _supply(v_dd: float) -> tuple[Source, ...]:
    return (Source("vdd", "vdd", Constant(v_dd)),)


def silicon(name: str = "gf180mcu", die: Die | None = None, celsius: float = 27.0) -> Silicon:
    needs(read_foundry(name))
    return Silicon(foundry_process(name), celsius, die or Die())


@pytest.mark.parametrize(("name", "v_dd"), [("gf180mcu", 3.3), ("sky130", 1.8)])
def test_cards_and_our_law_switch_the_inverter_at_nearly_the_same_input(name: str, v_dd: float) -> None:
    at = []
    for run in (engine.simulate, native):
        found = run(bench(v_dd=v_dd), silicon(name))
        out = found["out"]
        k = int(np.argmax(out < 0.5 * v_dd))
        at.append(found.time[k] * v_dd / 1e-6)
    assert at[0] == pytest.approx(at[1], abs=0.06)


def test_a_process_of_our_own_is_written_as_it_always_was() -> None:
    own = Silicon(replace(ROLLS_180, v_dd=3.3))
    np.testing.assert_array_equal(
        engine.simulate(bench(1.0), own).voltage, plain.simulate(bench(1.0), own).voltage
    )


def test_a_die_is_the_same_in_a_run_and_in_its_deck() -> None:
    on = silicon(die=Die(number=1003))
    found = engine.simulate(bench(), on)
    deck = engine.deck_of(engine.on_cards(bench(), on), on, Settings(reltol=engine.RELTOL))
    again = ngspice.run(deck, vectors=("out",))
    np.testing.assert_array_equal(found["out"], again.values["out"])
    other = engine.simulate(bench(), silicon(die=Die(number=1004)))
    assert other["out"].shape != found["out"].shape or np.any(other["out"] != found["out"])


def test_an_operating_point_is_that_of_the_cards() -> None:
    point = engine.operating_point(bench(), silicon())
    assert point["out"] == pytest.approx(3.3, abs=1e-3)
    assert set(point) == {"0", "in", "out", "vdd"}


def test_what_cards_cannot_have_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"nfet_03v3: 1 um by 0\.2 um, a size that no card.*0\.28 to 50"):
        engine.deck_of(bench(0.2), silicon(), Settings())
    circuit = rebias(tonic.BLOCK.build(), kind="generator")
    with pytest.raises(ParameterError, match="a bias of kind generator, on the cards of gf180mcu"):
        engine.biased_on_cards(circuit, silicon())


def test_biases_become_the_voltages_of_the_foundry_s_nominal_devices() -> None:
    circuit = tonic.BLOCK.build()
    found = engine.biased_on_cards(circuit, silicon(die=Die(number=3)))
    assert {bias.kind for bias in found.biases} == {"voltage"}
    assert found.biases == engine.biased_on_cards(circuit, silicon()).biases
    assert engine.biased_on_cards(found, silicon()) is found
    assert found.devices == circuit.devices
