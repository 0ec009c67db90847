"""Every name of the package `system` that users call, in one place.

A system is a robot in its world; a study measures many dies of a circuit or a system; an experiment makes a
figure of a paper again. The steps of the Pushbot are in `system.api.pushbot`, those of the rover in
`system.api.rover`; what both see and hear of the world is in `system.api.worlds`.
"""

from system.experiment import Experiment, Report
from system.loop import AnalogWire, EventWire, Loop
from system.option import Option, check_options, option, required
from system.options.die.file import read_die_file
from system.options.on_silicon import OnSilicon
from system.plot import draw_circuit, draw_waveforms
from system.registry import experiment_names, load_experiment, load_system, system_names
from system.rule import (
    Rule,
    above,
    at_least,
    at_most,
    below,
    between,
    equal,
    exactly,
    unjudged,
    within,
    within_share,
)
from system.scenario import scenario_of
from system.spikes.file import write_spikes
from system.spikes.read import read_spikes
from system.statement import Statement
from system.stream.client import EventStream
from system.stream.server import EventServer
from system.study.cluster import on_cluster
from system.study.engine import on_threads, run_study
from system.study.folder import study_table
from system.study.manifest import Study, read_study
from system.study.metrics.gradient import gradients
from system.study.plan import Plan
from system.study.replay import Replay, die_of, replay
from system.study.report.picture import draw_study
from system.study.search.rare_die import rare_failure
from system.study.search.sensitivity import Sensitivity, sensitivity
from system.study.specification import Classes, Limits, Success, Verdict, judge, parse_spec
from system.study.statistics.comparison import Pairing, YieldDifference, compare_yields
from system.study.statistics.confidence_sequence import StopRule, first_stop
from system.study.statistics.interval import (
    Estimate,
    Interval,
    clopper_pearson,
    mean_interval,
    quantile_interval,
    sigma_interval,
)
from system.study.statistics.rare import RareFailure
from system.study.statistics.share import Share
from system.study.statistics.summary import Summary, Yield, summarise, summarise_yield
from system.study.table import Condition, Table
from system.study.target import Measurement, Subject, Target, open_target
from system.system import Account, Run, System
from system.verdict.null import nulls_of

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Systems and their runs
    "system_names",
    "load_system",
    "System",
    "Account",
    "Run",
    "scenario_of",
    # Options of a scenario
    "option",
    "required",
    "Option",
    "check_options",
    "OnSilicon",
    # The loop
    "Loop",
    "EventWire",
    "AnalogWire",
    # Studies
    "Study",
    "read_study",
    "Subject",
    "open_target",
    "Target",
    "Measurement",
    "Plan",
    "Condition",
    "Table",
    "run_study",
    "on_threads",
    "on_cluster",
    "study_table",
    "replay",
    "Replay",
    "die_of",
    "read_die_file",
    "draw_study",
    # Specifications and yield
    "parse_spec",
    "Limits",
    "Classes",
    "Success",
    "judge",
    "Verdict",
    "summarise_yield",
    "Yield",
    "compare_yields",
    "YieldDifference",
    "Pairing",
    "StopRule",
    "first_stop",
    # Statistics
    "summarise",
    "Summary",
    "Share",
    "Interval",
    "Estimate",
    "clopper_pearson",
    "mean_interval",
    "sigma_interval",
    "quantile_interval",
    # Searches
    "gradients",
    "sensitivity",
    "Sensitivity",
    "rare_failure",
    "RareFailure",
    # Experiments and their statements
    "experiment_names",
    "load_experiment",
    "Experiment",
    "Report",
    "Statement",
    "Rule",
    # Rules
    "at_least",
    "at_most",
    "above",
    "below",
    "between",
    "exactly",
    "equal",
    "within",
    "within_share",
    "unjudged",
    "nulls_of",
    # Spikes as files
    "write_spikes",
    "read_spikes",
    # Streams of address-events
    "EventServer",
    "EventStream",
    # Pictures
    "draw_waveforms",
    "draw_circuit",
]
