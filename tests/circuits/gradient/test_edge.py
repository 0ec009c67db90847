"""Gradients of a search over a stimulus against searches on moved dies, to a nanosecond."""

import numpy as np
import pytest

from circuits.blocks.sonar import tuning
from circuits.blocks.sonar.tuning import tune, tuning_machine
from circuits.blocks.sonar.tuning_metrics import BEST_DELAY, WIDTH
from circuits.gradient.edge import gradients_at_edges
from circuits.lowering.kernel import on_die
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from tests.circuits.gradient.differences import deviation_of

BLOCK = load_block("rebound-neuron")


def machine_of(number):
    return tuning_machine(BLOCK.build(), Silicon(BLOCK.process, 27.0, Die(number=number)))


def at_edges(machine, metric):
    searched = tune(machine)
    return gradients_at_edges(metric.name, "s", metric.value(searched), metric.edges(machine, searched))


def test_best_delay_and_width_are_those_of_searches_on_moved_dies(monkeypatch):
    machine = machine_of(1003)
    own = {metric.name: at_edges(machine, metric) for metric in (BEST_DELAY, WIDTH)}
    monkeypatch.setattr(tuning, "RESOLUTION", 1e-9)
    label = "rebound_neuron.membrane.mr1.v_t0"
    at, sigma = deviation_of(machine, label), own["width"].sigma[own["width"].labels.index(label)]
    dies = [
        machine.silicon.die.with_(label.removesuffix(".v_t0"), "v_t0", at + s)
        for s in (0.01 * sigma, -0.01 * sigma)
    ]
    ends = [tune(on_die(machine, die), 1e-8) for die in dies]
    for metric in (BEST_DELAY, WIDTH):
        found = own[metric.name]
        wanted = (metric.value(ends[0]) - metric.value(ends[1])) / (0.02 * sigma)
        off = abs(found.by[0, found.labels.index(label)] - wanted) * sigma / found.spread[0]
        assert off < 0.01, metric.name
        assert found.notes == ("",)


def test_a_neuron_without_an_interval_has_no_edges():
    machine = machine_of(1005)
    searched = tune(machine)
    assert searched.outcome.value == "never"
    assert BEST_DELAY.edges(machine, searched) == []


def test_an_edge_on_whose_both_sides_spikes_come_is_told():
    machine = machine_of(None)
    searched = tune(machine)
    first, last = BEST_DELAY.edges(machine, searched)
    inside = type(first)(
        lambda away: last.beside(-1e-4 - away), first.resolution, "echo", "spike", "v_ax", last.begin, 1.0
    )
    found = gradients_at_edges("best_delay", "s", searched.best_delay, [inside])
    assert "a spike comes on both sides of the edge" in found.notes[0]
    assert np.isnan(found.by).all()


def test_the_edges_of_a_search_are_known_better_than_its_steps():
    first, last = (at_edges(machine_of(None), metric) for metric in (BEST_DELAY, WIDTH))
    label = "process.n.shared.v_t0"
    # 1e-9 s of resolution at a tolerance of 1e-8 gives 0.15735 and 0.00295 s/V
    assert first.by[0, first.labels.index(label)] == pytest.approx(0.15735, rel=1e-3)
    assert last.by[0, last.labels.index(label)] == pytest.approx(0.00295, abs=2e-4)
