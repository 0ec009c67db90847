"""Jitter of the behavioural chips beside that of their blocks' transistors: ROLLS, NEF and latency chip.

Nothing is fitted, and the papers have none of it: in the place of their values stand the transistors, in
transients with the noise of all devices (`circuits.solver.noise_transient`). Interspike intervals of a ROLLS
neuron on a direct current at 20, 50 and 100 Hz, near its threshold and above; those of a NEF neuron on an
ideal current; the delay of a tap. Nominal devices at 27 degC, white noise; of ROLLS at 50 Hz flicker too,
whose coefficient is ours. The models are taken where they have the transistors' rate. The tolerance was set
after first runs: three deviations of what so many intervals know, and a few per cent of the models' own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from chips.latency_model import charges_on
from chips.nef_build import build
from chips.nef_chip import FIFO, NefChip
from chips.nef_chip_kernel import advance_chip, new_chip_state
from chips.nef_kernel import DT
from chips.nef_network import Ensemble, Network
from chips.rebound_jitter import SiliconNoise
from chips.rolls_address import NEURONS
from chips.rolls_bias_file import default_biases
from chips.rolls_chip import RollsChip
from chips.rolls_program import Program
from circuits.bias import rebias
from circuits.blocks import latency_tap, nef_neuron, rolls_neuron
from circuits.lowering.kernel import to_kernel
from circuits.noise import WHITE_ONLY, NoiseModel
from circuits.process import AMI_1500, ELEMENTARY_CHARGE, ROLLS_180
from circuits.silicon import Silicon
from circuits.solver.noise_transient import NoiseRun, simulate_noisy
from system.experiment import Experiment, Progress, Report, Row
from system.plot import COLOURS

F64 = NDArray[np.float64]

ALLOWED = 0.1  # of the transistors' deviation
SEED = 1000
COARSE = 5  # coarse current of IF_DC_P, 0.82 nA
# fine code, length of the transistors' run (s), and the grid of their noise (s): 20, 50 and 100 Hz
ROLLS = ((40, 40.0, 40e-6), (48, 16.0, 20e-6), (71, 10.0, 20e-6))
CHIP_STEP, CHIP_TIME = 0.1e-3, 4.0  # s, of the behavioural ROLLS
NEF = ((1.5, 25.0, 50e-6), (2.5, 12.0, 20e-6))  # thresholds, s, s
NEF_NEURONS, NEF_STEPS = 64, 8000
TAP_TRIALS, TAP_STOP, TAP_STEP = 150, 3.3e-3, 2e-6


@dataclass(frozen=True, slots=True)
class Beside:
    """Deviation (s) of `count` times of the transistors, and the model's."""

    name: str
    mean: float
    transistors: float
    count: int
    model: float

    @property
    def ratio(self) -> float:
        """The model's over the transistors'."""
        return self.model / self.transistors


def run(progress: Progress) -> Report:
    """Measure everything."""
    found = []
    for k, (fine, stop, grid) in enumerate(ROLLS):
        found.append(rolls_beside(fine, stop, grid, WHITE_ONLY))
        progress(0.2 * (k + 1))
    flicker = rolls_beside(*ROLLS[1], None)
    found += [nef_beside(*each) for each in NEF]
    progress(0.9)
    found.append(tap_beside(TAP_TRIALS))
    progress(1.0)
    shown = [*found, flicker]
    return Report(tuple(rows(found, flicker)), lambda figure: draw(shown, figure), (note(shown),))


def rolls_beside(fine: int, stop: float, grid: float, flicker: NoiseModel | None) -> Beside:
    """Intervals of a neuron with I_dc of a code, the model where it has the same rate."""
    current = default_biases().with_code("IF_DC_P", COARSE, fine).current("IF_DC_P")
    circuit = rebias(rolls_neuron.build(), {"i_dc": current})
    given = {s.name: s.default for s in rolls_neuron.BLOCK.stimuli} | {"current": 0.0, "duration": stop}
    machine = to_kernel(rolls_neuron.testbench(circuit, given, ROLLS_180.v_dd), Silicon(ROLLS_180))
    gaps = np.diff(simulate_noisy(machine, NoiseRun(SEED, grid, flicker), record=("v_mem",)).spikes["spike"])[
        1:
    ]
    noise = SiliconNoise(SEED, flicker=flicker)
    points = sorted(rolls_intervals(fine + k, noise) for k in (-1, 0, 1))
    at = np.log(np.array(points))
    model = float(np.exp(np.interp(np.log(gaps.mean()), at[:, 0], at[:, 1])))
    kind = "flicker" if flicker is None else "white"
    return Beside(f"rolls_{1.0 / gaps.mean():.0f}_Hz_{kind}", *_known(gaps), model)


def rolls_intervals(fine: int, noise: SiliconNoise, duration: float = CHIP_TIME) -> tuple[float, float]:
    """Mean and deviation of the intervals of all neurons of a nominal chip, s."""
    biases = default_biases().with_code("IF_DC_P", COARSE, fine)
    program = Program(np.zeros((NEURONS, NEURONS), np.int8), biases)
    chip = RollsChip(program, Silicon(ROLLS_180), step=CHIP_STEP, noise=noise)
    _, state = chip.run(chip.at_rest(), 0.2)
    spikes, _ = chip.run(state, duration)
    gaps = np.concatenate([np.diff(spikes.times[spikes.neurons == k]) for k in range(NEURONS)])
    return float(gaps.mean()), float(gaps.std(ddof=1))


def nef_beside(thresholds: float, stop: float, grid: float) -> Beside:
    """Intervals of a neuron on an ideal current, which makes no noise."""
    given = {"current": thresholds * nef_neuron.LEAK, "duration": stop}
    bench = nef_neuron.testbench(nef_neuron.build(), given, ROLLS_180.v_dd)
    result = simulate_noisy(
        to_kernel(bench, Silicon(ROLLS_180)), NoiseRun(SEED, grid, WHITE_ONLY), record=("v_mem",)
    )
    gaps = np.diff(result.spikes["spike"])[1:]
    return Beside(
        f"nef_{thresholds:g}_thresholds", *_known(gaps), float(nef_intervals(thresholds).std(ddof=1))
    )


def nef_intervals(thresholds: float, steps: int = NEF_STEPS) -> F64:
    """Intervals of neurons of a nominal chip on an ideal current, s."""
    chip = NefChip(noise=SiliconNoise(SEED, flicker=WHITE_ONLY)).at(27.0)
    built = build(Network((Ensemble("x", NEF_NEURONS),)), chip, 1)
    if built.chip is None or built.noise is None:
        return np.empty(0)
    on = built.chip._replace(net=built.chip.net._replace(bias=np.full(NEF_NEURONS, thresholds)))
    noise = built.noise._replace(bias=np.zeros(NEF_NEURONS))
    state, last = new_chip_state(on, FIFO), np.full(NEF_NEURONS, np.nan)
    found = []
    for k in range(steps):
        before = state.base.spikes.copy()
        advance_chip(on, state, 1, noise)
        fired = np.flatnonzero(state.base.spikes > before)
        # what is left of the refractory period says when it began
        at = (k + 1) * DT - (on.refractory[fired] - state.base.rest[fired])
        found.append((at - last[fired])[np.isfinite(last[fired])])
        last[fired] = at
    return np.concatenate(found)


def tap_beside(trials: int) -> Beside:
    """Delay of a tap, whose model is `sqrt(q T / I)`."""
    circuit = latency_tap.build(latency_tap.Params(taps=1))
    bench = latency_tap.testbench(circuit, {"duration": TAP_STOP}, AMI_1500.v_dd)
    machine = to_kernel(bench, Silicon())
    noise = NoiseRun(SEED, TAP_STEP, WHITE_ONLY)
    delays = np.array([
        simulate_noisy(machine, noise, trial, record=("out[0]",)).spikes["out[0]"][0] - latency_tap.START
        for trial in range(trials)
    ])  # fmt: skip
    charge = charges_on(Silicon())["tap"]
    model = float(delays.mean()) * float(np.sqrt(ELEMENTARY_CHARGE / charge))
    return Beside("tap", *_known(delays), model)


def _known(times: F64) -> tuple[float, float, int]:
    return float(times.mean()), float(times.std(ddof=1)), times.size


def rows(found: Sequence[Beside], flicker: Beside) -> list[Row]:
    """A row a measurement, held to the tolerance but for flicker."""
    rule = f"of the transistors' deviation, within {100 * ALLOWED:g} %"
    held = [
        Row(
            f"jitter_{b.name}", 1.0, b.ratio, rule, ALLOWED, fitted=False,
            agrees=abs(b.ratio - 1.0) <= ALLOWED,
        )
        for b in found
    ]  # fmt: skip
    beside = "shown beside; its coefficient is ours"
    name = f"jitter_{flicker.name}"
    return [*held, Row(name, 1.0, flicker.ratio, beside, None, fitted=False, agrees=True)]


def note(found: Sequence[Beside]) -> str:
    """Deviations in words."""
    each = (
        f"{b.name} {1e6 * b.transistors:.3g} us of {1e3 * b.mean:.4g} ms"
        f" (+- {50 * np.sqrt(2 / b.count):.1f} %), model {1e6 * b.model:.3g} us"
        for b in found
    )
    return f"{'; '.join(each)}. The paper column is the transistors'."


def draw(found: Sequence[Beside], figure: Figure) -> None:
    """Fill `figure` with deviations over means, the transistors' with what is known of them."""
    figure.set_size_inches(7.0, 3.6)
    ax = figure.subplots()
    at = np.arange(len(found))
    theirs = np.array([b.transistors / b.mean for b in found])
    known = theirs / np.sqrt(2.0 * np.array([b.count for b in found]))
    ax.errorbar(
        at, 100 * theirs, 100 * known, color=COLOURS[0], marker="o", linestyle="", label="transistors"
    )
    model = [100 * b.model / b.mean for b in found]
    ax.plot(at, model, color=COLOURS[1], marker="x", linestyle="", label="chip's model")
    ax.set_yscale("log")
    ax.set_xticks(at, [b.name.replace("_", " ") for b in found], rotation=20, ha="right", fontsize=8)
    ax.set_ylabel("jitter (% of the time)")
    ax.legend(loc="best")


EXPERIMENT = Experiment(
    name="chip-noise",
    summary="jitter of ROLLS, NEF and latency chip beside that of their transistors",
    run=run,
)
