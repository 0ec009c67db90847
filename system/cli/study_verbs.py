"""The verbs on studies: `montecarlo`, `replay`, `centre` and `blame`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from system.cli import shared_options as shared
from system.cli.shared_options import BlockValues, Device, Engine, Level, ManyDies, OnBlock
from system.cli.verb import argument, like, required
from system.cli.verbs import OnDie
from system.option import option
from system.options.begin import BeginChoice
from system.options.silicon import SiliconChoice

Corner = Literal["random", "typical", "ss", "ff", "sf", "fs"]
METRICS = "circuits.registry:metric_names"


@dataclass(frozen=True, slots=True, kw_only=True)
class Montecarlo(ManyDies):
    """Measure a block, chip or system on many dies. There are statistics, and what share works."""

    OWN: ClassVar[str] = "lot"
    target: str = argument(
        "TARGET", "A block, chip or system, or a file of yours", names="system.registry:target_names"
    )
    metric: tuple[str, ...] = option(
        (), "Measured, or MODULE:FUNCTION, repeatable; the target's own unless options name some",
        metavar="NAME", names=METRICS,
    )  # fmt: skip
    measure: tuple[str, ...] = shared.measure_option()
    samples: int = option(200, "Number of dies", short="n")
    first_die: int = option(1000, "Number of the first die")
    lot: str = like(SiliconChoice, "lot")
    corner: tuple[Corner, ...] = option(("random",), "Process corner; n first, then p; repeatable")
    variation: SiliconChoice = shared.silicon_part("temperature", "lot", "die", "study", "corner")
    temperature: tuple[str, ...] = option(
        (), "Degrees Celsius, repeatable, or a course; 27, or a netlist's own, unless given", metavar="DEGC"
    )
    trials: int = option(1, "Runs of a system on each die, with seeds of their own")
    plan: Literal["random", "lhs", "sobol"] = option("random", "How the dies are drawn")
    seed: int = option(0, "Of the plan and of bootstraps; a die has its own key")
    spec: tuple[str, ...] = option((), 'As "best_delay in 6.8ms:7.7ms", repeatable', metavar="TEXT")
    until: str | None = option(None, "Stop when the yield is known to +- this, as 2%", metavar="SHARE")
    require: str | None = option(None, "Stop when the yield is surely above or below", metavar="SHARE")
    values: BlockValues = shared.values_part("bias_file", "coupling")
    stimulus: tuple[str, ...] = shared.stimulus_option()
    begin: BeginChoice = shared.begin_part()
    engine: Engine = option("native", "What solves a block's testbench")
    device: Device = option(
        "cpu", "Where a block's runs go; gpu: a graphics processor, in chunks of thousands"
    )
    level: Level = option("behavioural", "Of a system")
    duration: str | None = option(None, "Of a system's run; the system's own", metavar="TIME")
    threads: int | None = shared.threads_option()
    workers: int | None = shared.workers_option()
    scheduler: str | None = shared.scheduler_option()
    chunk: int = option(32, "Dies that are measured and kept together")
    order: Literal["number", "worst"] = option(
        "number", "Of chunks; worst: those first that the gradient tells to be nearest to failing"
    )
    output: str | None = option(None, "Keep samples and manifest there", short="o", metavar="FOLDER")
    resume: bool = option(default=False, about="Go on with the study in --output")
    csv: str | None = shared.file_option("Write a row a sample")
    plot: str | None = shared.plot_option()
    contributions: str | None = option(
        None, "What its variance comes from, by device and so on", metavar="METRIC", names=METRICS
    )
    gradients: Literal["adjoint", "dies"] = option(
        "adjoint", "Of contributions: one run backwards where the metric has one, or two dies a draw"
    )
    pareto: str | None = shared.file_option("Draw contributions into a .png, .svg or .pdf file")
    rare: Literal["scaled-sigma", "mean-shift"] | None = option(
        None, "Estimate how seldom a die fails --spec, by this method"
    )
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """Measure one sample of a study again, and run its testbench."""

    study: str = argument("STUDY", "Folder of a study")
    die: int = required("Die of the study")
    corner: Corner | None = option(None, "The first of the study's unless given")
    temperature: str | None = option(None, "The first of the study's unless given", metavar="DEGC")
    trial: int | None = option(None, "The first unless given")
    metric: tuple[str, ...] = option(
        (), "MODULE:FUNCTION of the study's, which is code; repeatable", metavar="NAME"
    )
    code: str | None = option(
        None, "Code that the study is of, as my_circuit.py:follower", metavar="FILE.py:NAME"
    )
    changed: bool = option(default=False, about="Run that code though its file has changed since")
    engine: Engine = option("native", "What solves the testbench")
    deadline: str | None = shared.deadline_option()
    plot: str | None = shared.plot_option()
    csv: str | None = shared.file_option("Write all waveforms")
    raw: str | None = shared.file_option("Write all waveforms as ngspice's rawfile")
    spikes: str | None = shared.spikes_option()
    view: str | None = option(None, "Page that plays the run, for a browser", metavar="FILE.html")
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Gradient(OnBlock):
    """Show what each device moves a metric by: one run backwards."""

    metric: tuple[str, ...] = option(
        (), "Of the testbench, or as spike_time(spike,1), voltage(v_mem,5ms), db(v_sf,v_pd,1kHz); the first"
        " spikes unless given",
        metavar="NAME",
    )  # fmt: skip
    values: BlockValues = shared.values_part("bias_file")
    silicon: SiliconChoice = shared.silicon_part()
    stimulus: tuple[str, ...] = shared.stimulus_option()
    begin: BeginChoice = shared.begin_part()
    csv: str | None = shared.file_option("Write a row a metric and parameter")
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Centre(OnBlock, ManyDies):
    """Move biases so that more dies pass; judge on fresh dies."""

    OWN: ClassVar[str] = "temperature"
    spec: tuple[str, ...] = option((), 'What should pass, as "class is works", repeatable', metavar="TEXT")
    metric: tuple[str, ...] = option(
        (), "Measured besides those of the specs, repeatable", metavar="NAME", names=METRICS
    )
    measure: tuple[str, ...] = shared.measure_option()
    move: tuple[str, ...] = option((), "Moved; every current unless given; repeatable", metavar="BIAS")
    move_param: tuple[str, ...] = option((), "A size that is moved too, repeatable", metavar="NAME")
    reach: float = option(3.0, "How far currents move, each way", name="range", metavar="FACTOR")
    span: str = option("100mV", "How far voltages move, each way", metavar="VOLTAGE")
    tuning_dies: int = option(200, "Dies of the search, from 0 on, at most 1000")
    fresh_dies: int = option(1000, "Dies of the report")
    first_fresh_die: int = option(1000, "The first of them, 1000 or later")
    level: Literal["auto", "behavioural", "transistor"] = option(
        "auto", "Of the search; auto takes a model where there is one"
    )
    by: Literal["dies", "gradient"] = option("dies", "How it searches; gradient for limits, in few runs")
    generations: int = option(10, "Of the search's first stage, by dies")
    seed: int = option(0, "Of the search; a die has its own key")
    variation: SiliconChoice = shared.silicon_part("temperature", "die", "study", "corner")
    temperature: str | None = like(SiliconChoice, "temperature")
    values: BlockValues = shared.values_part("bias_file", "coupling")
    stimulus: tuple[str, ...] = shared.stimulus_option()
    threads: int | None = shared.threads_option()
    output: str | None = shared.file_option("Write the result as JSON", short="o")
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Blame(OnDie):
    """Options that `noctule blame` has for every system."""

    ideal: ClassVar[bool] = False
    seed: int = option(0, "Of the first trial: noise and world")
    success: str | None = option(
        None, 'As "collided == 0 and distance_m >= 20"; the robot\'s own unless given', metavar="TEXT"
    )
    trials: int = option(300, "Runs that may be made, at least 150")
    mended: str | None = shared.file_option("Write the mended die, for --die")
    report: str | None = shared.file_option("Write a page with the story and its pictures, a .html")
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()
