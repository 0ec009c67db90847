"""Every target of a study has metrics that work where none is asked for."""

import json
import math
from dataclasses import replace

import pytest

from circuits.lowering.kernel import Machine
from circuits.registry import block_names
from circuits.silicon.die import Die
from circuits.solver.transient import Result, simulate
from system.cli.command_line import main
from system.options.block import choose
from system.registry import load_system, system_names
from system.study.metrics import metric
from system.study.metrics.metric import default_metrics
from system.study.table import Condition
from system.study.target import BlockTarget, Subject, SystemTarget
from tests.chips.whole import WHOLE_CHIPS

SMALL = {"wavefront-chip": ("rows=2", "columns=2"), "latency-chip": ("paths=1", "taps=1", "synapses=1")}


def begin(machine: Machine) -> Result:
    """The first microsecond of a testbench, which has the names of what the whole one measures."""
    return simulate(replace(machine, testbench=replace(machine.testbench, stop=1e-6)))


@pytest.mark.parametrize("name", [*block_names(), *WHOLE_CHIPS])
def test_a_block_has_metrics_of_its_own(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metric, "simulate", begin)
    params = SMALL.get(name, ())
    names = default_metrics(choose(name, params))
    target = BlockTarget(Subject(name, names, params))
    found = target.measure(Die(number=1000), Condition("random", 27.0, 0))
    assert [q.name for q in target.quantities] == list(names)
    assert len(found.values) == len(names) > 0
    assert found.outcome


@pytest.mark.parametrize("name", system_names())
def test_a_system_has_metrics_of_its_own(name: str) -> None:
    names = load_system(name).study_metrics
    assert [q.name for q in SystemTarget(Subject(name, names)).quantities] == list(names)


def test_a_study_of_a_chip_needs_no_metric(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(metric, "simulate", begin)  # which metrics a study takes does not depend on the run
    assert main(["montecarlo", "ranging-chip", "-n", "1", "--threads", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["metrics"]) == {"spiking_neurons", "supply_power_W"}
    assert math.isfinite(found["metrics"]["spiking_neurons"]["mean"])


def test_a_flight_of_a_study_keeps_its_way_where_it_is_shown() -> None:
    options = {"pings": 3, "rows": 0, "ranges": "exact", "selection": "ideal"}
    target = SystemTarget(Subject("forest", ("collided",), system=options))
    film = [target.film(target.run(Die(), Condition("random", 27.0, 0), shown=s)) for s in (False, True)]
    ways = [each.world.tracks[0].time.size for each in film if each.world is not None]
    assert ways == [1, 4]  # where it ended, and each ping before
