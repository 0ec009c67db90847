"""Bias generator: a current from a 3-bit coarse and an 8-bit fine code, proportional to temperature.

The current is `I = I_coarse fine / 256`. A self-biased core makes the master current, a current splitter
divides a scaled copy into the eight coarse currents, one of these is mirrored into a splitter of octaves, and
the bits of the fine code steer its branches to the output or to the supply:

    I_master = (U_T / R) ln M                           m1, m2 in weak inversion
    g_k / g_tap = sum(I_j, j > k) / (I_k - I_(k+1))     W/L between the coarse nodes k and k + 1
    I_out = I_coarse (b_7 / 2 + b_6 / 4 + ... + b_0 / 256)

The transistors of a splitter share their gate and bulk voltages, so that their ratios are those of W/L at any
current (Bult & Geelen 1992), switches included: a switch that is on has the gate voltage of its branch. The
splitters divide down to any small current, but the copies at the output are nFETs with their sources at
ground: at code 0 they deliver their off current `I_0 W/L`, and the lowest codes sit on it. A self-biased core
can also rest where only off and junction currents flow; the diodes `mk1` to `mk3` pull the gate of `mk4` up
until `mk5` conducts, so that the working state is the only one. On a die the devices have their mismatch, and
nothing else is drawn.

Source: codes from the control software of ROLLS (mn256r1_ncs), the formula of the master current from jAER's
Masterbias, proportionality to absolute temperature from the abstract of Delbruck & van Schaik (2005), "Bias
current generators with wide dynamic range". The topology in detail, sizes, M, R and start-up are ours, in the
AMI 1.5 um process.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from circuits.blocks.block import DURATION, Block, Stimulus, Values
from circuits.blocks.drive import powered
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out
from circuits.blocks.rest import started_at_rest
from circuits.checks import require_positive
from circuits.circuit import Circuit
from circuits.count import whole_number
from circuits.devices import Device, Resistor, Transistor
from circuits.devices.transistor import drain_currents, transistor_work
from circuits.errors import ParameterError, unknown_name
from circuits.silicon.process import AMI_1500, Polarity
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

COARSE = (24e-6, 3.2e-6, 0.4e-6, 50e-9, 6.5e-9, 820e-12, 105e-12, 15e-12)  # A, of codes 0 to 7; facts
FINE_BITS = 8
CODES = 1 << FINE_BITS
REFERENCE_C = 27.0  # degC at which the nominal generator gives these currents; ours
MASTER_CURRENT = 0.4e-6  # A at the reference temperature; ours

# Sizes: (width, length) in um, all ours.
_CORE_N = (90.0, 3.0)  # m1; inversion coefficient 0.1 at the master current
_CORE_P = (24.0, 6.0)
_KICK_P, _KICK_N = (3.0, 60.0), (3.0, 3.0)  # each of the three diodes, and what they switch on
_COARSE_TAP = (24.0, 6.0)  # of the coarse splitter's branches and switches
_COARSE_SERIES_WIDTH = 6.0  # um; lengths follow from the currents
_RANGE_N = (24.0, 6.0)  # mirror between the splitters
_FINE = (12.0, 3.0)  # unit of the splitter of octaves
_SUM_P = (48.0, 6.0)
_COPY = (6.0, 6.0)  # diode-connected copies at the output, the size of the neuron's biased devices


@dataclass(frozen=True, slots=True)
class Params:
    """Codes, the core's resistor (Ohm), and the size ratio M of the core's two nFETs.

    Raises `ParameterError` for a code outside 0 to 7 or 0 to 255, a ratio that is not above 1, and a resistor
    that is not above zero.
    """

    coarse: int = quantity(5, "")
    fine: int = quantity(125, "")  # with the coarse code: 400 pA, the neuron's I_rtau
    # ours: gives the master current at the reference temperature
    core_resistance: float = quantity(147.93e3, "Ohm")
    core_ratio: float = quantity(8.0, "")  # ours

    def __post_init__(self) -> None:
        for name, code, count in (("coarse", self.coarse, len(COARSE)), ("fine", self.fine, CODES)):
            whole_number(name, code, 0, count - 1)
        if not self.core_ratio > 1.0:
            raise ParameterError(f"core_ratio: {self.core_ratio:g}, must be > 1; 8 is usual")
        require_positive(self, "core_resistance")


def build(params: Params = Params()) -> Circuit:
    """The generator: ports i_out (sinks the current), v_n, v_p (gates of 6/6 copies, out) and the supply."""
    return Circuit(
        "bias_generator",
        (SUPPLY, *analog_in("i_out"), *analog_out("v_n", "v_p")),
        (
            *_core(params),
            *_coarse_splitter(int(params.coarse)),
            *_fine_splitter(int(params.fine)),
            *_output(),
        ),
    )


def _mos(
    name: str,
    polarity: Polarity,
    nodes: tuple[str, str, str],
    size: tuple[float, float],
    multiplicity: float = 1.0,
) -> Transistor:
    """A transistor of (drain, gate, source) nodes and (width, length) in um, its bulk at its supply."""
    return replace(mos(name, polarity, *nodes, *size), multiplicity=multiplicity)


def _core(params: Params) -> tuple[Device, ...]:
    """PTAT core (lines core_n and core_p), start-up, and the current into the coarse splitter."""
    total = sum(COARSE) / MASTER_CURRENT
    return (
        _mos("m1", "n", ("core_n", "core_n", "0"), _CORE_N),
        _mos("m2", "n", ("core_p", "core_n", "core_r"), _CORE_N, params.core_ratio),
        Resistor("r", "core_r", "0", params.core_resistance),
        _mos("m3", "p", ("core_n", "core_p", "vdd"), _CORE_P),
        _mos("m4", "p", ("core_p", "core_p", "vdd"), _CORE_P),
        _mos("mk1", "p", ("kick_a", "kick_a", "vdd"), _KICK_P),
        _mos("mk2", "p", ("kick_b", "kick_b", "kick_a"), _KICK_P),
        _mos("mk3", "p", ("kick", "kick", "kick_b"), _KICK_P),
        _mos("mk4", "n", ("core_p", "kick", "0"), _KICK_N),
        _mos("mk5", "n", ("kick", "core_n", "0"), _CORE_N),
        _mos("mfeed", "p", ("c0", "core_p", "vdd"), _CORE_P, total),
    )


def _coarse_splitter(code: int) -> list[Device]:
    """PFETs with their gates at ground; the branch of `code` ends in the mirror, the others at ground."""
    devices: list[Device] = []
    tap = 0.5 * _COARSE_TAP[0] / _COARSE_TAP[1]  # a branch and its switch in series
    for k, current in enumerate(COARSE):
        devices.append(_mos(f"mc{k}", "p", (f"ct{k}", "0", f"c{k}"), _COARSE_TAP))
        on, off = ("0", "vdd") if k == code else ("vdd", "0")
        devices.append(_mos(f"mcs{k}", "p", ("range_n", on, f"ct{k}"), _COARSE_TAP))
        devices.append(_mos(f"mcd{k}", "p", ("0", off, f"ct{k}"), _COARSE_TAP))
        if k + 1 < len(COARSE):
            ratio = tap * sum(COARSE[k + 1 :]) / (current - COARSE[k + 1])
            size = (_COARSE_SERIES_WIDTH, _COARSE_SERIES_WIDTH / ratio)
            devices.append(_mos(f"mch{k}", "p", (f"c{k + 1}", "0", f"c{k}"), size))
    return devices


def _fine_splitter(code: int) -> list[Device]:
    """Mirror, and nFETs with their gates at the supply; the first branch is the most significant bit."""
    devices: list[Device] = [
        _mos("mr1", "n", ("range_n", "range_n", "0"), _RANGE_N),
        _mos("mr2", "n", ("f0", "range_n", "0"), _RANGE_N),
    ]
    for k in range(FINE_BITS):
        devices.append(_mos(f"mf{k}", "n", (f"ft{k}", "vdd", f"f{k}"), _FINE))
        on, off = ("vdd", "0") if code >> (FINE_BITS - 1 - k) & 1 else ("0", "vdd")
        devices.append(_mos(f"mfs{k}", "n", ("sum", on, f"ft{k}"), _FINE))
        devices.append(_mos(f"mfd{k}", "n", ("vdd", off, f"ft{k}"), _FINE))
        if k + 1 < FINE_BITS:
            devices.append(_mos(f"mfh{k}", "n", (f"f{k + 1}", "vdd", f"f{k}"), _FINE))
    last = f"f{FINE_BITS - 1}"
    devices.append(_mos("mfe0", "n", ("fe", "vdd", last), _FINE))
    devices.append(_mos("mfe1", "n", ("vdd", "vdd", "fe"), _FINE))
    return devices


def _output() -> tuple[Device, ...]:
    return (
        _mos("mo1", "p", ("sum", "sum", "vdd"), _SUM_P),
        _mos("mo2", "p", ("v_n", "sum", "vdd"), _SUM_P),
        _mos("mdn", "n", ("v_n", "v_n", "0"), _COPY),
        _mos("mout", "n", ("i_out", "v_n", "0"), _COPY),
        _mos("mp", "n", ("v_p", "v_n", "0"), _COPY),
        _mos("mdp", "p", ("v_p", "v_p", "vdd"), _COPY),
    )


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """An ideal voltage `output` (V) at i_out, through which the current flows; it begins as it works."""
    sources = powered(v_dd, {"i_out": stimuli["output"] or 0.0})
    bench = Testbench("bias generator", circuit, sources, stimuli["duration"] or STOP)
    return started_at_rest(bench, AMI_1500)


STOP = 1e-3  # s; ours: nothing moves


def transistor_current(point: OperatingPoint, path: str) -> float:
    """Current from drain to source of the transistor at a path such as `stage_3.md`, A, negative in a pFET.

    Raises `UnknownNameError` for a path that is no transistor.
    """
    transistors = point.machine.kernel.transistors
    work = transistor_work(transistors.sign.size)
    drain_currents(transistors, point.voltage, work)
    labels = point.machine.flat.labels(Transistor)
    if path not in labels:
        raise unknown_name(f"{point.machine.flat.circuit.name} transistor", path, labels)
    current: float = work.current[labels.index(path)].item()
    return current


def output_current(point: OperatingPoint) -> float:
    """Current that i_out sinks at an operating point of the testbench, A."""
    return transistor_current(point, "mout")


def measures(result: Result) -> dict[str, float | None]:
    """Numbers at rest: `output_current_A` and `master_current_A`."""
    point = result.operating_point
    return {
        "output_current_A": output_current(point),
        "master_current_A": transistor_current(point, "m1"),
    }


def outcome(result: Result) -> str:
    """`started`, or `no-current` where the core rests below a tenth of its master current."""
    scale = (result.machine.silicon.temperature_c + 273.15) / (REFERENCE_C + 273.15)
    master = transistor_current(result.operating_point, "m1")
    return "started" if np.abs(master) > 0.1 * scale * MASTER_CURRENT else "no-current"


BLOCK = Block(
    name="bias-generator",
    summary="current of a coarse and a fine code, proportional to absolute temperature",
    build=build,
    stimuli=(
        Stimulus("output", "V", 2.5, "ideal voltage at the output"),
        DURATION,
    ),
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("v_n", "v_p"),
)
