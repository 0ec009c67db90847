"""Noise of a ROLLS chip from that of its devices: the same die spikes at other times.

Membrane: every current that a transistor lets onto it brings shot noise, of both components, which in the
variable of a step (`chips.rolls.kernel`) has the variance

    D = (q / Q_0^2) [(I_leak coth(v / 2 U_T) + (1 + 2 g) I_fb + I_mc4 + N_inh) / share^2 + J / share]

a second. J has one `J / share` alone: what the pair of the leak divides stays shot noise of what it lets
through. The feedback passes a mirror of gain g, and so does inhibition, `N_inh = I (1 + e^(-v / U_T)) + 2 g I
(1 - e^(-v / U_T))^2`. Where the neuron's own current a carries it to the top, T_0 = int dzeta / a has the
variance `int D / a^3 dzeta`, and a constant current n moves it by n T_1, T_1 = int dzeta / a^2.
Filter: shot noise of I_tau, of the charge of a pulse, which its mirror's three devices make in the exciting
synapse, and of the pulse's end, `q / (I_pwlk t)` of the charge squared; the plastic array's slow filters and
calcium alike, whose pulses are sunk without a mirror.
Flicker: a current varies by `kappa / U_T` of its gate's voltage, whose density is K_F / (W L Cox f)
(`chips.noise_draw`). Filters of a sign share theirs, and follow it at once.
Lines of the generator wander (`chips.lines.steps`): those of leak, direct current, and of the time constants
and gains of the array's filters, whose lines stand for the virtual synapses' too; filters follow at once.
Left out: the other lines, v_o1, the reset and its kT/C, the refractory period, what the followers' noise
bandwidth takes off, the adaptation's gate, plastic weights, comparators and the NMDA gate, strong inversion's
lower noise; pulses of a column end together, here each for itself. Cells of depression have theirs in
`chips.rolls.depression.kernel`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chips.lines.steps import LineSteps, line_steps
from chips.lines.wander import wander_of
from chips.noise import SiliconNoise, die_name
from chips.noise_draw import new_draws, new_slow
from chips.rolls.circuit import NAME, Params, chip
from chips.rolls.layout import SIGNS
from chips.rolls.layout import STATIC as OWN
from chips.rolls.lumped.grid import edges
from chips.rolls.neuron.kernel import INJECTED, Neurons
from chips.rolls.neuron.membrane import Membrane
from chips.rolls.neuron.whole_membrane import WholeMembrane
from chips.rolls.noise.layout import (
    BACK,
    DIRECT,
    DRAWN,
    INPUT,
    LEAK,
    NOISE_COLUMNS,
    PAIR,
    REVERSED,
    RISE,
    WHITE,
    NoiseTables,
)
from chips.rolls.parts import devices_at, part_gates, row_place
from chips.rolls.plastic.biases import PULSE
from chips.rolls.plastic.tables import BuiltPlastic
from chips.rolls.program.address import NEURONS
from chips.rolls.program.program import Program
from chips.rolls.tables import Built
from circuits.arrays import F32, F64, Bools
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.circuit import BiasKind, Circuit
from circuits.devices.ekv import steepness
from circuits.devices.noise import NoiseModel, gate_flicker
from circuits.lowering.on_die import DieDevices, transistor_of
from circuits.silicon.process import ELEMENTARY_CHARGE
from circuits.silicon.silicon import Silicon

_NUDGE = 1e-4  # V, of a gate, over which a slope is taken; ours
MIRRORED = 2.0  # electrons of noise that two more devices of a mirror add


def with_noise(
    built: Built, params: Params, program: Program, kind: BiasKind, silicon: Silicon,
    noise: SiliconNoise | None,
) -> Built:  # fmt: skip
    """Return the tables of a chip on a silicon with its noise, unchanged where `noise` is None.

    Raises `ParameterError` for a ripple on biases that are none of a generator's.
    """
    if noise is None:
        return built
    d = devices_at(
        rolls_neuron.build(params.neuron), row_place(NEURONS, ("neuron", ())), silicon,
        part_gates("neuron", built.gates),
    )  # fmt: skip
    flicker, step = noise.flicker_in(silicon.process), built.tables.step
    densities = slow_densities(params, silicon, d, program, flicker)
    tables = NoiseTables(
        membrane_rows(built, d, program.slow_leak(), step).astype(np.float32),
        np.stack([ELEMENTARY_CHARGE / f.unit for f in built.filters]).astype(np.float32),
        _excess(built, program).astype(np.float32),
        new_draws(noise.seed, noise.trial, die_name(NAME, silicon.die), NEURONS),
        new_slow(densities, flicker, step, NEURONS),
        *_plastic_grains(built.plastic, program),
        generator_lines(params, silicon, d, program, kind, noise, step),
    )
    return replace(built, noise=tables)


def membrane_rows(built: Built, d: DieDevices, slow: Bools, step: float) -> F64:
    """Return what a step of `step` s needs of the neurons `d`, float64[n, rows, NOISE_COLUMNS].

    slow: which leak is on, bool[n].
    """
    m, lines = built.neurons, built.tables.membranes.lines
    edge = edges(lines.shape[1])
    centre = 0.5 * (edge[1:] + edge[:-1])
    voltage = built.tables.membranes.voltage
    v = np.clip(voltage[:, :, 0] + voltage[:, :, 1] * centre, 0.0, m.top[:, None])
    v = np.ascontiguousarray(v, dtype=np.float64)
    held = WholeMembrane(d, v) if d.full else Membrane(d, v)
    share, inverse = _share(m, held.inside()), 1.0 / built.charge[:, None]
    leak, back, pull = held.leak(slow), held.feedback(), held.pull()
    direct = np.stack([np.interp(at, np.linspace(0.0, t, m.table.shape[1]), c)
                       for at, t, c in zip(v, m.top, m.table[:, :, INJECTED], strict=True)])  # fmt: skip
    near = np.exp(-v / d.u_t)
    copied = (1.0 + MIRRORED * d.mirror("sodium.mn3", "sodium.mn4").weak)[:, None]
    shots = (leak + held.off()) / np.tanh(np.maximum(v, 1e-6) / (2.0 * d.u_t)) + copied * back + pull
    grain = ELEMENTARY_CHARGE * inverse**2
    rows = np.zeros((*v.shape, NOISE_COLUMNS))
    rows[:, :, WHITE] = grain * (shots / share**2 + direct / share)
    rows[:, :, INPUT] = grain / share
    rows[:, :, DRAWN] = grain * (1.0 + near + MIRRORED * (1.0 - near) ** 2) / share**2
    rows[:, :, LEAK] = -leak / share * inverse
    rows[:, :, BACK] = back / share * inverse
    rows[:, :, DIRECT] = direct * inverse
    rows[:, :, PAIR] = 1.0 - share
    rows[:, :, REVERSED] = (1.0 - near) / share * inverse
    own = (lines[:, :, OWN] + lines[:, :, OWN + 1] * centre) * inverse
    inside = centre[None, :] < built.tables.membranes.top[:, None]
    rows[:, :, RISE] = _rising(own, rows[:, :, WHITE], np.diff(edge) * inside, 1.0 / step)
    return rows


def _rising(own: F64, density: F64, width: F64, otherwise: float) -> F64:
    """`V / (T_1^2 D)` from each row to the top, 1/s; `otherwise` where the neuron does not rise by itself."""
    a = np.where(own > 0.0, own, np.inf)
    late = np.cumsum((density / a**3 * width)[:, ::-1], axis=1)[:, ::-1]
    moved = np.cumsum((width / a**2)[:, ::-1], axis=1)[:, ::-1]
    sure = (np.cumsum((own <= 0.0)[:, ::-1], axis=1)[:, ::-1] == 0) & (moved > 0.0)
    return np.where(sure, late / np.where(sure, moved**2 * density, 1.0), otherwise)


def _share(m: Neurons, inside: F64) -> F64:
    """Share of a weak input that enters the membrane, float64[n, points]; inside: as in `Neurons`."""
    second = m.membrane_current[:, None] * np.exp(inside - m.ground_pinch[:, None])
    return np.asarray(second / (m.ground_current[:, None] + second))


def _excess(built: Built, program: Program) -> F64:
    """Electrons of noise of a pulse's electron beyond the first, float64[SIGNS, n]."""
    charges, virtual = built.tables.charges, built.tables.virtual
    pulse = program.biases.current("NPA_PWLK_P") * float(built.lengths.mean())
    found = np.zeros((SIGNS, NEURONS))
    for sign in range(SIGNS):
        drawn = (charges if sign == 0 else -charges) if sign < 2 else virtual[4 * (sign - 2) :][:4]
        q = np.maximum(drawn, 0.0).astype(np.float64)
        typical = (q * q).sum(axis=0) / np.maximum(q.sum(axis=0), 1e-30) * built.filters[sign].unit
        found[sign] = (MIRRORED if sign % 2 == 0 else 0.0) + typical / pulse
    return found


def _plastic_grains(plastic: BuiltPlastic | None, program: Program) -> tuple[F32, F32]:
    """An electron in z of the array's two filters, and what a pulse's end adds to one of a pulse."""
    grain, excess = np.zeros((2, 2, NEURONS), np.float32)
    if plastic is None:
        return grain, excess
    pulse, tables = program.biases.current(PULSE) * float(np.mean(plastic.lengths)), plastic.tables
    sums = tables.charge.sum(axis=0, dtype=np.float64), (tables.charge.astype(np.float64) ** 2).sum(axis=0)
    typical = sums[1] / np.maximum(sums[0], 1e-30), tables.spike
    for k, f in enumerate(plastic.filters):
        grain[k] = ELEMENTARY_CHARGE / f.unit
        excess[k] = typical[k] * f.unit / pulse
    return grain, excess


def slow_densities(
    params: Params, silicon: Silicon, d: DieDevices, program: Program, flicker: NoiseModel
) -> F64:
    """Return the densities of the relative slow processes at 1 Hz, 1/Hz, from SLOW_LEAK to SLOW_INHIBIT."""
    of = _Gates(silicon, flicker)
    neuron, synapse = rolls_neuron.build(params.neuron), params.synapse
    leak, bias = _leak(program)
    steep = _steepness(d, leak, float(d.gate[f"v_{bias}"]))
    exciting = dpi_synapse.excitatory_filter(synapse)
    inhibiting = dpi_synapse.inhibitory_filter(synapse)
    k_n, k_p = d.fet["sodium.mn1"].kappa, d.fet["sodium.mn3"].kappa
    found = [
        steep**2 * of(neuron, leak),
        of(neuron, "sodium.mn1") + of(neuron, "sodium.mn3") + of(neuron, "sodium.mn4"),
        of(neuron, "leak.ml9"),
        of(neuron, "leak.ml1") + of(neuron, "leak.ml2"),
    ]
    for made, mirror in ((exciting, ()), (inhibiting, ("md6", "md7"))):
        # at the filter's pair, kappa_n is turned into the output's kappa_p
        pair = (k_p / k_n) ** 2 * (of(made, "md1") + of(made, "md2") + of(made, "md3"))
        found.append(pair + of(made, "md5") + sum(of(made, name) for name in mirror))
    return np.array(found)


def _leak(program: Program) -> tuple[str, str]:
    """Device of the leak that is on, and its bias."""
    return ("leak.ml3", "tau1") if program.slow_leak().all() else ("leak.ml4", "tau2")


def generator_lines(
    params: Params, silicon: Silicon, d: DieDevices, program: Program, kind: BiasKind, noise: SiliconNoise,
    step: float,
) -> LineSteps:  # fmt: skip
    """Lines from LINE_LEAK to LINE_INH_GAIN; those of filters carry weak inversion's currents.

    A line moves the current of the neurons' devices by the slope that they have at its voltage.
    """
    leak, bias = _leak(program)
    names = (bias, "dc", "excitatory_tau", "excitatory_thr", "inhibitory_tau", "inhibitory_thr")
    there = replace(silicon, place=((NAME, ()),))
    wander = wander_of(chip(params, program.biases, kind), [f"i_{n}" for n in names], there, noise)
    weak = silicon.law("p").kappa / silicon.thermal_voltage
    found = _slope(d, leak, float(d.gate[f"v_{bias}"])), _slope(d, "leak.ml9", float(d.below("v_dc")))
    slope = np.array([*found, *(weak for _ in names[2:])])
    return line_steps(wander, slope, silicon, noise, die_name(NAME, silicon.die), step)


class _Gates:
    """Densities at 1 Hz of relative currents of a device in weak inversion, 1/Hz: `(kappa / U_T)^2 K`."""

    def __init__(self, silicon: Silicon, flicker: NoiseModel) -> None:
        self.silicon, self.flicker = silicon, flicker

    def __call__(self, circuit: Circuit, name: str) -> float:
        """Of the device at path `name`."""
        device = transistor_of(circuit, name)
        area, is_n = np.array([device.gate_area]), np.array([device.polarity == "n"])
        slope = self.silicon.law(device.polarity).kappa / self.silicon.thermal_voltage
        return float(slope**2 * gate_flicker(self.flicker, self.silicon.process, is_n, area)[0])


def _steepness(d: DieDevices, name: str, gate: float) -> float:
    """`d ln I / du` of a saturated device, 1 in weak inversion; the mean over the neurons."""
    return float(np.mean(steepness(d.saturated(name, gate) / d.fet[name].current)))


def _slope(d: DieDevices, name: str, gate: float) -> float:
    """`d ln I / dv` of a saturated device at a gate's voltage, 1/V; the mean over the neurons."""
    low, high = (d.saturated(name, gate + v) for v in (-_NUDGE, _NUDGE))
    return float(np.mean(np.log(high / low))) / (2.0 * _NUDGE)
