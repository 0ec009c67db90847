"""Sizes of least area: a pair needs what Pelgrom's law says, and what cannot be is said in a line."""

from __future__ import annotations

import json

import pytest
from scipy.special import ndtri

from circuits.blocks.rolls import dpi_synapse
from circuits.registry import load_block
from system.cli.command_line import main
from system.study.search.knob import lengths_of
from system.study.search.size import area_of
from system.study.target import BlockTarget, Subject
from tests.refusals import command_refusals

PAIR = ("size", "differential-pair", "--no-process-variation", "--move-param", "pair_length")


def test_a_pair_gets_the_area_that_its_offset_needs(capsys: pytest.CaptureFixture[str]) -> None:
    asked = [*PAIR, "--spec", "offset_V in -5mV:5mV", "--yield", "95%", "--fresh-dies", "60", "--json"]
    assert main(asked) in {0, 1}
    found = json.loads(capsys.readouterr().out)
    block = load_block("differential-pair")
    sigma = 5e-3 / float(ndtri(0.975))
    wanted = (block.process.pair_a_vt / sigma) ** 2  # of each gate, whose width stays 1 um
    assert found["search"]["yield_after"] >= 0.95
    (moved,) = found["moved"]
    assert (moved["unit"], moved["after"]) == (
        "um",
        pytest.approx(wanted / 1e-12, rel=0.25),
    )  # 200 dies move it from there
    assert found["area_after_m2"] == pytest.approx(2e-12 * moved["after"] + 1e-12, rel=1e-3)
    (fresh,) = found["fresh"]
    share = fresh["after"]["value"]
    high = fresh["after"]["interval"]["high"]
    verdict = "met" if share >= 0.95 else "undecided" if high >= 0.95 else "missed"
    assert found["verdict"] == verdict


def test_area_is_that_of_gates_and_plates() -> None:
    block = load_block("differential-pair")
    assert area_of(block.build(), block.process) == pytest.approx(3e-12)
    neuron = load_block("dpi-synapse")
    assert neuron.process.components is not None
    plates = 1e-12 / neuron.process.components.capacitance_density
    small, large = (
        area_of(neuron.build(dpi_synapse.Params(synapse_capacitance=c)), neuron.process)
        for c in (1e-12, 1.5e-12)
    )
    assert large - small == pytest.approx(plates, rel=1e-6)  # two filters of half a picofarad more


@pytest.mark.parametrize(
    ("block", "lengths"),
    [
        ("envelope-detector", ["follower_width", "follower_length"]),  # among resistances and capacitances
        ("differential-pair", ["pair_width", "pair_length", "tail_width", "tail_length"]),
    ],
)
def test_widths_and_lengths_move_unless_named(block: str, lengths: list[str]) -> None:
    assert lengths_of(BlockTarget(Subject(block, ())).choice) == lengths


test_what_cannot_be = command_refusals(
    "size",
    rows=[
        ("approach --spec x", "size: approach is a system, must be a block or chip"),
        ("differential-pair --spec x --yield 100%", "--yield: 100%, must be at least 50% and below 100%"),
        ("differential-pair --spec 'offset_V in :5mV' --threads 0", "--threads: 0, must be at least 1"),
        ("differential-pair --spec 'class is balanced'", "size: no metric, must name one"),
    ],
)
