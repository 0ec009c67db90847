"""Noise of the devices: k T / C, small signals and noise beside ngspice, jitter of the rebound neuron.

Nothing is fitted, and the papers have none of it: the solver's noise is compared with theory and with
ngspice. Integrated noise of a resistor and of switches from weak to strong inversion is compared with
`k T / C`; transfer and noise of six blocks with ngspice's own linearisation of the exported block
(`netlists.ngspice.small_signal` says what of the noise is ngspice's); and the inhibition of neuron 12 of the
ranging chip, over 400 trials with white noise alone, with `sqrt(q t_inh / I)`. The behavioural neuron's
jitter is compared with the transistors'. Flicker is shown beside them, without a rule: its coefficient is
ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version

import numpy as np
from matplotlib.figure import Figure

from chips.noise import SiliconNoise
from chips.ranging import circuit as ranging_chip
from chips.ranging.chip import RangingChip
from chips.ranging.noise import spread
from circuits.arrays import F64
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Device, Resistor, Source, Transistor
from circuits.devices.noise import WHITE_ONLY, NoiseModel
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, to_kernel
from circuits.place import circuit_at
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, BOLTZMANN, ELEMENTARY_CHARGE, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver import small_signal
from circuits.solver.modes import natural_rates
from circuits.solver.noise import analysis as noise_analysis
from circuits.solver.noise.transient import NoiseRun, simulate_noisy
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.testbench import Testbench
from netlists.ngspice import small_signal as peer
from system.experiment import Experiment, Progress, Report, part, with_progress
from system.plot import COLOURS, PALE, sized_axes
from system.rule import unjudged, within
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

KTC, AC, NOISE, JITTER = 0.05, 0.01, 0.03, 0.10  # shares that are allowed
NEURON = 12  # the longest inhibition, 27.4 ms at 40.1 pA
STEP, STOP = 2e-6, 32e-3  # s, of the grid of noise, and the end of a run
TRIALS, SEED = 400, 1000  # 400 know a deviation to 3.5 %
LEAST_TRIALS = 4
WHITE, FINER, FLICKER = "white", "half step", "flicker"
NOISES = {  # of the inhibition's trials
    WHITE: NoiseRun(SEED, STEP, WHITE_ONLY),
    FINER: NoiseRun(SEED + 1, 0.5 * STEP, WHITE_ONLY),
    FLICKER: NoiseRun(SEED + 2, STEP),
}
TEMPERATURES = (-20.0, 27.0, 85.0)  # degC
DIES = (None, 1003)
GATES = (0.4, 0.7, 1.0, 5.0)  # V, of a switch: weak, moderate, strong inversion
# block, source that moves, output, lowest frequency (Hz); six decades
BESIDE_NGSPICE = (
    ("rebound-neuron", "v_rest", "v_mem", 1.0),
    ("envelope-detector", "microphone", "envelope", 1.0),
    ("onset-neuron", "envelope", "v_amp", 1.0),
    ("dpi-synapse", "v_etau", "v_exc_syn", 0.01),
    ("bias-chain", "v_inh_start", "v_inh_tau[12]", 0.01),
    ("first-target-isolation", "v_ex_max_set", "v_ex_max", 1.0),
)


@dataclass(frozen=True, slots=True)
class Trial:
    """Length of the inhibition, s; None where it does not end within the run."""

    t_inh: float | None


@dataclass(frozen=True, slots=True)
class Beside:
    """One block in both engines: largest differences of transfer and noise, as shares of ngspice's."""

    name: str
    temperature_c: float
    die: int | None
    transfer: float
    noise: float


def run(progress: Progress, execution: Execution = ALONE, trials: int = TRIALS) -> Report:
    """Measure the noise of devices beside theory, ngspice and the behavioural neuron.

    Raises `ParameterError` for fewer than four trials, of which half could not have a deviation.
    """
    if trials < LEAST_TRIALS:
        raise ParameterError(f"trials: {trials}, must be at least {LEAST_TRIALS}; give more")
    rows = [_integrated_row(), _transient_row()]
    beside = [
        measure_beside(*block, temperature_c, die)
        for block in with_progress(BESIDE_NGSPICE, part(progress, 0.0, 0.2))
        for temperature_c in TEMPERATURES
        for die in DIES
    ]
    counts = {WHITE: trials, FINER: trials, FLICKER: trials // 2}
    keys = [Numbered(name, k) for name, count in counts.items() for k in range(count)]
    numbers = (version("noctule"), NEURON, STOP, *NOISES.items())
    campaign = Campaign(EXPERIMENT.name, inhibition, Numbered, Trial, numbers)
    found = execution.by_condition(campaign, keys, part(progress, 0.2, 1.0))
    white, finer, flicker = (np.array([each.t_inh for each in found[name]], dtype=float) for name in counts)
    rows += [*beside_rows(beside), *jitter_rows(white, finer, flicker)]
    return Report(tuple(rows), lambda figure: draw(white, flicker, figure), (_note(beside, white),))


def thermal_ratio(circuit: Circuit, sources: Sequence[Source], temperature_c: float) -> float:
    """Give the integrated noise of node `y`, which has one path and one capacitance, over k T / C."""
    bench = Testbench(circuit.name, circuit, tuple(sources), 1.0)
    point = operating_point(bench, Silicon(AMI_1500_IDEAL, temperature_c=temperature_c))
    linear = small_signal.linearise(point)
    conductance, capacitance = linear.conductance.toarray()[:, :1], linear.charge.toarray()[:, :1]
    corner = float(-natural_rates(conductance, capacitance).real[0]) / (2.0 * np.pi)
    grid = small_signal.frequency_grid(1e-4 * corner, 1e4 * corner, 20)
    found = noise_analysis.noise(point, "y", grid, model=WHITE_ONLY)
    return found.variance * float(capacitance[0, 0]) / (BOLTZMANN * kelvin(temperature_c))


def resistor_circuit() -> Circuit:
    """Build a resistor of 10 MOhm and a capacitor of 1 pF at `y`."""
    return _at_y("resistor", (), Resistor("r", "y", "0", 1e7))


def switch_circuit() -> Circuit:
    """Build an nFET from `y` to ground, whose gate is a port, and a capacitor of 1 pF."""
    return _at_y("switch", (Port("g", "bias"),), Transistor("m", "n", "y", "g", "0", "0", 3e-6, 1.5e-6))


def measure_beside(
    name: str, source: str, node: str, low: float, temperature_c: float, die: int | None
) -> Beside:
    """Set a block's transfer and white noise beside ngspice's, over six decades."""
    block = load_block(name)
    silicon = Silicon(block.process, temperature_c, Die(number=die))
    stimuli = block.defaults
    bench = block.testbench(block.build(), stimuli, silicon.process.v_dd)
    point = operating_point(bench, silicon)
    return Beside(name, temperature_c, die, *_differences(point, source, node, low))


def neuron_machine(k: int) -> Machine:
    """Lower neuron `k` of the nominal ranging chip at its place, after a call alone."""
    neuron, place = circuit_at(ranging_chip.build(), (("neuron", (k,)),))
    silicon = Silicon(AMI_1500_IDEAL, place=place)
    stimuli = {"delay": 0.0, "call": 1.0, "echo": None, "duration": STOP}
    return to_kernel(rebound_neuron.testbench(neuron, stimuli, silicon.process.v_dd), silicon)


def inhibition(key: Numbered) -> Trial:
    """Measure t_inh of `NEURON` in the trial of a number, with the noise of a name."""
    result = simulate_noisy(_machine(), NOISES[key.condition], key.number)
    return Trial(rebound_neuron.measures(result)["t_inh_s"])


@lru_cache(maxsize=1)
def _machine() -> Machine:
    return neuron_machine(NEURON)


def shot_jitter(t_inh: float) -> float:
    """Give the jitter `sqrt(q t_inh / I)` of the neuron, s."""
    return float(np.sqrt(ELEMENTARY_CHARGE * t_inh / ranging_chip.I_INH_TAU[NEURON]))


def beside_rows(found: Sequence[Beside]) -> list[Statement]:
    """Make the statements about the worst transfer and noise of all blocks, temperatures and dies."""
    transfer, density = max(b.transfer for b in found), max(b.noise for b in found)
    return [
        _row("ac_beside_ngspice", 0.0, transfer, "share of ngspice's, worst", AC),
        _row("noise_beside_ngspice", 0.0, density, "share of ngspice's, worst", NOISE),
    ]


def jitter_rows(white: F64, finer: F64, flicker: F64) -> list[Statement]:
    """Make the statements about the jitter of t_inh on two grids, with flicker, and of the model."""
    rows = []
    for name, times in (("", white), ("_half_step", finer)):
        ratio = float(times.std(ddof=1)) / shot_jitter(float(times.mean()))
        rows.append(_row(f"t_inh_jitter{name}_over_theory", 1.0, ratio, "of sqrt(q t_inh / I)", JITTER))
    both = float(flicker.std(ddof=1))
    rule = unjudged("shown beside; its coefficient is ours")
    rows.append(Statement("t_inh_jitter_with_flicker_s", None, both, rule))
    for name, model, times in (("white", WHITE_ONLY, white), ("flicker", None, flicker)):
        ours = behavioural_jitter(model) / float(times.std(ddof=1))
        # half as many trials with flicker: 5 % at one deviation, as 3.5 % for the white ones
        rows.append(_row(f"behavioural_jitter_{name}", 1.0, ours, "of the transistors'", 0.15))
    return rows


def behavioural_jitter(model: NoiseModel | None) -> float:
    """Give the standard deviation of the behavioural neuron's t_inh, s."""
    noise = SiliconNoise(SEED, flicker=model)
    jitter = RangingChip(Silicon(AMI_1500_IDEAL), noise=noise, bias_kind="gate").jitter_at(27.0)
    return np.nan if jitter is None else float(spread(jitter)[NEURON])


def _at_y(name: str, ports: tuple[Port, ...], device: Device) -> Circuit:
    return Circuit(name, (*ports, Port("y", "analog", "out")), (device, Capacitor("c", "y", "0", 1e-12)))


def _integrated_row() -> Statement:
    ratios = []
    for temperature_c in TEMPERATURES:
        ratios.append(thermal_ratio(resistor_circuit(), (), temperature_c))
        gates = (Source("g", "g", Constant(v)) for v in GATES)
        ratios += [thermal_ratio(switch_circuit(), (gate,), temperature_c) for gate in gates]
    worst = max(ratios, key=lambda r: abs(r - 1.0))
    return _row("noise_integral_over_kTC", 1.0, worst, "of k T / C, worst", KTC)


def _transient_row() -> Statement:
    """Variance of a switch in moderate inversion over 20,000 time constants: known to 1 %."""
    circuit, gate = switch_circuit(), Source("g", "g", Constant(0.7))
    point = operating_point(Testbench("switch", circuit, (gate,), 1.0), Silicon(AMI_1500_IDEAL))
    linear = small_signal.linearise(point)
    capacitance = float(linear.charge[0, 0])
    tau = capacitance / float(linear.conductance[0, 0])
    machine = to_kernel(Testbench("switch", circuit, (gate,), 20_000 * tau), Silicon(AMI_1500_IDEAL))
    found = simulate_noisy(machine, NoiseRun(SEED, 0.05 * tau, WHITE_ONLY), record=("y",))
    variance = float(np.var(found["y"][found.time > 10.0 * tau]))
    ratio = variance * capacitance / (BOLTZMANN * kelvin(27.0))
    return _row("transient_variance_over_kTC", 1.0, ratio, "of k T / C", KTC)


def _differences(point: OperatingPoint, source: str, node: str, low: float) -> tuple[float, float]:
    grid = peer.Decades(low, 1e6 * low, 5)
    frequency, transfer = peer.ac(point, source, grid, (node,))
    ours = small_signal.ac(point, source, frequency, (node,)).transfer
    sources = noise_analysis.noise_sources(point, WHITE_ONLY)
    again, output, _ = peer.noise(point, node, source, grid, sources)
    density = noise_analysis.noise(point, node, again, model=WHITE_ONLY).output
    return float((np.abs(ours - transfer) / np.abs(transfer)).max()), float(
        np.abs(density / output - 1).max()
    )


def _row(name: str, theory: float, ours: float, what: str, tolerance: float) -> Statement:
    return Statement(name, theory, ours, within(tolerance, f"{what}, within {{percent:g}} %"))


def _note(beside: Sequence[Beside], white: F64) -> str:
    blocks = len({b.name for b in beside})
    return (
        f"ngspice: {blocks} blocks at {', '.join(f'{t:g}' for t in TEMPERATURES)} degC, nominal and die 1003."
        f" Neuron {NEURON}: t_inh {1e3 * white.mean():.4g} ms, jitter {1e6 * white.std(ddof=1):.3g} us of"
        f" {white.size} trials, sqrt(q t_inh / I) = {1e6 * shot_jitter(float(white.mean())):.3g} us."
        " The paper column is theory's, or 0 for a difference."
    )


def draw(white: F64, flicker: F64, figure: Figure) -> None:
    """Fill `figure` with t_inh of the trials about their mean, and the normal that theory expects."""
    ax = sized_axes(figure, 7.0, 4.0)
    edges = np.linspace(-70.0, 70.0, 57).tolist()
    looks: tuple[tuple[str, F64, str], ...] = (
        ("white and flicker", flicker, COLOURS[1]), ("white", white, COLOURS[0])
    )  # fmt: skip
    for name, times, colour in looks:
        label = f"{name}, {times.size} trials: {1e6 * times.std(ddof=1):.3g} µs"
        away = 1e6 * (times - times.mean())
        ax.hist(away, edges, density=True, histtype="step", color=colour, label=label)
    sigma = 1e6 * shot_jitter(float(white.mean()))
    x = np.linspace(-70.0, 70.0, 400)
    normal = np.exp(-0.5 * (x / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi))
    ax.plot(x, normal, color=PALE, linewidth=2.0, zorder=0, label=f"sqrt(q t_inh / I): {sigma:.3g} µs")
    ax.set(xlabel=f"t_inh of neuron {NEURON} away from its mean (µs)", ylabel="density (1/µs)")
    ax.legend(loc="best")


EXPERIMENT = Experiment(
    "device-noise", "k T / C, small signals and noise beside ngspice, jitter of the rebound neuron",
    run, {"trials": TRIALS},
)  # fmt: skip
