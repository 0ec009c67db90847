"""Figure 6 of Cheely & Horiuchi 2003: tuning curves of the 13 neurons, 100 pulse-echo pairs a delay.

Every neuron of two chips of transistors gets 100 pairs of a call and an echo at each delay, and counted is
how many it answers. In one chip I_inh_tau is linear in the index, as the paper's chip has it, in the other it
falls as 1/delay ("reciprocal", ours). With the paper's words are compared the peaks of the curves, which are
100 %, and their widths, which grow with the best delay. The currents of the neurons are those at the
operating point of the chip's bias chain. The neurons are stepped separately: what a call does to the chain's
gate voltages, which ends inhibition up to 0.4 ms earlier in the fully coupled chip, is left out.

A noiseless neuron answers an echo at a given delay always in the same way, so that percentages between 0 and
100 need jitter, of which the paper says nothing: here every echo time is off by a Gaussian 0.1 ms (ours),
drawn by Philox with the key (seed, neuron). Because the answer is a function of the delay, the edges of the
facilitating interval, bisected to 10 us from the solver's runs (`circuits.blocks.sonar.tuning`), turn the
jittered delays of 100 pairs into a percentage without 100 runs. This is checked by direct runs from rest:
every neuron at delays in steps of 1 ms over the whole range, and all 100 pairs at the delays next to both
edges of the first, the middle and the last neuron. Only a pair within the resolution of an edge may differ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import spearmanr

from chips.ranging import circuit as ranging_chip
from circuits.arrays import F64, Bools
from circuits.bias import rebias
from circuits.blocks.bias import chain as bias_chain
from circuits.blocks.sonar import rebound_neuron
from circuits.blocks.sonar.tuning import RESOLUTION, NeuronClass, Tuning, tune, tuning_machine
from circuits.circuit import Circuit
from circuits.devices.source import polyline
from circuits.event import pulse
from circuits.lowering.kernel import Machine
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner
from system.experiment import Experiment, Progress, Report, part, with_progress
from system.plot import COLOURS
from system.rule import above, all_of, none, within, within_share
from system.statement import Statement

PAIRS = 100
STEP, LONGEST = 0.25e-3, 30e-3  # s
JITTER = 0.1e-3  # s, standard deviation of an echo's time; ours
SEED = 2003  # of the jitter; ours
CHECK_STEP = 1e-3  # s, between direct runs over the whole range
CHECKED = (0, 6, 12)  # neurons of which all pairs next to the edges are run
AFTER = 8e-3  # s, how long a direct run goes on after the later of echo and release
FIRST, LAST, LINE = 2e-3, 28e-3, 0.05  # s, s, and share of the span; what the reciprocal chain aims at


@dataclass(frozen=True, slots=True)
class Curves:
    """One chip. `delay`: float64[D], s; `share` of pairs that gave a spike: float64[neurons, D].

    `checked`: direct runs; `wrong`: those that differ from the interval though not at an edge.
    """

    delay: F64
    share: F64
    tunings: tuple[Tuning, ...]
    checked: int
    wrong: int

    @property
    def best_delay(self) -> F64:
        """Best delay of every neuron, float64[neurons], s."""
        return np.array([t.best_delay for t in self.tunings])

    @property
    def width(self) -> F64:
        """Width of every facilitating interval, float64[neurons], s."""
        return np.array([t.width for t in self.tunings])

    @property
    def off_line(self) -> float:
        """Largest distance of a best delay from the line through first and last, share of the span."""
        best = self.best_delay
        line = np.linspace(best[0], best[-1], best.size)
        return float(np.abs(best - line).max() / abs(best[-1] - best[0]))


def run(progress: Progress) -> Report:
    """Measure both chips at delays in steps of 0.25 ms."""
    return run_on_grid(progress, STEP, CHECK_STEP)


def run_on_grid(progress: Progress, step: float, check_step: float) -> Report:
    """Measure both chips at delays in steps of `step` s, and check by direct runs every `check_step` s."""
    delay = np.linspace(0.0, LONGEST, round(LONGEST / step) + 1)
    curves = {
        "linear": _curves(bias_chain.LINEAR, delay, check_step, part(progress, 0.0, 0.5)),
        "reciprocal": _curves(bias_chain.RECIPROCAL, delay, check_step, part(progress, 0.5, 1.0)),
    }
    return Report(_rows(curves), lambda figure: _draw(curves, figure), _notes(curves))


def neurons(params: bias_chain.Params) -> tuple[Circuit, ...]:
    """Build the 13 neurons with the currents of the chain's operating point."""
    silicon = Silicon(AMI_1500_IDEAL)
    bench = bias_chain.testbench(bias_chain.build(params), {"duration": None}, silicon.process.v_dd)
    found = bias_chain.currents(operating_point(bench, silicon))
    return tuple(
        rebias(rebound_neuron.build(), {"i_inh_tau": float(inh), "i_ex_tau": float(ex)})
        for inh, ex in zip(*found, strict=True)
    )


def jittered(delay: F64, neuron: int) -> F64:
    """Draw the delays of the pairs that neuron `neuron` gets, float64[D, pairs], in s."""
    generator = np.random.Generator(np.random.Philox(key=np.array([SEED, neuron], dtype=np.uint64)))
    return np.asarray(delay[:, None] + JITTER * generator.standard_normal((delay.size, PAIRS)))


def _curves(params: bias_chain.Params, delay: F64, check_step: float, progress: Progress) -> Curves:
    share, tunings, checked, wrong = [], [], 0, 0
    sparse = np.linspace(0.0, LONGEST, round(LONGEST / check_step) + 1)
    for k, neuron in with_progress(list(enumerate(neurons(params))), progress):
        machine = tuning_machine(neuron, Silicon(AMI_1500_IDEAL))
        tuning = tune(machine)
        pairs = jittered(delay, k)
        share.append(_facilitates(tuning, pairs).mean(axis=1))
        tunings.append(tuning)
        check = np.concatenate([sparse, _next_to_edges(tuning, delay, pairs) if k in CHECKED else sparse[:0]])
        differs = _fires(machine, tuning, check) != _facilitates(tuning, check)
        checked += check.size
        wrong += int((differs & ~_at_an_edge(tuning, check)).sum())
    return Curves(delay, np.array(share), tuple(tunings), checked, wrong)


def _facilitates(tuning: Tuning, delay: F64) -> Bools:
    """Whether an echo at each delay gives a spike, by the interval; none in a neuron that does not work."""
    return np.asarray((delay > tuning.first) & (delay < tuning.last))


def _at_an_edge(tuning: Tuning, delay: F64) -> Bools:
    """Whether each delay is as near to an edge as the edge is known."""
    return np.asarray(np.minimum(np.abs(delay - tuning.first), np.abs(delay - tuning.last)) <= RESOLUTION)


def _next_to_edges(tuning: Tuning, delay: F64, pairs: F64) -> F64:
    """Delays of all pairs at the grid's delays nearest to the edges, float64[2 pairs], s."""
    rows = [int(np.argmin(np.abs(delay - edge))) for edge in (tuning.first, tuning.last)]
    return np.asarray(pairs[rows].ravel())


def _fires(machine: Machine, tuning: Tuning, delays: F64) -> Bools:
    """Whether a call and an echo at each of `delays` give a spike, each pair run from rest."""
    runner, rest = Runner(machine), operating_point(machine)
    v_dd = machine.silicon.process.v_dd
    start = rebound_neuron.CALL_TIME
    call = polyline("call", pulse((start,), v_dd))
    found = []
    for delay in delays.tolist():
        echo = polyline("echo", pulse((start + delay,), v_dd))
        until = start + max(delay, tuning.t_inh) + AFTER
        _, segment = runner.advance(runner.begin(rest), until, {"call": call, "echo": echo})
        found.append(bool(segment.spikes))
    return np.array(found, dtype=np.bool_)


def _rows(curves: dict[str, Curves]) -> tuple[Statement, ...]:
    linear, reciprocal = curves["linear"], curves["reciprocal"]
    best = reciprocal.best_delay
    bunched = int((linear.best_delay < 0.25 * LONGEST).sum())
    return (
        *(row for name, found in curves.items() for row in _shape_rows(name, found)),
        _aim("reciprocal_first_best_delay_s", float(best[0]), FIRST),
        _aim("reciprocal_last_best_delay_s", float(best[-1]), LAST),
        Statement(
            "reciprocal_largest_distance_from_line",
            None,
            reciprocal.off_line,
            within(LINE, "best delays within {percent:g} % of their span of a line in the index", of=0.0),
            fitted=True,
        ),
        Statement(
            "linear_best_delays_in_first_quarter",
            None,
            float(bunched),
            above(
                0.5 * ranging_chip.NEURONS,
                "more than half of the neurons: delays bunch where currents are linear",
            ),
        ),
    )


def _shape_rows(name: str, found: Curves) -> tuple[Statement, ...]:
    """What the paper says of the curves, and the check of the method."""
    peak = float(found.share.max(axis=1).min())
    ratio = float(found.width[-1] / found.width[0])
    order = float(spearmanr(found.best_delay, found.width).statistic)
    return (
        Statement(f"{name}_lowest_peak", 1.0, peak, all_of(1.0, "every peak {percent:g} %")),
        Statement(f"{name}_width_last_over_first", "long-delay neurons wider", ratio, above(1.0)),
        Statement(
            f"{name}_width_rank_correlation",
            "long-delay neurons wider",
            order,
            above(0.9, "of width with best delay, above {limit:g}"),
        ),
        Statement(
            f"{name}_direct_runs_that_differ",
            None,
            float(found.wrong),
            none(f"none of {found.checked}, pairs within {1e6 * RESOLUTION:g} us of an edge apart"),
        ),
    )


def _aim(name: str, ours: float, aim: float) -> Statement:
    rule = within_share(0.1, "within {percent:g} % of {of_milli:g} ms (ours)", of=aim)
    return Statement(name, None, ours, rule, fitted=True)


def _notes(curves: dict[str, Curves]) -> tuple[str, ...]:
    notes = [
        f"Jitter of the echo's time is ours: {1e3 * JITTER:g} ms standard deviation, seed {SEED}.",
        "The shares come from the edges of the facilitating intervals; direct runs confirm them.",
        "Neurons are stepped separately, at the gate voltages of their chain at rest.",
        "Fitted: the currents of the reciprocal chain were chosen for best delays of 2 to 28 ms.",
    ]
    for name, found in curves.items():
        works = sum(t.outcome is NeuronClass.WORKS for t in found.tunings)
        best = ", ".join(f"{1e3 * d:.2f}" for d in found.best_delay)
        width = ", ".join(f"{1e3 * w:.2f}" for w in found.width)
        notes.append(
            f"{name} currents: {works} of {len(found.tunings)} neurons work; best delays (ms) {best};"
            f" widths (ms) {width}; farthest from a line {100 * found.off_line:.1f} % of the span."
        )
    return tuple(notes)


TITLES = {"linear": "(a) currents linear in the index", "reciprocal": "(b) currents as 1/delay"}


def _draw(curves: dict[str, Curves], figure: Figure) -> None:
    """Share of pairs that gave a spike against delay, one line a neuron, both chips."""
    figure.set_size_inches(8.0, 5.0)
    panels = figure.subplots(len(curves), 1, sharex=True, sharey=True)
    for ax, (name, found) in zip(panels, curves.items(), strict=True):
        _draw_curves(found, ax)
        ax.set_title(TITLES[name], fontsize=9, loc="left", pad=14)
        ax.set_ylabel("trials with a spike (%)")
    panels[-1].set_xlabel("pulse-echo delay (ms)")


def _draw_curves(found: Curves, ax: Axes) -> None:
    for k, share in enumerate(found.share):
        colour = COLOURS[k % len(COLOURS)]
        ax.plot(1e3 * found.delay, 100.0 * share, color=colour, linewidth=1.1)
        place = (1e3 * float(found.best_delay[k]), 101.0)
        ax.annotate(str(k), place, color=colour, fontsize=7, ha="center", annotation_clip=False)
    ax.set(ylim=(0.0, 100.0), xlim=(0.0, 1e3 * LONGEST))


EXPERIMENT = Experiment("cheely2003-fig6", "tuning curves of the 13 neurons from their bias chains", run)
