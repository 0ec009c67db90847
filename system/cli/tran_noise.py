"""The verb `noctule simulate --analysis tran-noise`: transients of a block while its devices make noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.measure.branch import Waveform, waveform
from circuits.solver.noise.transient import NoiseRun, grid_step, map_trials
from circuits.solver.transient import Result
from circuits.units import parse_quantity
from system.cli.beginning_output import told, told_lines
from system.cli.block_choice import choose_block
from system.cli.output import plain, print_json, print_line, print_table, working
from system.cli.simulate_verb import Simulate
from system.files.writing import write_netcdf_atomic, write_text_atomic
from system.options.block import Choice, describe_silicon, silicon_line
from system.plot import COLOURS, DASHES, check_picture, entitle, save_picture, silicon_text

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure
else:
    xr = later("xarray")


DRAWN = 20  # trials whose waveforms a picture shows
MOST_TRIALS = 1_000_000


@dataclass(frozen=True, slots=True)
class Trial:
    """Result of one transient with noise.

    outcome : word for the outcome of the block.
    spikes : float64[n], times of the spikes at each port, s.
    measures : values of the block's measures, in SI units; None where one is not defined.
    steps : number of accepted time steps.
    waves : time, s, and voltage, V, float64[t] each, of the nodes that a picture shows.
    told : what the run reports by itself, for JSON.
    lines : the same as lines of text.
    """

    outcome: str
    spikes: dict[str, F64]
    measures: dict[str, float | None]
    steps: int
    waves: dict[str, tuple[F64, Waveform]]
    told: dict[str, Any]
    lines: list[str]


def tran_noise_command(asked: Simulate) -> None:
    """Run `--trials` transients with noise, and print what varies from one to the next."""
    choice = choose_block(asked.block, asked.values, asked.silicon, asked.stimulus, asked.begin)
    count = 1 if asked.trials is None else asked.trials
    if not 1 <= count <= MOST_TRIALS:
        raise ParameterError(f"--trials: {count}, must be 1 to {MOST_TRIALS}; 200 know a jitter to 5 %")
    check_picture(asked.plot)
    machine, run = to_kernel(choice.testbench(), choice.silicon), _read_run(asked)
    shown = choice.block.plotted or machine.testbench.watch or machine.names[1:5]

    def keep(result: Result) -> Trial:
        measures = choice.block.measured(result)
        waves: dict[str, tuple[F64, Waveform]] = {}
        if asked.plot is not None:
            waves = {n: (result.time.copy(), waveform(result, n)) for n in shown}
        return Trial(
            choice.block.outcome(result), dict(result.spikes), measures, result.steps.accepted, waves,
            told(result), told_lines(result),
        )  # fmt: skip

    with working(f"{count} trials of {asked.block}"):
        trials = map_trials(keep, machine, run, range(count), asked.workers)
    table = summary(trials)
    if asked.csv is not None:
        write_text_atomic(asked.csv, _trial_csv(trials))
    if asked.netcdf is not None:
        write_netcdf_atomic(
            asked.netcdf, _trial_dataset(trials).assign_attrs(block=choice.block.name, seed=run.seed)
        )
    silicon = choice.silicon
    on = silicon_text(silicon.die, silicon.temperature_c, law=silicon.process.effects)
    said = f"{choice.block.name}, {on}"
    save_picture(asked.plot, lambda figure: _draw_trials(trials, shown, figure, said))
    grid = grid_step(machine, run)
    if asked.as_json:
        print_json(_document(choice, trials, table, run, grid))
    else:
        _print(choice, trials, table, run, grid)


def _read_run(asked: Simulate) -> NoiseRun:
    """Seed, grid step and flicker that the options ask for."""
    return NoiseRun(
        0 if asked.seed is None else asked.seed,
        None if asked.step is None else parse_quantity(asked.step, "s", "--step"),
        WHITE_ONLY if asked.flicker is False else None,
    )


def _columns_of(trials: Sequence[Trial]) -> dict[str, list[float | None]]:
    """Every measure, and the time of every spike where all trials have equally many at a port."""
    columns = {n: [t.measures[n] for t in trials] for n in trials[0].measures}
    for port in trials[0].spikes:
        counts = {t.spikes[port].size for t in trials}
        for k in range(counts.pop() if len(counts) == 1 else 0):
            columns[f"{port}_{k}_s"] = [float(t.spikes[port][k]) for t in trials]
    return columns


def summary(trials: Sequence[Trial]) -> dict[str, dict[str, float]]:
    """Give the number of trials, the mean and the standard deviation of every measure and spike time.

    The standard deviation over a single trial is NaN.
    """
    found = {}
    for name, values in _columns_of(trials).items():
        kept = np.array([v for v in values if v is not None], dtype=np.float64)
        spread = float(kept.std(ddof=1)) if kept.size > 1 else np.nan
        mean = float(kept.mean()) if kept.size else np.nan
        found[name] = {"count": float(kept.size), "mean": mean, "standard_deviation": spread}
    return found


def _trial_csv(trials: Sequence[Trial]) -> str:
    """A row a trial: outcome, spikes in all, measures; an empty cell where one is not defined."""
    names = list(trials[0].measures)
    lines = [",".join(["trial", "outcome", "spikes", *names])]
    for k, t in enumerate(trials):
        numbers = ["" if t.measures[n] is None else f"{t.measures[n]:.12g}" for n in names]
        lines.append(",".join([str(k), t.outcome, str(_spike_count(t)), *numbers]))
    return "\n".join(lines) + "\n"


def _trial_dataset(trials: Sequence[Trial]) -> xr.Dataset:
    """Measures and spike times over `trial`; NaN where there is none."""
    data = xr.Dataset(coords={"trial": np.arange(len(trials))})
    data["outcome"] = ("trial", np.array([t.outcome for t in trials], dtype=object))
    for name in trials[0].measures:
        values = [t.measures[name] for t in trials]
        data[name] = ("trial", np.array([np.nan if v is None else v for v in values], dtype=np.float64))
    for k, port in enumerate(trials[0].spikes):
        most = max(t.spikes[port].size for t in trials)
        padded = np.full((len(trials), most), np.nan)
        for row, t in zip(padded, trials, strict=True):
            row[: t.spikes[port].size] = t.spikes[port]
        data[f"spikes_{port}"] = (("trial", f"spike_{k}"), padded)
        data[f"spikes_{port}"].attrs["units"] = "s"
    return data


def _draw_trials(trials: Sequence[Trial], nodes: Sequence[str], figure: Figure, said: str) -> None:
    """Fill `figure` with a panel a node, the first trials over one another, and how times are spread."""
    spread = deviations(trials)
    figure.set_size_inches(7.0, 1.05 * len(nodes) + 0.8 + (2.2 if spread else 0.0))
    ratios = [1.0] * len(nodes) + ([2.0] if spread else [])
    stack = figure.subplots(len(ratios), 1, squeeze=False, height_ratios=ratios)[:, 0]
    drawn = trials[:DRAWN]
    for k, (node, ax) in enumerate(zip(nodes, stack, strict=False)):
        for t in drawn:
            time, told = t.waves[node]
            ax.plot(1e3 * time, told.values, color=COLOURS[k % 5], linewidth=0.6, alpha=0.6)
            ax.set_ylabel(f"{told.name} ({told.unit})")
        ax.sharex(stack[0])
        ax.tick_params(axis="x", labelbottom=k == len(nodes) - 1)
    entitle(f"{said}: {len(drawn)} of {len(trials)} trials with noise", stack[0])
    stack[len(nodes) - 1].set_xlabel("time (ms)")
    for k, (name, values) in enumerate(spread.items()):
        label = f"{name}: {1e6 * values.std(ddof=1):.3g} µs"
        dashes = DASHES[k % len(DASHES)]
        stack[-1].hist(
            1e6 * values, bins="auto", histtype="step", color=COLOURS[k % 5], linestyle=dashes, label=label
        )
    if spread:
        stack[-1].set_xlabel("away from the mean (µs)")
        stack[-1].set_ylabel("trials")
        stack[-1].legend(loc="best", fontsize=8)
    figure.align_ylabels(stack)


def deviations(trials: Sequence[Trial]) -> dict[str, F64]:
    """Give the deviation of every time from its mean over the trials, s, float64[trials] by name.

    The times are measures in seconds and spikes, where all trials have them.
    """
    found = {}
    for name, values in _columns_of(trials).items():
        times = np.array([v for v in values if v is not None], dtype=np.float64)
        if name.endswith("_s") and times.size == len(trials) > 1:
            found[name] = times - times.mean()
    return found


def _document(
    choice: Choice, trials: Sequence[Trial], table: dict[str, dict[str, float]], run: NoiseRun, grid: float
) -> dict[str, Any]:
    return {
        "block": choice.block.name, "analysis": "tran-noise", **describe_silicon(choice.silicon),
        "stimuli": choice.stimuli, "seed": run.seed, "step_s": grid, "band_Hz": 0.5 / grid,
        "flicker": run.flicker is not WHITE_ONLY, "summary": plain(table),
        "trials": [
            {
                "trial": k, "outcome": t.outcome, "measures": plain(t.measures), "steps": t.steps,
                "spikes_s": {port: times.tolist() for port, times in t.spikes.items()}, **t.told,
            }
            for k, t in enumerate(trials)
        ],
    }  # fmt: skip


def _print(
    choice: Choice, trials: Sequence[Trial], table: dict[str, dict[str, float]], run: NoiseRun, grid: float
) -> None:
    silicon = choice.silicon
    white = ", white only" if run.flicker is WHITE_ONLY else ""
    title = f"{choice.block.name} at {silicon_line(silicon)}, {len(trials)} trials"
    rows = [
        (name, f"{s['count']:.0f}", f"{s['mean']:.9g}", f"{s['standard_deviation']:.5g}")
        for name, s in table.items()
    ]
    print_table(f"{title}{white}", ("quantity", "trials:", "mean:", "standard deviation:"), rows)
    outcomes = {o: sum(t.outcome == o for t in trials) for o in sorted({t.outcome for t in trials})}
    print_line(f"outcomes: {', '.join(f'{o} {n}' for o, n in outcomes.items())}")
    for line in dict.fromkeys(line for t in trials for line in t.lines):
        print_line(line)
    print_line(f"seed {run.seed}, noise to {0.5 / grid:.4g} Hz (a step of {grid:.4g} s)")


def _spike_count(trial: Trial) -> int:
    return sum(times.size for times in trial.spikes.values())
