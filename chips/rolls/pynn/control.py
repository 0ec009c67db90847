"""PyNN's calls that set up the chip and let it run."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from pyNN import common
from pyNN.connectors import FixedProbabilityConnector
from pyNN.recording import get_io

from chips.rolls.chip import STEP
from chips.rolls.program.program import Program
from chips.rolls.pynn.cells import StaticSynapse
from chips.rolls.pynn.populations import Population
from chips.rolls.pynn.projections import Projection
from chips.rolls.pynn.simulator import MS, Setting, simulator, state
from circuits.errors import ParameterError, unknown_name


def setup(
    timestep: float = STEP / MS, min_delay: float | str = "auto", max_delay: float | str = "auto", **chip: Any
) -> int:
    """Begin a script on a chip, without any population; returns the rank, 0.

    timestep : step of the chip, ms; min_delay, max_delay : of the synapses, ms, or auto; chip : the fields of
    `Setting`: `die`, `temperature_c`, `bias_kind`, `biases`, `noise`, and `seed` of random events.

    Raises `ParameterError` for a step or a delay, `UnknownNameError` for something else about the chip.
    """
    for name, value in (("min_delay", min_delay), ("max_delay", max_delay)):
        if value not in {"auto", timestep}:
            raise ParameterError(
                f"pynn.setup.{name}: {value} ms, must be auto; synapses of ROLLS have no delay"
            )
    if not (np.isfinite(timestep) and timestep > 0.0):
        raise ParameterError(f"pynn.setup.timestep: {timestep:g} ms, must be > 0 and finite")
    known = [each.name for each in fields(Setting)]
    for name in chip:
        if name not in known:
            raise unknown_name("pynn.setup", name, known)
    state.setting, state.dt = Setting(**chip), timestep
    state.clear()
    return 0


def end(*_: object, **__: object) -> None:
    """Write what was to be written at the end."""
    for population, variables, file in state.write_on_end:
        population.write_data(get_io(file), variables)
    state.write_on_end = []


def program() -> Program:
    """Return what is written to the chip, as every other part of noctule takes it."""
    return state.program()


def counts() -> dict[str, int]:
    """Return how many events the chip's buses lost, and how often a filter stayed at its end."""
    return dict(state.lost)


run, run_until = common.build_run(simulator)
run_for = run
reset = common.build_reset(simulator)
initialize = common.initialize
get_current_time, get_time_step, get_min_delay, get_max_delay, num_processes, rank = (
    common.build_state_queries(simulator)
)
create = common.build_create(Population)
connect = common.build_connect(Projection, FixedProbabilityConnector, StaticSynapse)
record = common.build_record(simulator)
