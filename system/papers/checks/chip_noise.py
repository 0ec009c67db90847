"""Jitter of the behavioural chips beside that of their transistors: ROLLS, NEF, latency and sonar chips.

Nothing is fitted, and the papers have none of it: the standard deviation of a time in a behavioural model is
compared with that of its transistors, in transients with the noise of all devices
(`circuits.solver.noise.transient`). Measured are interspike intervals of a ROLLS neuron on a direct current
at 20, 50 and 100 Hz, near its threshold and above; those of a NEF neuron on an ideal current; the delay of a
tap; times of the sonar's parts (`chip_noise_sonar`) and of the selection (`chip_noise_choice`). Devices are
nominal at 27 degC and have white noise; ROLLS at 50 Hz has flicker too, whose coefficient is ours. The models
are taken where they have the transistors' rate. The isolation's model has no noise, which is held against its
error. The tolerance was set after first runs: three deviations of what so many intervals know, and a few per
cent of the models' own; of the sonar's it is that by each row's count.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import version

import numpy as np
from matplotlib.figure import Figure

from chips.latency.model import charges_on
from chips.latency.noise import charge_spread
from chips.nef.build import build
from chips.nef.chip import FIFO, NefChip
from chips.nef.kernel import advance_chip, new_chip_state
from chips.nef.network.kernel import DT
from chips.nef.network.network import Ensemble, Network
from chips.noise import SiliconNoise
from chips.rolls.chip import RollsChip
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.latency import tap as latency_tap
from circuits.blocks.nef import neuron as nef_neuron
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.devices.noise import WHITE_ONLY, NoiseModel
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500_IDEAL, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import NoiseRun, simulate_noisy
from system.experiment import Experiment, Progress, Report
from system.papers.checks.chip_noise_choice import SELECTIONS, isolation_rows, selection_beside
from system.papers.checks.chip_noise_sonar import (
    LSO,
    PEAKS,
    SLOPES,
    call_beside,
    hearing_beside,
    interval_beside,
    level_beside,
    lso_beside,
    step_beside,
)
from system.papers.checks.jitter_beside import Beside, known
from system.plot import COLOURS, sized_axes
from system.rule import unjudged, within
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

ALLOWED = 0.1  # of the transistors' deviation
LEFT_OUT = 0.05  # of it, by what the sonar's models leave out; and three deviations of what the trials know
TRIALS = 200  # of a row of the sonar's
WHOLE = 0  # trials of a measurement whose length is its own
FLICKER = "ROLLS, flicker"
INTERVALS = 80  # of the vocalization controller's board
SEED = 1000
COARSE = 5  # coarse current of IF_DC_P, 0.82 nA
# fine code, length of the transistors' run (s), and the grid of their noise (s): 20, 50 and 100 Hz
ROLLS = ((40, 40.0, 40e-6), (48, 16.0, 20e-6), (71, 10.0, 20e-6))
CHIP_STEP, CHIP_TIME = 0.1e-3, 4.0  # s, of the behavioural ROLLS
NEF = ((1.5, 25.0, 50e-6), (2.5, 12.0, 20e-6))  # thresholds, s, s
NEF_NEURONS, NEF_STEPS = 64, 8000
TAP_TRIALS, TAP_STOP, TAP_STEP = 300, 3.3e-3, 0.5e-6


def reproduce(progress: Progress, execution: Execution = ALONE, trials: int = TRIALS) -> Report:
    """Measure everything; `trials` of a row of the sonar's."""
    keys = [*(Numbered(name, WHOLE) for name in chips()), *(Numbered(name, trials) for name in sonar(trials))]
    numbers = (version("noctule"), SEED, ROLLS, NEF, TAP_TRIALS, TAP_STOP, TAP_STEP, INTERVALS)
    campaign = Campaign(EXPERIMENT.name, measure, Numbered, Beside, numbers)
    by_name = execution.by_condition(campaign, keys, progress)
    flicker = by_name[FLICKER][0]
    found = [each for name in chips() if name != FLICKER for each in by_name[name]]
    beside = [each for name in sonar(trials) for each in by_name[name]]
    shown = [*found, *beside, flicker]
    return Report(
        (*rows(found, flicker), *sonar_rows(beside), *isolation_rows()),
        lambda figure: draw(shown, figure),
        (note(shown),),
    )


def measure(key: Numbered) -> Beside:
    """The measurement of a name, the sonar's with so many trials."""
    known_as = chips() if key.number == WHOLE else sonar(key.number)
    return known_as[key.condition]()


def chips() -> dict[str, Callable[[], Beside]]:
    """Measurements of ROLLS, NEF and latency chip, by name."""
    return {
        **{f"ROLLS, code {each[0]}": partial(rolls_beside, *each, WHITE_ONLY) for each in ROLLS},
        FLICKER: partial(rolls_beside, *ROLLS[1], None),
        **{f"NEF, {each[0]:g} thresholds": partial(nef_beside, *each) for each in NEF},
        "tap": partial(tap_beside, TAP_TRIALS),
    }


def sonar(trials: int) -> dict[str, Callable[[], Beside]]:
    """Measurements of the sonar's parts and of the selection, by name."""
    return {
        **{f"LSO, {name}": partial(lso_beside, name, trials) for name in LSO},
        "step": partial(step_beside, trials),
        **{f"level, slope {slope}": partial(level_beside, slope, trials) for slope in SLOPES},
        **{
            f"hearing, {name}, {ratio}": partial(hearing_beside, name, ratio, trials) for name, ratio in PEAKS
        },
        "call": partial(call_beside, trials),
        "interval": partial(interval_beside, INTERVALS),
        **{
            f"selection, {contrast}, {grid}": partial(selection_beside, contrast, grid, trials)
            for contrast, grid in SELECTIONS
        },
    }


def rolls_beside(fine: int, stop: float, grid: float, flicker: NoiseModel | None) -> Beside:
    """Measure the intervals of a neuron with I_dc of a code, and of the model where it has the same rate."""
    current = default_biases().with_code("IF_DC_P", COARSE, fine).current("IF_DC_P")
    circuit = rebias(rolls_neuron.build(), {"i_dc": current})
    given = rolls_neuron.BLOCK.defaults | {"current": 0.0, "duration": stop}
    machine = to_kernel(
        rolls_neuron.testbench(circuit, given, ROLLS_180_IDEAL.v_dd), Silicon(ROLLS_180_IDEAL)
    )
    gaps = np.diff(simulate_noisy(machine, NoiseRun(SEED, grid, flicker), record=("v_mem",)).spikes["spike"])[
        1:
    ]
    noise = SiliconNoise(SEED, flicker=flicker)
    points = sorted(rolls_intervals(fine + k, noise) for k in (-1, 0, 1))
    at = np.log(np.array(points))
    model = float(np.exp(np.interp(np.log(gaps.mean()), at[:, 0], at[:, 1])))
    kind = "flicker" if flicker is None else "white"
    return Beside(f"rolls_{1.0 / gaps.mean():.0f}_Hz_{kind}", *known(gaps), model)


def rolls_intervals(fine: int, noise: SiliconNoise, duration: float = CHIP_TIME) -> tuple[float, float]:
    """Give the mean and the deviation (s) of the intervals of all neurons of a nominal chip."""
    biases = default_biases().with_code("IF_DC_P", COARSE, fine)
    program = Program(np.zeros((NEURONS, NEURONS), np.int8), biases)
    chip = RollsChip(program, Silicon(ROLLS_180_IDEAL), "gate", step=CHIP_STEP, noise=noise)
    _, state = chip.run(chip.at_rest(), 0.2)
    spikes, _ = chip.run(state, duration)
    gaps = np.concatenate([np.diff(spikes.times[spikes.neurons == k]) for k in range(NEURONS)])
    return float(gaps.mean()), float(gaps.std(ddof=1))


def nef_beside(thresholds: float, stop: float, grid: float) -> Beside:
    """Measure the intervals of a neuron on an ideal current, which makes no noise."""
    given = {"current": thresholds * nef_neuron.LEAK, "duration": stop}
    bench = nef_neuron.testbench(nef_neuron.build(), given, ROLLS_180_IDEAL.v_dd)
    result = simulate_noisy(
        to_kernel(bench, Silicon(ROLLS_180_IDEAL)), NoiseRun(SEED, grid, WHITE_ONLY), record=("v_mem",)
    )
    gaps = np.diff(result.spikes["spike"])[1:]
    return Beside(
        f"nef_{thresholds:g}_thresholds", *known(gaps), float(nef_intervals(thresholds).std(ddof=1))
    )


def nef_intervals(thresholds: float, steps: int = NEF_STEPS) -> F64:
    """Give the intervals (s) of the neurons of a nominal chip on an ideal current."""
    chip = NefChip(
        bias_kind="gate", process=ROLLS_180_IDEAL, noise=SiliconNoise(SEED, flicker=WHITE_ONLY)
    ).at(27.0)
    built = build(Network((Ensemble("x", NEF_NEURONS),)), chip, 1)
    if built.chip is None or built.noise is None:
        return np.empty(0)
    on = built.chip._replace(net=built.chip.net._replace(bias=np.full(NEF_NEURONS, thresholds)))
    noise = built.noise._replace(bias=np.zeros(NEF_NEURONS))
    state, last = new_chip_state(on, FIFO), np.full(NEF_NEURONS, np.nan)
    found = []
    for k in range(steps):
        before = state.base.spikes.copy()
        advance_chip(on, state, 1, noise, None)
        fired = np.flatnonzero(state.base.spikes > before)
        # what is left of the refractory period says when it began
        at = (k + 1) * DT - (on.refractory[fired] - state.base.rest[fired])
        found.append((at - last[fired])[np.isfinite(last[fired])])
        last[fired] = at
    return np.concatenate(found)


def tap_beside(trials: int) -> Beside:
    """Measure the delay of a tap, whose model is `sqrt(phi q T / I)`."""
    circuit = latency_tap.build(latency_tap.Params(taps=1))
    bench = latency_tap.testbench(circuit, {"duration": TAP_STOP}, AMI_1500_IDEAL.v_dd)
    machine = to_kernel(bench, Silicon(AMI_1500_IDEAL))
    noise = NoiseRun(SEED, TAP_STEP, WHITE_ONLY)
    delays = np.array([
        simulate_noisy(machine, noise, trial, record=("out[0]",)).spikes["out[0]"][0] - latency_tap.START
        for trial in range(trials)
    ])  # fmt: skip
    mean, white = delays.mean(keepdims=True), SiliconNoise(SEED, flicker=WHITE_ONLY)
    spread = charge_spread(
        Silicon(AMI_1500_IDEAL), white, charges_on(Silicon(AMI_1500_IDEAL))["tap"] / mean, mean
    )
    return Beside("tap", *known(delays), float(mean[0] * spread[0]))


def rows(found: Sequence[Beside], flicker: Beside) -> list[Statement]:
    """Make a statement a measurement; flicker has no rule."""
    rule = within(ALLOWED, "of the transistors' deviation, within {percent:g} %")
    held = [Statement(f"jitter_{b.name}", 1.0, b.ratio, rule) for b in found]
    beside = unjudged("shown beside; its coefficient is ours")
    return [*held, Statement(f"jitter_{flicker.name}", 1.0, flicker.ratio, beside)]


def sonar_rows(found: Sequence[Beside]) -> list[Statement]:
    """Make a statement a measurement, held to what its trials know."""
    made = []
    for b in found:
        rule = within(LEFT_OUT + 3.0 * b.known, "of the transistors' deviation, within {percent:.0f} %")
        made.append(Statement(f"jitter_{b.name}", 1.0, b.ratio, rule))
    return made


def note(found: Sequence[Beside]) -> str:
    """Tell the deviations in words."""
    each = (
        f"{b.name} {1e6 * b.transistors:.3g} us of {1e3 * b.mean:.4g} ms"
        f" (+- {100 * b.known:.1f} %), model {1e6 * b.model:.3g} us"
        for b in found
    )
    return f"{'; '.join(each)}. The paper column is the transistors'."


def draw(found: Sequence[Beside], figure: Figure) -> None:
    """Fill `figure` with deviations over means, the transistors' with what is known of them."""
    ax = sized_axes(figure, max(7.0, 0.55 * len(found)), 4.2)
    at = np.arange(len(found))
    theirs = np.array([b.transistors / b.mean for b in found])
    spread = theirs * np.array([b.known for b in found])
    ax.errorbar(
        at, 100 * theirs, 100 * spread, color=COLOURS[0], marker="o", linestyle="", label="transistors"
    )
    model = [100 * b.model / b.mean for b in found]
    ax.plot(at, model, color=COLOURS[1], marker="x", linestyle="", label="chip's model")
    ax.set_yscale("log")
    ax.set_xticks(at, [b.name.replace("_", " ") for b in found], rotation=30, ha="right", fontsize=7)
    ax.set_ylabel("jitter (% of the time)")
    ax.legend(loc="best")


EXPERIMENT = Experiment(
    "chip-noise", "jitter of ROLLS, NEF, latency and sonar chips beside that of their transistors",
    reproduce, {"trials": TRIALS},
)  # fmt: skip
