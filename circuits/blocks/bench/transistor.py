"""The chip's lone transistors, 4 um by 4 um, each between two ammeters.

An ammeter is a shunt in series with the drain, and one with the source: 33 kOhm in the sensitive range, at
whose end of 1 uA it takes 33 mV, and 330 Ohm in the other, up to 100 uA. Both stand in the circuit, since
what a sweep shows of a transistor at 1 uA is as much theirs. The pFET has a well of its own.

The testbench does what the laboratory does: it sweeps the gate at a drain far from the source, then the drain
at one gate voltage. All voltages count from the source's rail.

    kappa = U_T d ln I / d V_G      below threshold
    V_E = I / (dI / dV_D) - V_D     in saturation

Source: sizes, shunts and pins are the laboratory's. Where kappa is read, 30 pA to 1 nA for a square device,
is ours: there the real ammeters show nothing (`chips.coach`), and the law is within 2 % of its slope.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from circuits.arrays import F64
from circuits.blocks.bench.curve import crossing, ramp, slope, thermal_voltage, within_supply
from circuits.blocks.block import Block, Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import Wave, driven
from circuits.blocks.measure import whether
from circuits.blocks.mos import UM
from circuits.blocks.ports import analog_in
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.devices import Resistor, Transistor
from circuits.devices.source import PiecewiseLinear
from circuits.silicon.process import ROLLS_180, Polarity
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

POINTS = 180  # of each sweep, one a hundredth of the supply
KAPPA_FROM, KAPPA_TO = 30e-12, 1e-9  # A, where kappa is read; ours
AT = 100e-9  # A, of a square device at its threshold: the criterion of constant current
LEAST = 1e-30  # A, what stands for no current in a logarithm
EARLY_FROM = 1.0  # V between drain and source, from where the Early voltage is read


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Sizes (um) and shunts (Ohm)."""

    width: float = um(4.0)
    length: float = um(4.0)
    drain_resistance: float = quantity(33e3, "Ohm")
    source_resistance: float = quantity(33e3, "Ohm")


def build(polarity: Polarity, params: Params) -> Circuit:
    """The transistor `m` of a polarity: ports drain, gate, source, and the pFET's well."""
    bulk = "well" if polarity == "p" else "0"
    device = Transistor("m", polarity, "d", "gate", "s", bulk, params.width * UM, params.length * UM)
    shunts = (
        Resistor("r_drain", "drain", "d", params.drain_resistance),
        Resistor("r_source", "source", "s", params.source_resistance),
    )
    well = analog_in("well") if polarity == "p" else ()
    return Circuit(f"{polarity}fet", (*analog_in("drain", "gate", "source"), *well), (device, *shunts))


def nfet(params: Params = Params()) -> Circuit:
    """The nFET `m` and its shunts: ports drain, gate, source; params: sizes and shunts."""
    return build("n", params)


def pfet(params: Params = Params()) -> Circuit:
    """The pFET `m` and its shunts: ports drain, gate, source, well; params: those of `nfet`."""
    return build("p", params)


def testbench(polarity: Polarity, circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A sweep of the gate over the supply, then one of the drain; each takes half of the run.

    Voltages of the knobs count from the source's rail. Raises `ParameterError` for one beyond the supply.
    """
    drain, gate, source, duration = (stimuli[name] or 0.0 for name in ("drain", "gate", "source", "duration"))
    for name, level in (("drain", drain), ("gate", gate), ("source", source)):
        within_supply(name, v_dd, level)

    def turn(level: float) -> float:
        return level if polarity == "n" else v_dd - level

    half, settled = 0.5 * duration, 0.51 * duration
    waves: dict[str, Wave] = {
        "gate": _then(ramp(0.0, half, turn(0.0), turn(v_dd), POINTS), settled, turn(gate)),
        "drain": _before(turn(drain), half, ramp(settled, duration, turn(source), turn(v_dd), POINTS)),
        "source": turn(source),
    }
    well = {"well": v_dd} if polarity == "p" else {}
    return Testbench(f"{polarity}FET", circuit, driven({**waves, **well}), duration)


def _then(wave: PiecewiseLinear, at: float, level: float) -> PiecewiseLinear:
    """A wave, then a level that it reaches at a time, s."""
    return PiecewiseLinear((*wave.time, at), (*wave.value, level))


def _before(level: float, until: float, wave: PiecewiseLinear) -> PiecewiseLinear:
    """A level until a time (s), then a wave."""
    return PiecewiseLinear((0.0, until, *wave.time), (level, level, *wave.value))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `kappa`, `threshold_V`, `transconductance_S`, `early_voltage_V` and `on_current_A`.

    kappa: below threshold. threshold: gate voltage at 100 nA times W / L. transconductance: dI / dV_G at the
    knob's gate voltage. early_voltage: from 1 V between drain and source on. on_current: the largest of the
    gate's sweep, with the shunts. None where a curve does not get there.
    """
    circuit = result.machine.testbench.circuit
    square = _square(circuit)
    rail = float(result["well"][0]) if circuit.name == "pfet" else 0.0
    time, current = result.time, np.abs(drain_current(result, "m"))
    gate, drain = np.abs(result["gate"] - rail), np.abs(result["d"] - result["s"])
    first, second = time <= 0.5 * time[-1], time >= 0.51 * time[-1]
    weak = first & (current > KAPPA_FROM * square) & (current < KAPPA_TO * square)
    logarithm = np.log(np.maximum(current, LEAST))
    fall = slope(gate, logarithm, weak)
    at = float(gate[-1])
    return {
        "kappa": None if fall is None else fall * thermal_voltage(result),
        "threshold_V": crossing(gate[first], logarithm[first], math.log(AT * square)),
        "transconductance_S": slope(gate, current, first & (np.abs(gate - at) < 0.025)),
        "early_voltage_V": _early_voltage(drain[second], current[second]),
        "on_current_A": float(current[first].max()),
    }


def _square(circuit: Circuit) -> float:
    """W / L of the transistor."""
    device = circuit.device("m")
    return device.square if isinstance(device, Transistor) else 1.0


def _early_voltage(drain: F64, current: F64) -> float | None:
    far = drain > EARLY_FROM
    rise = slope(drain, current, far)
    if rise is None or rise <= 0.0:
        return None
    return float(current[far].mean() / rise - drain[far].mean())


def _block(polarity: Polarity, made: Callable[..., Circuit], rail: str) -> Block:
    stimuli = (
        Stimulus("drain", "V", 1.8, f"drain{rail} while the gate is swept"),
        Stimulus("gate", "V", 0.8, f"gate{rail} while the drain is swept"),
        Stimulus("source", "V", 0.0, f"source{rail}"),
        lasting(2.0, "length of both sweeps"),
    )
    bench, outcome = partial(testbench, polarity), whether(measures, "threshold_V", "on", "off")
    plotted = ("gate", "drain", "d", "s")
    return catalogued(f"test-{polarity}fet", made, stimuli, bench, measures, outcome, plotted, ROLLS_180)


NFET = _block("n", nfet, "")
PFET = _block("p", pfet, " below the supply")
