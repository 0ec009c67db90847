"""Logarithmic photoreceptor: an nFET carries the photocurrent, and an amplifier holds the photodiode's node.

    v_pr = const + (U_T / kappa_n) ln I_ph

The amplifier moves the gate of `m_fb` rather than the photodiode's node, whose capacitance it so makes small:
the response is as many times faster as it has gain. A pFET follower hands the voltage on; its well stands at
the supply, so that it passes kappa_p of a change.

Source: topology and sizes after the chip's figure (the feedback 2 um square, the amplifier 1 um and 3.4 um by
1 um, the photodiode 10 um square). The photodiode's capacitance, 1 fF/um^2, and the biases are ours; there is
no measurement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import current_into, powered
from circuits.blocks.measure import between
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, biased
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor
from circuits.devices.source import PiecewiseLinear
from circuits.errors import ParameterError
from circuits.event import rising_crossing
from circuits.silicon.process import ROLLS_180
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

BEGIN, EDGE = 10e-3, 10e-6  # s, of the step
MOST = 20.0  # e-folds of a step


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitor (F) and sizes (um).

    feedback: of m_fb, which carries the photocurrent. n: of the amplifier's nFETs, its input m_n and the
    cascode. p: of its load m_pr, and of the follower m_sf with its bias.
    """

    photodiode_capacitance: float = quantity(0.1e-12, "F")
    feedback_width: float = um(2.0)
    feedback_length: float = um(2.0)
    n_width: float = um(1.0)
    n_length: float = um(1.0)
    p_width: float = um(3.4)
    p_length: float = um(1.0)


BIASES = (
    coded_bias("prb", MASTERS[2], 100, "m_pr", (3.4, 1.0)),
    coded_bias("sfb", MASTERS[2], 100, "m_b2", (3.4, 1.0)),
    Bias("v_cas", "v_cas", "voltage", 0.8),
)


def build(params: Params = Params()) -> Circuit:
    """The photoreceptor: ports v_pd (photocurrent out), v_sf (out), biases, the supply; params: its sizes."""
    n, p = params.sizes("n", "p")
    devices = (
        Capacitor("c_pd", "v_pd", "0", params.photodiode_capacitance),
        mos("m_fb", "n", "vdd", "v_pr", "v_pd", *params.size("feedback")),
        mos("m_n", "n", "v_n", "v_pd", "0", *n),
        mos("m_cas", "n", "v_pr", "v_cas", "v_n", *n),
        mos("m_pr", "p", "v_pr", "v_prb", "vdd", *p),
        mos("m_b2", "p", "v_sf", "v_sfb", "vdd", *p),
        mos("m_sf", "p", "0", "v_pr", "v_sf", *p),
    )
    return biased("photoreceptor", (SUPPLY, *analog_in("v_pd"), *analog_out("v_sf")), BIASES, devices)


STIMULI = (
    Stimulus("photocurrent", "A", 10e-12, "before the step"),
    Stimulus("step", "", 1.0, "e-folds by which it steps"),
    lasting(20e-3, "from the step on"),
)
PLOTTED = ("v_pd", "v_pr", "v_sf")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A photocurrent that steps by so many e-folds 10 ms into the run.

    Raises `ParameterError` for no photocurrent, and for a step of more than 20 e-folds either way.
    """
    dark, step = stimuli["photocurrent"] or 0.0, stimuli["step"] or 0.0
    check_light(dark, step)
    wave = PiecewiseLinear((0.0, BEGIN, BEGIN + EDGE), (-dark, -dark, -dark * math.exp(step)))
    sources = (*powered(v_dd), current_into("v_pd", wave))
    return rested("photoreceptor", circuit, sources, BEGIN + (stimuli["duration"] or 0.0), ROLLS_180)


def check_light(photocurrent: float, step: float) -> None:
    """Raise `ParameterError` for a photocurrent (A) of none, or a change of too many e-folds."""
    if not photocurrent > 0.0:
        raise ParameterError(f"photocurrent: {photocurrent:g} A, must be > 0; give that of the dark at least")
    if not abs(step) <= MOST:
        raise ParameterError(f"step: {step:g} e-folds, must be within {MOST:g} either way")


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `gain_V`, `follower_gain`, `rise_s` and `level_V`.

    gain: of v_pr an e-fold of the photocurrent, None without a step. follower_gain: change of v_sf over that
    of v_pr. rise: from the step until v_pr has made 1 - 1 / e of its change. level: v_sf before the step.
    """
    time, v_pr, v_sf = result.time, result["v_pr"], result["v_sf"]
    folds = _folds(result)
    begin, end = float(v_pr[0]), float(v_pr[-1])
    if abs(folds) < 1e-9 or time[-1] <= BEGIN + EDGE:
        return {"gain_V": None, "follower_gain": None, "rise_s": None, "level_V": float(v_sf[0])}
    made = rising_crossing(time, (v_pr - begin) / (end - begin), 1.0 - math.exp(-1.0))
    return {
        "gain_V": (end - begin) / folds,
        "follower_gain": float(v_sf[-1] - v_sf[0]) / (end - begin),
        "rise_s": between(BEGIN, made),
        "level_V": float(v_sf[0]),
    }


def _folds(result: Result) -> float:
    """By how many e-folds the photocurrent has changed."""
    machine = result.machine
    levels = machine.polylines[machine.source_names.index("v_pd")][1]
    return math.log(levels[-1] / levels[0])


def light(begin: float, end: float, dark: float, folds: float, points: int) -> tuple[F64, F64]:
    """Times (s) and photocurrents (A) of an exponential change by so many e-folds, float64[points]."""
    share = np.linspace(0.0, 1.0, points)
    return begin + (end - begin) * share, dark * np.exp(folds * share)


def outcome(result: Result) -> str:
    """`brighter`, `darker` or `still`: how v_pr has moved."""
    moved = float(result["v_pr"][-1] - result["v_pr"][0])
    if abs(moved) < 1e-3:
        return "still"
    return "brighter" if moved > 0.0 else "darker"


BLOCK = catalogued("photoreceptor", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
