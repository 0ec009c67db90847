"""Measurements of `chip-noise` of the sonar's chips and boards: jitter beside that of their transistors.

The models are compared with transients of nominal devices at 27 degC, with the white noise of all of them.
Measured are spikes of an LSO neuron with one excitation, and with two and an inhibition; the end of a
synapse's step; a level unit on a ramp; the hearing's neurons behind the envelope detector, with sounds whose
peak is above their threshold; the vocalization controller's comparator on a ramp of its own slope, with the
rest of the board left out, and intervals of the whole board. Noise stands still for a fraction of the
shortest time that matters: a microsecond, a 25th of the period of the carrier, makes the onset neuron scatter
by a sixth more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from chips.boards.vocalization.model import VocalizationModel
from chips.boards.vocalization.noise import AHEAD, comparator_jitter, interval_spread
from chips.hearing.model import HearingState, hear, hearing_on
from chips.hearing.noise import chain_machine
from chips.lso.measure import LEVELS, crossing, ramp_bench
from chips.lso.model import SIDES, head_on, level_delays
from chips.lso.noise import head_of_ping, level_spread, noise_of, noisy_side_spikes
from chips.lso.rest import THRESHOLD
from chips.noise import SiliconNoise
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.lso import lso_neuron
from circuits.blocks.sonar import high_threshold_neuron, vocalization_controller
from circuits.circuit import Circuit, Port
from circuits.devices import Source
from circuits.devices.noise import WHITE_ONLY
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.event import falling_crossing, rising_crossing
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import NoiseRun, map_trials, simulate_noisy
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from system.papers.checks.jitter_beside import Beside, known

SEED = 1000
DRAWS = 4000  # of a model
SILICON = Silicon(AMI_1500_IDEAL)
WHITE = SiliconNoise(SEED, flicker=WHITE_ONLY)
# events (s) of the LSO neuron's runs
LSO = {
    "lso_excited": {"excite_1": 0.5e-3},
    "lso_inhibited": {"excite_1": 0.5e-3, "excite_2": 0.54e-3, "inhibit_1": 0.6e-3},
}
SLOPES = (600.0, 3e3)  # V/s, of a level unit's ramps: edges of faint and of usual echoes
PEAKS = (("high_threshold", 1.4), ("onset", 1.2), ("onset", 2.0))  # peak over threshold
SOUND = 0.3e-3  # s, when a sound begins
LISTEN = 0.3e-3  # s, within which it is heard
RAMP = 43.0  # V/s, of the vocalization controller at 18 Hz
PROXIMITY, INTERVAL_GRID = 3.0, 0.25e-6  # V and s, of the board's intervals
COMPARATOR = (
    "comparator", "c_comparator", "r_top", "r_bottom", "r_fb", "i_call_p", "i_call_n", "c_stray_threshold",
    "c_stray_call",
)  # fmt: skip


def lso_beside(name: str, trials: int) -> Beside:
    """Measure the first spike of an LSO neuron."""
    events = LSO[name]
    times = _trials(_lso_bench(events, 2.6e-3), 2e-6, trials, "spike")
    head = head_on(SILICON, "gate")
    noise = noise_of(head, SILICON, WHITE, kind="gate")
    level = np.full((SIDES, LEVELS), np.inf)
    level[0, :2] = events.get("excite_1", np.inf), events.get("excite_2", np.inf)
    level[1, 0] = events.get("inhibit_1", np.inf)
    ours = np.array([noisy_side_spikes(head, noise, k, 0, level)[0] for k in range(DRAWS)])
    return Beside(name, *known(times), float(ours.std(ddof=1)))


def step_beside(trials: int) -> Beside:
    """Measure how long a synapse's step lasts."""
    machine = to_kernel(_lso_bench(LSO["lso_excited"], 5.2e-3), SILICON)
    run = NoiseRun(SEED, 2e-6, WHITE_ONLY)
    times = np.array(map_trials(_step, machine, run, range(trials), 1, record=("excite0.off",)))
    head = head_on(SILICON, "gate")
    noise = noise_of(head, SILICON, WHITE, kind="gate")
    ours = np.array([head_of_ping(head, noise, k).excite_step[0, 0] for k in range(DRAWS)])
    return Beside("lso_step", *known(times), float(ours.std(ddof=1)))


def level_beside(slope: float, trials: int) -> Beside:
    """Measure the spike of a level unit on a ramp (V/s)."""
    level = rebias(high_threshold_neuron.build(), {"v_threshold": THRESHOLD})
    bench = replace(ramp_bench(level, slope, AMI_1500_IDEAL.v_dd), stop=crossing(slope) + 0.1e-3)
    times = _trials(bench, 0.1e-6, trials, "spike") - crossing(slope)
    head = head_on(SILICON, "gate")
    noise = noise_of(head, SILICON, WHITE, kind="gate")
    current = head.level_current[0, :1]
    delay = level_delays(head, np.full(head.offset.shape, slope))[0, :1]
    ours = level_spread(noise.level, delay, np.array([slope]), current)
    return Beside(f"level_unit_{slope:.0f}_V_s", *known(times), float(ours[0]))


def hearing_beside(name: str, ratio: float, trials: int) -> Beside:
    """Spike of a neuron of the hearing after a sound so many times as loud as its threshold."""
    model = hearing_on(SILICON, noise=WHITE)
    peak = ratio * getattr(model, name).threshold
    machine = chain_machine(name, peak, SILICON, SOUND, SOUND + LISTEN)
    times = _machine_trials(machine, 0.2e-6, trials, "spike")
    ours = [hear(model, HearingState(heard=k), [(0.0, peak)]).due for k in range(DRAWS)]
    mine = np.array([time for due in ours for time, who in due if who == name])
    return Beside(f"{name}_{ratio:g}_thresholds", *known(times - SOUND), float(mine.std(ddof=1)))


def call_beside(trials: int) -> Beside:
    """Measure when a ramp makes the vocalization controller call."""
    board = vocalization_controller.build()
    devices = tuple(d for d in board.devices if d.name in COMPARATOR)
    ports = Port("vdd", "supply"), Port("ramp", "analog"), Port("call", "event", "out")
    v_dd = AMI_1500_IDEAL.v_dd
    high = vocalization_controller.thresholds(vocalization_controller.Params(), v_dd)[1]
    lasts = AHEAD / RAMP
    # from ground, where the comparator has one state only
    wave = PiecewiseLinear((0.0, 1e-6, 2e-6, 2e-6 + lasts), (0.0, 0.0, high - AHEAD, high))
    sources = Source("vdd", "vdd", Constant(v_dd)), Source("ramp", "ramp", wave)
    bench = Testbench(
        "comparator", Circuit("comparator_board", ports, devices), sources, 2e-6 + lasts, watch=("call",)
    )
    times = _trials(bench, 50e-9, trials, "call")
    return Beside("vocalization_comparator", *known(times), comparator_jitter(RAMP, SILICON))


def interval_beside(intervals: int) -> Beside:
    """Measure intervals of the whole board of the vocalization controller, one run of many."""
    numbers = VocalizationModel(SILICON).numbers
    rate = numbers.base + numbers.slope * PROXIMITY
    stop = (intervals + 1.5) / rate
    given = {"proximity": PROXIMITY, "amplitude_control": None, "duration": stop}
    bench = vocalization_controller.testbench(vocalization_controller.build(), given, AMI_1500_IDEAL.v_dd)
    run = NoiseRun(SEED, INTERVAL_GRID, WHITE_ONLY)
    calls = simulate_noisy(to_kernel(bench, SILICON), run, record=("call",)).spikes["call"]
    spread = interval_spread(numbers, SILICON, WHITE, np.array([rate]))
    return Beside("vocalization_interval", *known(np.diff(calls)[:intervals]), float(spread[0]) / rate)


def _step(result: Result) -> float:
    """From the first synapse's switch closing to its opening, s."""
    off, half = result["excite0.off"], 0.5 * AMI_1500_IDEAL.v_dd
    closes, opens = falling_crossing(result.time, off, half), rising_crossing(result.time, off, half)
    return opens - closes if opens is not None and closes is not None else np.nan


def _lso_bench(events: Mapping[str, float], duration: float) -> Testbench:
    quiet: dict[str, float | None] = {s.name: None for s in lso_neuron.BLOCK.stimuli}
    given = quiet | dict(events) | {"duration": duration}
    return lso_neuron.testbench(lso_neuron.build(), given, AMI_1500_IDEAL.v_dd)


def _trials(bench: Testbench, grid: float, trials: int, port: str) -> F64:
    """First event of a port in each trial, s, with noise that stands still for `grid` s."""
    return _machine_trials(to_kernel(bench, SILICON), grid, trials, port)


def _machine_trials(machine: Machine, grid: float, trials: int, port: str) -> F64:
    run = NoiseRun(SEED, grid, WHITE_ONLY)
    found = map_trials(lambda r: float(r.spikes[port][0]), machine, run, range(trials), 1, record=())
    return np.array(found)
