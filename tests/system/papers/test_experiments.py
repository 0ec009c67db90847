"""Experiments are known by their names; made small, each reports rows and progress, and draws.

What of the rows holds for an experiment's small form stands with it in `SMALL`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import pytest

from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.experiment import Progress, Report
from system.papers.checks import (
    beside,
    choice_law,
    coach,
    coach_synthetic,
    forest_silicon,
    forest_weights,
    foundry_blocks,
    foundry_dies,
    latency_agreement,
    latency_law,
    latency_loops,
    latency_recall,
    ranging_law,
    rolls_measured,
    wavefront_law,
)
from system.papers.cheely2003 import fig6 as cheely2003_fig6
from system.papers.cheely2003 import fig9 as cheely2003_fig9
from system.papers.cheely2003 import fig10 as cheely2003_fig10
from system.papers.cheely2003 import power as cheely2003_power
from system.papers.hwu2018 import campaign as hwu2018_campaign
from system.papers.hwu2018 import fig2 as hwu2018_fig2
from system.papers.hwu2018 import table1 as hwu2018_table1
from system.papers.wen2022 import equations as latency_equations
from system.papers.wen2022 import fig10 as wen2022_fig10
from system.papers.wen2022 import fig11a as wen2022_fig11a
from system.papers.wen2022 import fig11b as wen2022_fig11b
from system.papers.wen2022 import fig11d as wen2022_fig11d
from system.papers.wen2022 import fig11e as wen2022_fig11e
from system.papers.wen2022 import fig13 as wen2022_fig13
from system.papers.without_nulls import WITHOUT_NULLS
from system.registry import EXPERIMENTS, load_experiment
from tests.system.papers.conftest import Draw

Run = Callable[[Progress], Report]


def agree(report: Report) -> None:
    """Every row agrees, and some of them were predicted."""
    assert report.disagreeing == ()
    assert all(row.agrees for row in report.rows)
    assert any(not row.fitted for row in report.rows)


@contextmanager
def warm() -> Iterator[None]:
    """Laws are held against transistors at the highest temperature alone, where their effects are largest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(beside, "TEMPERATURES", beside.TEMPERATURES[-1:])
        yield


@warm()
def ranging_law_of_a_die(progress: Progress) -> Report:
    """One die."""
    return ranging_law.EXPERIMENT.run(progress, dies=1)


@warm()
def wavefront_law_of_a_die(progress: Progress) -> Report:
    """One die of the twenty, one of its waves, and the jitter of one code."""
    found = wavefront_law.compare((1003,), progress)
    wave = wavefront_law.wave_of("gate", Silicon(AMI_1500, die=Die(number=1003)))
    rows = wavefront_law.statements(found, [wavefront_law.jitter_of(1)], [wave])
    return Report(rows, lambda figure: wavefront_law.draw(found, figure))


@warm()
def latency_law_of_a_die(progress: Progress) -> Report:
    """One die."""
    return latency_law.EXPERIMENT.run(progress, dies=1)


def few(report: Report) -> None:
    """Every row with a rule agrees but for the number of cases."""
    assert report.disagreeing == ("cases",)


def foundry_of_few(progress: Progress) -> Report:
    """Few devices and dies, and the two or three spikes alone of which a period is taken."""
    with pytest.MonkeyPatch.context() as patch:
        for celsius, duration in ((-20.0, "240ms"), (85.0, "7ms")):
            patch.setitem(foundry_dies.DURATIONS, celsius, duration)
        return foundry_dies.reproduce(progress, devices=500, dies=2)


@warm()
def choice_law_of_a_die(progress: Progress) -> Report:
    """One die."""
    return choice_law.EXPERIMENT.run(progress, dies=1)


def nothing(_: Report) -> None:
    """Too few runs for any verdict."""


def fitted(*names: str) -> Callable[[Report], None]:
    """Every row agrees, and these were used to choose numbers."""

    def says(report: Report) -> None:
        agree(report)
        assert {row.name for row in report.rows if row.fitted} == set(names)

    return says


@dataclass(frozen=True, slots=True)
class Small:
    """A small form: how it runs, what it says, and bytes of its picture; without `run` it is the whole."""

    run: Run | None = None
    says: Callable[[Report], None] = agree
    picture: int = 10_000


def power(report: Report) -> None:
    fitted("quiescent_power_W", "power_50_Hz_one_echo_W")(report)
    names = {row.name for row in report.rows}
    assert names > {"power_10_Hz_one_echo_W", "power_50_Hz_no_echo_W", "separate_over_coupled"}
    assert any(n.startswith("Fitted: I_cmp 500 nA and I_lim 6.3 uA") for n in report.notes)


def transients(report: Report) -> None:
    found = {row.name: row for row in report.rows}
    assert report.disagreeing == ()
    assert {name for name, row in found.items() if row.agrees is None} == {
        "transient_high_A", "transient_extent_A", "input_coupling_F"
    }  # fmt: skip
    assert {name for name, row in found.items() if row.fitted} == {
        "i_max_A", "decay_rate_weak_decade_per_s", "input_coupling_F", "input_coupling_transient_high_A",
    }  # fmt: skip
    assert found["transient_high_A"].shown < 0.01e-6  # as drawn there is none
    assert 12e-15 < found["input_coupling_F"].shown < 20e-15


def equations(report: Report) -> None:
    agree(report)
    assert len(report.rows) == 4


COACH = ("fet_n_sub_vg", "fet_n_backgate", "ndp_run1")
SYNTHETIC = coach_synthetic.Fits(COACH, ("wta_cal_iout", "wta_iin_16cells", "fet_p_backgate"))


def left_out(report: Report) -> None:
    """Sweeps and a pair that are left out in turn lie in their bands, and the pair's kappa is the curve's."""
    rows = {row.name: row for row in report.rows}
    assert rows["ndp_run1_kappa"].agrees
    assert float(rows["points_inside_the_band_share"].shown or 0.0) > 0.5
    assert "inside_of_transistors_share" in rows


def assumed(report: Report) -> None:
    """The measured process matches worse, by a half in A_VT, and so do the pulses of its extenders."""
    rows = {row.name: row for row in report.rows}
    assert rows["kappa_p_4_um"].paper == 0.66
    assert rows["kappa_n_4_um"].shown == pytest.approx(0.74, abs=0.02)
    # A_VT alone makes 1.53 of it
    assert 1.65 * rows["pulse_length_cv"].paper < rows["pulse_length_cv"].shown < 1.85 * 0.036


def covered(report: Report) -> None:
    """Each of two known dies is fitted and identified, and their pairs' offsets are found."""
    rows = {row.name: row for row in report.rows}
    assert rows["extract_fits_that_fail"].shown == rows["identify_fits_that_fail"].shown == 0
    assert float(rows["extract_pair_offset_error"].shown or 9.0) < 1.0
    assert float(rows["identify_ring_inputs_error"].shown or 9.0) < 1.0
    assert "extract_n.v_t0_covered_share" in rows


def one_die(report: Report) -> None:
    """A foundry's die is one in a batch, alone and in its netlist; our law is near its cards."""
    rows = {row.name: row for row in report.rows}
    for name in ("period_in_a_batch_less_alone_s", "spikes_alone_less_netlist_s", "nfet_law_off_median"):
        assert rows[name].agrees, name


def two_blocks(report: Report) -> None:
    """A block does on the foundry's cards what it does at home; of one the sizes moved."""
    rows = {row.name: row for row in report.rows}
    outcome = rows["high_threshold_neuron_outcome"]
    assert (outcome.shown, outcome.paper) == ("one-spike", "one-spike")
    assert rows["high_threshold_neuron_latency_s"].shown == pytest.approx(139e-6, rel=0.05)
    assert rows["dpi_synapse_outcome"].rule.text == "sizes moved into the foundry's range"
    assert rows["blocks_that_run"].shown == 2.0


def agreement(report: Report) -> None:
    found = {row.name: row for row in report.rows}
    assert found["pings"].shown == 6.0
    assert not found["pings"].agrees
    assert not found["kappa_lower_limit"].agrees  # no interval of one block


def recall(report: Report) -> None:
    assert report.rows[0].agrees  # what is recalled is near what was heard
    assert len(report.notes) <= len(latency_recall.BUILDS)


def loops(report: Report) -> None:
    assert any(note.startswith("chip: repeats 1 of 1") for note in report.notes)
    assert not report.rows[0].agrees  # one loop shows nothing


def silicon(report: Report) -> None:
    assert len(report.notes) == 1 + 2  # an area, and a temperature with both kinds of bias


def weights(report: Report) -> None:
    assert [row.name for row in report.rows] == ["by_speed_at_1"]  # at 3 m/s there is no difference


def medians(report: Report) -> None:
    # the paper's own test does not find what it says, and the maps are ours
    assert {name for name in report.disagreeing if "median" not in name} == {
        f"{name}_rank_sum_p" for name in hwu2018_table1.WITH_ROAD
    }
    assert any(row.name.endswith("signed_rank_p") and row.agrees for row in report.rows)


def short_flight(report: Report) -> None:
    assert not report.rows[0].agrees
    assert "0 crossings" in report.notes[0]


def middle_checked(progress: Progress) -> Report:
    """Direct runs of all pairs next to the edges for the middle neuron alone, and of some delays for each."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cheely2003_fig6, "CHECKED", (6,))
        return cheely2003_fig6.run_on_grid(progress, 1e-3, 10e-3)


def settled_soon(progress: Progress) -> Report:
    """The interval after one call instead of three, which `test_power` shows to differ by little."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cheely2003_power, "SETTLING", 1)
        return cheely2003_power.run_cases(progress, CASES)


# without 100 Hz and three echoes, for time
CASES = tuple(c for c in cheely2003_power.CASES if c.rate < 100.0 and len(c.echoes) < 3)
# p of 40 pairs is still far below 0.001; on 24 dies regrets at areas x0.25 and x16 are still intervals apart
SWEEPS = {"unit": (20e-6, 100e-6), "temperature_c": (27.0,), "area": (0.25, 16.0)}
FEW = {"collisions": 4, "pings": 20_000}
SMALL: dict[str, Small] = {
    "cheely2003-fig4": Small(),
    "cheely2003-fig5": Small(says=transients),
    "ranging-law": Small(ranging_law_of_a_die, few),
    "wavefront-law": Small(wavefront_law_of_a_die),
    "latency-law": Small(latency_law_of_a_die, few),
    "choice-law": Small(choice_law_of_a_die, nothing),
    # delays in steps of 1 ms instead of 0.25 ms, and direct runs every 10 ms
    "cheely2003-fig6": Small(
        middle_checked,
        fitted(
            "reciprocal_first_best_delay_s",
            "reciprocal_last_best_delay_s",
            "reciprocal_largest_distance_from_line",
        ),
    ),
    "cheely2003-fig8": Small(),
    "cheely2003-fig9": Small(lambda p: cheely2003_fig9.run_on_grid(p, 4e-3)),  # 7 delays instead of 53
    "cheely2003-fig10": Small(lambda p: cheely2003_fig10.run_on_grid(p, 5)),  # voltages instead of 15
    "cheely2003-power": Small(settled_soon, power),
    "hwu2018-fig1": Small(),
    "hwu2018-fig2": Small(lambda p: hwu2018_fig2.reproduce(p, 15)),
    "hwu2018-table1": Small(lambda p: hwu2018_table1.reproduce(p, 40), medians),
    "hwu2018-table2": Small(),
    "hwu2018-campaign": Small(lambda p: hwu2018_campaign.reproduce(p, 24, 10, SWEEPS)),
    "wen2022-fig5": Small(),
    "wen2022-fig10": Small(lambda p: wen2022_fig10.reproduce(p, 300, 600), nothing),
    "wen2022-fig11a": Small(lambda p: wen2022_fig11a.reproduce(p, numbers=(500, 1700), **FEW), nothing),
    "wen2022-fig11b": Small(
        lambda p: wen2022_fig11b.EXPERIMENT.run(p, flown=wen2022_fig11b.cases((1.5, 2.0)), **FEW), nothing
    ),
    "wen2022-fig11c": Small(),
    "wen2022-fig11d": Small(
        lambda p: wen2022_fig11d.EXPERIMENT.run(p, flown=wen2022_fig11d.cases((2.0, 3.0)), **FEW), nothing
    ),
    "wen2022-fig11e": Small(
        lambda p: wen2022_fig11e.EXPERIMENT.run(
            p, flown=wen2022_fig11e.cases((3.0, 6.0), (5.0, 10.0)), **FEW
        ),
        nothing,
    ),
    "wen2022-fig12": Small(picture=50_000),
    "wen2022-fig12-chip": Small(picture=30_000),
    "wen2022-fig13": Small(
        lambda p: wen2022_fig13.reproduce(p, forests=1, first=1000, pings=4), short_flight, 20_000
    ),
    "latency-equations": Small(lambda p: latency_equations.reproduce(p, 3), equations),
    "latency-agreement": Small(lambda p: latency_agreement.reproduce(p, pings=6, flight=6), agreement),
    "latency-recall": Small(lambda p: latency_recall.reproduce(p, 1), recall),
    "latency-loops": Small(lambda p: latency_loops.reproduce(p, loops=1, first=253, pings=12), loops),
    "forest-silicon": Small(
        lambda p: forest_silicon.reproduce(p, areas=(64.0,), temperatures=(27.0,), collisions=2, pings=1500),
        silicon,
    ),
    "forest-weights": Small(
        lambda p: forest_weights.EXPERIMENT.run(
            p, flown=forest_weights.cases((1.0, 3.0)), collisions=3, pings=20_000
        ),
        weights,
    ),
    "foundry-dies": Small(foundry_of_few, one_die),
    "coach-synthetic": Small(
        lambda p: coach_synthetic.reproduce(p, dies=2, identified=1, fits=SYNTHETIC), covered
    ),
    "coach": Small(lambda p: coach.reproduce(p, COACH), left_out),
    "rolls-measured": Small(
        lambda p: rolls_measured.reproduce(p, names=COACH[1:], parts=("extender",), kinds=()), assumed
    ),
    "foundry-blocks": Small(
        lambda p: foundry_blocks.reproduce(p, ("high-threshold-neuron", "dpi-synapse")), two_blocks
    ),
    "stockel2017-fig5": Small(),
}


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_it_is_known(name: str) -> None:
    found = load_experiment(name)
    assert found.name == name
    assert found.summary


def test_every_experiment_has_nulls_or_a_reason_for_none() -> None:
    without = {name for name in EXPERIMENTS if not load_experiment(name).nulls}
    assert without == set(WITHOUT_NULLS)
    assert all(len(reason) > 20 for reason in WITHOUT_NULLS.values())


@dataclass(frozen=True, slots=True)
class Outcome:
    """A small form, what it reported, and the shares that its progress told."""

    name: str
    small: Small
    report: Report
    progress: list[float]


@pytest.fixture(scope="module", params=SMALL)
def outcome(request: pytest.FixtureRequest) -> Outcome:
    small, told = SMALL[request.param], list[float]()
    run = small.run or load_experiment(request.param).run
    return Outcome(request.param, small, run(told.append), told)


def test_it_says_what_it_ought_to(outcome: Outcome) -> None:
    rows = outcome.report.rows
    assert rows
    assert len({row.name for row in rows}) == len(rows)
    outcome.small.says(outcome.report)


def test_its_nulls_are_those_that_it_names(outcome: Outcome) -> None:
    report, chosen = outcome.report, load_experiment(outcome.name)
    assert tuple(null.name for null in report.nulls) == chosen.nulls
    assert [score.judged for score in report.scores[1 : 1 + len(report.nulls)]] == [
        report.scores[0].judged
    ] * len(report.nulls)


def test_its_progress_rises_to_one(outcome: Outcome) -> None:
    assert outcome.progress == sorted(outcome.progress)
    assert outcome.progress[-1] == pytest.approx(1.0)


def test_it_draws(outcome: Outcome, drawn: Callable[[Draw], int]) -> None:
    assert drawn(outcome.report.draw) > outcome.small.picture
