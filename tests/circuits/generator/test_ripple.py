"""Lines of the generator on a supply that moves, as the solver finds them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.blocks.bias import generator
from circuits.blocks.ports import SUPPLY, analog_out
from circuits.blocks.rest import started_at_rest
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import ParameterError
from circuits.generator.circuit import line, line_sizes, masters
from circuits.generator.code import COARSE, codes_of
from circuits.generator.ripple import DECOUPLING, Ripple, line_response
from circuits.generator.voltage import RANGES, Line, line_voltages, resistor_of
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, ROLLS_180, Polarity, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.small_signal import ac
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

FREQUENCIES = 0.0, 50.0, 1e3, 20e3


def device(polarity: Polarity) -> Transistor:
    rail = "0" if polarity == "n" else "vdd"
    return Transistor("m", polarity, "d", "g", rail, rail, 6e-6, 6e-6)


def lines(polarity: Polarity) -> Line:
    return Line((("chip", ()),), "v_tau", (1,), None, device(polarity))


def whole(process: Process, polarity: Polarity, current: float) -> Circuit:
    """Masters and one line as one circuit, with the line's decoupling."""
    (coarse, fine), sizes = codes_of(np.array([current]))[0], line_sizes(process)
    own = line(int(fine), device(polarity), sizes[int(coarse)])
    joined = [replace(d, gate=RANGES[int(coarse)]) if d.gate == "range_n" else d for d in own]
    node, rail = ("v_n", "0") if polarity == "n" else ("v_p", "vdd")
    return Circuit(
        "generator",
        (SUPPLY, *analog_out(node)),
        (*masters(resistor_of(process), sizes), *joined, Capacitor("cd", node, rail, DECOUPLING)),
    )


def bench(circuit: Circuit, supply: Constant | PiecewiseLinear, stop: float) -> Testbench:
    sources = (Source("vdd", "vdd", supply),)
    return started_at_rest(Testbench("generator", circuit, sources, stop), AMI_1500)


@pytest.mark.parametrize("process", [AMI_1500, ROLLS_180])
@pytest.mark.parametrize(("polarity", "current"), [("n", 400e-12), ("p", 400e-12), ("n", 1e-6), ("p", 20e-9)])
def test_a_line_follows_as_the_whole_generator_does(
    process: Process, polarity: Polarity, current: float
) -> None:
    silicon, node = Silicon(process), "v_n" if polarity == "n" else "v_p"
    point = operating_point(
        to_kernel(bench(whole(process, polarity, current), Constant(process.v_dd), 1e-3), silicon)
    )
    found = ac(point, "vdd", np.maximum(FREQUENCIES, 1e-3), (node,)).transfer[:, 0]
    theirs = found if polarity == "n" else 1.0 - found
    ours = np.array([line_response(lines(polarity), np.array([current]), silicon, f)[0] for f in FREQUENCIES])
    # the gate of the line at the masters' diode is left out
    assert np.abs(ours - theirs).max() < 0.03 * np.abs(theirs).max()
    assert np.abs(ours / theirs - 1.0)[:3].max() < 0.05  # at 20 kHz the line hardly moves


def test_a_line_moves_in_a_transient_as_it_says() -> None:
    ripple, current = Ripple(20e-3, 200.0), 400e-12
    silicon, period = Silicon(AMI_1500), 1.0 / ripple.frequency
    times = np.linspace(0.0, 6.0 * period, 385)
    wave = AMI_1500.v_dd + ripple.amplitude * np.sin(2.0 * np.pi * ripple.frequency * times)
    supply = PiecewiseLinear(tuple(times.tolist()), tuple(wave.tolist()))
    run = simulate(bench(whole(AMI_1500, "n", current), supply, float(times[-1])), silicon, record=("v_n",))
    last = run.time > 4.0 * period
    t, v = run.time[last], run["v_n"][last]
    angle = 2.0 * np.pi * ripple.frequency * t
    sine, cosine, _ = np.linalg.lstsq(
        np.stack([np.sin(angle), np.cos(angle), np.ones(t.size)], axis=1), v, rcond=None
    )[0]
    found = complex(sine, cosine) / ripple.amplitude
    asked = complex(line_response(lines("n"), np.array([current]), silicon, ripple.frequency)[0])
    assert abs(asked) > 0.02
    assert found == pytest.approx(asked, rel=0.03)


def test_the_block_of_the_generator_follows_likewise() -> None:
    coarse, fine = codes_of(np.array([1e-6]))[0]
    circuit = generator.build(generator.Params(coarse=int(coarse), fine=int(fine)))
    held = replace(circuit, devices=(*circuit.devices, Capacitor("cd", "v_n", "0", DECOUPLING)))
    point = operating_point(to_kernel(generator.BLOCK.bench(held), Silicon(AMI_1500)))
    found = ac(point, "vdd", np.array([1e3]), ("v_n",)).transfer[0, 0]
    # the block ends its other coarse branches at ground, where the chip's masters have diodes
    assert line_response(lines("n"), np.array([1e-6]), Silicon(AMI_1500), 1e3)[0] == pytest.approx(
        found, rel=0.05
    )


@pytest.mark.parametrize("polarity", ["n", "p"])
def test_slowly_it_is_the_difference_of_two_supplies(polarity: Polarity) -> None:
    silicon, current = Silicon(AMI_1500, die=Die(number=1003)), np.array([100e-12])
    resistance = resistor_of(AMI_1500)
    ends = []
    for move in (1e-2, -1e-2):
        moved = replace(AMI_1500, v_dd=AMI_1500.v_dd + move)
        volts = float(line_voltages(lines(polarity), current, replace(silicon, process=moved), resistance)[0])
        ends.append(volts if polarity == "n" else moved.v_dd - volts)
    slope = (ends[0] - ends[1]) / 2e-2
    assert line_response(lines(polarity), current, silicon, 0.0)[0].real == pytest.approx(slope, rel=1e-3)


def test_decoupling_holds_a_line_and_couples_none() -> None:
    silicon, current = Silicon(AMI_1500), np.array([COARSE[4]])
    more, less = (abs(line_response(lines("n"), current, silicon, 1e5, c)[0]) for c in (100e-12, 10e-12))
    assert more < 0.2 * less


@pytest.mark.parametrize(("amplitude", "frequency"), [(0.0, 50.0), (1e-2, 0.0), (float("nan"), 50.0)])
def test_what_is_no_ripple_is_refused(amplitude: float, frequency: float) -> None:
    with pytest.raises(ParameterError, match=r"ripple\.\w+: .*must be > 0"):
        Ripple(amplitude, frequency)
