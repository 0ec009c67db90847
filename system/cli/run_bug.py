"""`noctule run bug`: let a robot look for its goal, and say whether it found it."""

from __future__ import annotations

from typing import Any

from circuits.errors import ParameterError
from circuits.units import parse_quantity
from system.bug.body import STEP
from system.bug.brain import STATES
from system.bug.neural import network_of
from system.bug.run import SYSTEM, Scenario, Trace, goal_of, read_options
from system.cli.output import print_json, print_line, progress_bar
from system.cli.run_output import print_run
from system.options.block import describe_die, read_die
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.system import Summary


def run_bug(
    system: str, silicon: SiliconChoice, seed: int, plot: str | None, *, as_json: bool, **options: Any
) -> None:
    """Run one robot, print its summary; `plot` draws its path. `options` are those of its scenario."""
    if plot is not None:
        check_picture(plot)
    celsius = parse_quantity(silicon.temperature, "degC", "--temperature")
    scenario = Scenario(seed=seed, die=read_die(silicon), temperature_c=celsius, **read_options(options))
    if scenario.brain == "reference" and seed != 0:
        raise ParameterError(f"--seed: {seed}, a reference has no neurons to draw; leave it out")
    with progress_bar(f"{system} (the first run compiles its kernels)") as progress:
        trace = SYSTEM.run(scenario, progress)
    summary = SYSTEM.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: SYSTEM.draw(trace, figure))
    if as_json:
        print_json(_document(system, trace, summary))
    else:
        _print(system, trace, summary)


def _document(system: str, trace: Trace, summary: Summary) -> dict[str, Any]:
    s = trace.scenario
    return {
        "system": system,
        "agent": s.agent,
        "brain": s.brain,
        "design": None if s.brain == "reference" else s.design,
        "neurons": None if s.brain == "reference" else network_of(s.agent, s.design, s.neurons).neurons,
        **_of_chip(trace),
        "map": trace.world.map.name,
        "seed": s.seed,
        "start": trace.path[0],
        "goal": goal_of(trace),
        "reached": trace.reached,
        "ended": summary["reason"],
        "time_s": trace.time,
        "step_s": STEP,
        "path": trace.path,
        "state": [STATES[k] for k in trace.state],
        "shortest_path": trace.shortest,
        "summary": summary,
    }


def _of_chip(trace: Trace) -> dict[str, Any]:
    s = trace.scenario
    if trace.chip is None:
        return {}
    return {
        **describe_die(s.die),
        "bias_kind": s.bias_kind,
        "area": s.area,
        "silicon_noise": s.silicon_noise,
        "temperature_C": s.temperature_c,
        "calibrated_C": s.calibrated_c,
        "solved_C": s.solved,
        "chip": dict(trace.chip),
    }


def _print(system: str, trace: Trace, summary: Summary) -> None:
    s = trace.scenario
    if trace.shortest is None:
        print_line(f"{trace.world.map.name}: no way leads from the start to the goal")
    if trace.chip is not None:
        counts = ", ".join(f"{name.replace('_', ' ')} {k}" for name, k in trace.chip.items())
        print_line(f"chip on {s.die} at {s.temperature_c:g} degC: {counts}")
    print_run(f"{system} on {trace.world.map.name}, {s.agent}, {s.brain}", SYSTEM, summary)
