"""Measurement of the selection's model against its transistors: random desirabilities on random dies.

A profile is one of the forest's: a constant, the goal's wide Gaussian, the ping's group and the present
path's narrow Gaussian as excitations, and risks of up to six obstacles that block a few neighbouring paths
each. Per die the transistor level decides every profile from its own rest in the equalised state; its winner
is the line that is high alone at the deadline, its time that line's last rise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from chips.measured.table_record import VERSION, board_key
from chips.model import plain_model
from chips.record import Record, Table
from chips.selection.kernel import Selection
from chips.selection.model import MEASURED, circuits, decision, selection
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.selection.winner_take_all import (
    CELLS,
    RELEASE,
    STANDING,
    Params,
    build,
    decision_testbench,
)
from circuits.circuit import BiasKind
from circuits.devices.source import vertices
from circuits.errors import SolverError
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.lowering.supply import half_supply
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.integrate import source_values
from circuits.solver.newton import allocate
from circuits.solver.operating_point import OperatingPoint, operating_point, rest_state
from circuits.solver.transient import Runner

DEADLINE = 1e-3  # s after the release, ours: a fiftieth of the shortest interval between pings, 50 ms
UNDECIDED = -1
RTOL = 2e-5
HELD_OUT = tuple(range(1000, 1020))  # dies on which the model is judged; it has no measured tables
JUDGED_AT = MEASURED[0], 27.0, MEASURED[1]  # degC
PROFILES = 4  # a die and temperature
_GROUP = 7  # paths of a ping direction, about
_NO_CONDUCTANCE = np.zeros(0)


class Profile(NamedTuple):
    """Currents at the ports of all cells, A, float64[N]: excitations and risks."""

    excite: F64
    risk: F64


@dataclass(frozen=True, slots=True)
class Pair:
    """One profile on one die, decided by the circuit (`solved`) and by the model (`modelled`).

    solved, modelled: winners, -1 where none has won at the deadline; solved_time, modelled_time: s; margin:
    of the model.
    """

    die: int
    solved: int
    solved_time: float
    modelled: int
    modelled_time: float
    margin: float


def random_profile(generator: np.random.Generator, cells: int = CELLS, scale: float = 50e-9) -> Profile:
    """Return the desirability of a random situation; scale: A, of the constant excitation.

    All its numbers are ours.
    """
    k = np.arange(cells)
    goal, path = generator.integers(0, cells, 2)
    group = generator.integers(0, cells - _GROUP + 1)
    excite = 1.0 + 0.3 * np.exp(-(((k - goal) / 8.0) ** 2)) + 0.1 * np.exp(-(((k - path) / 2.0) ** 2))
    excite += 0.1 * ((k >= group) & (k < group + _GROUP))
    risk = np.zeros(cells)
    for _ in range(generator.integers(0, 7)):
        first, size = generator.integers(0, cells), generator.integers(1, 6)
        risk[first : first + size] += generator.uniform(0.0, 0.4)
    return Profile(scale * excite, np.maximum(scale * np.minimum(risk, 0.4), STANDING))


def selection_machine(silicon: Silicon, params: Params | None = None, kind: BiasKind = "gate") -> Machine:
    """Return the circuit on a silicon lowered for the solver, with currents that `with_profile` sets.

    kind: of its biases.
    """
    params = params or Params(CELLS)
    n = int(params.cells)
    bench = decision_testbench(
        rebias(build(params), kind=kind),
        np.full(n, 50e-9),
        np.zeros(n),
        RELEASE + DEADLINE,
        silicon.process.v_dd,
    )
    return to_kernel(bench, silicon)


def with_profile(machine: Machine, profile: Profile) -> Machine:
    """Return the machine with the currents of a profile."""
    given = {f"excite[{k}]": -float(i) for k, i in enumerate(profile.excite)}
    given |= {f"risk[{k}]": float(i) for k, i in enumerate(profile.risk)}
    lines = tuple(
        vertices(name, (0.0,), (given[name],)) if name in given else line
        for name, line in zip(machine.source_names, machine.polylines, strict=True)
    )
    return replace(machine, polylines=lines)


def solved_decision(
    machine: Machine, profile: Profile, near: OperatingPoint, rtol: float = RTOL
) -> tuple[int, float]:
    """Return the winner and the time (s) of the circuit, -1 and inf where no line is high alone at the end.

    near: the rest of the machine with any other profile, on any die.
    """
    there = with_profile(machine, profile)
    runner = Runner(there, (), rtol)
    state, segment = runner.advance(
        runner.begin(_rest(there, near)), machine.testbench.stop, stop_at_event=False
    )
    n = profile.excite.size
    columns = [machine.column_of(f"line[{k}]") for k in range(n)]
    high = np.flatnonzero(state.voltage[0][columns] > half_supply(machine))
    if high.size != 1:
        return UNDECIDED, np.inf
    rises = [time for name, time in segment.spikes if name == f"line[{high[0]}]"]
    return int(high[0]), rises[-1] - RELEASE


def _rest(machine: Machine, near: OperatingPoint) -> OperatingPoint:
    """Rest near another one, without the test of stability, which takes thirty times as long."""
    k, sources = machine.kernel, machine.sources()
    v = near.voltage.copy()
    source_values(sources, sources.start[:-1].copy(), 0.0, v, k.unknowns)
    v[k.columns - 1] = 0.0
    if not rest_state(k, v, allocate(k), np.zeros((k.unknowns, k.unknowns)), _NO_CONDUCTANCE):
        raise SolverError(f"{machine.testbench.title}: no rest with these currents; lower them")
    return replace(near, machine=machine, voltage=v)


def modelled_decision(
    chip: Selection, profile: Profile, deadline: float = DEADLINE
) -> tuple[int, float, float]:
    """Return the winner, the time (s) and the margin of the model, -1 and inf beyond the deadline (s)."""
    found = decision(chip, profile.excite, profile.risk)
    if not found.time <= deadline:
        return UNDECIDED, np.inf, found.margin
    return found.winner, found.time, found.margin


def measure(process: Process) -> Record:
    """Return the record without its errors: the model follows from its devices alone, and has no table."""
    shifts = (0.0,)
    tables = {"deadline_s": Table((), np.array(DEADLINE))}
    key = board_key(circuits(), process, shifts)
    return Record(key, VERSION, {"shift": shifts}, tables, box={"temperature": MEASURED})


def held_out_errors(process: Process) -> dict[str, float]:
    """Return `pair_errors` over all temperatures and dies on which the model is judged."""
    judged = (measure_pairs(HELD_OUT, PROFILES, t, made_in=process) for t in JUDGED_AT)
    return pair_errors([pair for pairs in judged for pair in pairs])


def measure_pairs(
    dies: Sequence[int], profiles: int, temperature_c: float = 27.0, *, seed: int = 1000,
    scale: float = 50e-9, process: bool = True, made_in: Process = AMI_1500_IDEAL,
    kind: BiasKind = "gate",
) -> list[Pair]:  # fmt: skip
    """Decide random profiles on every die at both levels; profiles: how many a die.

    The generator of a die's profiles is seeded with (seed, die); scale: as in `random_profile`; process:
    whether dies have process variation beside mismatch; made_in: the process that they are made in; kind: of
    the biases.
    """
    nominal = selection_machine(Silicon(made_in, temperature_c), kind=kind)
    near = operating_point(nominal)
    pairs = []
    for number in dies:
        die = Die(number=number, process=process)
        machine = on_die(nominal, die)
        chip = selection(machine.silicon, circuit=machine.testbench.circuit)
        generator = np.random.default_rng((seed, number))
        for _ in range(profiles):
            profile = random_profile(generator, scale=scale)
            solved = solved_decision(machine, profile, near)
            winner, time, margin = modelled_decision(chip, profile)
            pairs.append(Pair(number, *solved, winner, time, margin))
    return pairs


def pair_errors(pairs: Sequence[Pair]) -> dict[str, float]:
    """Return how far the model is from the transistors, by name with the unit at its end.

    Errors of time are of the pairs that both decide alike; `margin_wrong` is the greatest margin at which
    they decide differently.
    """
    both = [p for p in pairs if UNDECIDED not in (p.solved, p.modelled)]
    same = [p for p in both if p.solved == p.modelled]
    late = np.array([p.modelled_time / p.solved_time - 1.0 for p in same])
    return {
        "pairs": float(len(pairs)),
        "agree": float(sum(p.solved == p.modelled for p in pairs)),
        "winners_differ": float(len(both) - len(same)),
        "one_undecided": float(sum((p.solved == UNDECIDED) != (p.modelled == UNDECIDED) for p in pairs)),
        "both_undecided": float(sum(p.solved == p.modelled == UNDECIDED for p in pairs)),
        "time_rms_relative": float(np.sqrt(np.mean(late**2))) if same else np.nan,
        "time_max_relative": float(np.abs(late).max()) if same else np.nan,
        "margin_wrong": max((p.margin for p in both if p.solved != p.modelled), default=0.0),
    }


MODEL = plain_model("winner-take-all", circuits, measure, held_out_errors, selection)
