"""The bench of an identified die reads what the model by which it was identified says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from chips.coach.bench import CoachBench
from chips.coach.readout import Board
from circuits.errors import DataError, ParameterError
from circuits.extraction.coach.bench import Bench
from circuits.extraction.coach.chip import die_of
from circuits.extraction.coach.conditions import MASTERS, Condition, read_conditions
from circuits.extraction.coach.joint import fit
from circuits.extraction.coach.models import MODELS, measured, predicted, unknowns_of
from circuits.extraction.coach.posterior import posterior_table
from circuits.extraction.coach.table import Table, read_folder
from circuits.extraction.coach.unknown import Posterior, Theta, Unknown, before
from circuits.silicon.die import NOMINAL, Die, standard_normals
from circuits.silicon.edit import Edit
from circuits.silicon.process import ROLLS_180
from circuits.silicon.process_file import process_of
from circuits.silicon.silicon import Silicon
from system.options.die.file import read_die_file, write_die_file
from tests.documents import ROOT

BASE = process_of("coach-180")
CONDITIONS = read_conditions()
DATA = {**read_folder(None, "fit", CONDITIONS), **read_folder(None, "predict", CONDITIONS)}
MASTER = dict(zip(MASTERS, (60e-12, 460e-12, 3.8e-9, 30e-9, 240e-9), strict=True))
STEP = 1e-4  # V, above a voltage that the DAC made, in the files' digits, so that it makes the same again
EXECUTION = (" drift", " phase", " start", "foi high", "foi read", "backgate held")
SURE = 0.01  # of a spread, that the measurements are said to leave


@dataclass(frozen=True)
class Made:
    """A chip that is known: its file, the bench made of it, and the model by which it would be identified."""

    path: Path
    bench: CoachBench
    model: Bench

    def read(self, name: str) -> tuple[Condition, Table, Mapping[str, np.ndarray]]:
        return (*DATA[name], predicted(self.model, *DATA[name]))

    def set(self, circuit: str, condition: Condition) -> CoachBench:
        self.bench.select(circuit)
        for bias in condition.biases:
            self.bench.set_bias(bias.name, bias.type, MASTER[bias.master], bias.fine or 0)
        return self.bench

    def swept(
        self,
        name: str,
        circuit: str,
        pins: Mapping[str, str | float],
        read: Mapping[str, str],
        points: int = 9,
    ) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """What the model and the bench read of a measurement's columns at some of its points."""
        condition, table, found = self.read(name)
        bench = self.set(circuit, condition)
        some = np.unique(np.linspace(0, len(next(iter(found.values()))) - 1, points).astype(int))
        rows = []
        for k in some:
            for pin, column in pins.items():
                volt = float(table[column][k]) if isinstance(column, str) else column
                bench.set_voltage(pin, volt + STEP)
            rows.append([reading(bench, pin) for pin in read])
        return {c: (found[c][some], np.array(rows)[:, i]) for i, c in enumerate(read.values())}


def reading(bench: CoachBench, pin: str) -> float:
    verbs: dict[str, Callable[[str], float]] = {"C": bench.read_counts, "A": bench.read_voltage}
    return float(verbs.get(pin[0], bench.read_current)(pin))


def drawn(die: int, prior: Posterior) -> np.ndarray:
    """All unknowns but numbers of the process, half a spread apart on average; no execution's own."""
    normals = standard_normals(Die("A", die), (("made", ()),), [((n, ()),) for n in prior.names], "unknown")
    moved = np.array([u.kind != "process" and not _of_execution(u) for u in prior.unknowns])
    return prior.mean + np.where(moved, 0.5 * normals, 0.0) * prior.sd


def _of_execution(unknown: Unknown) -> bool:
    subtracted = unknown.unit == "A" and unknown.name.endswith(" offset")
    return subtracted or any(text in unknown.name for text in EXECUTION)


def write(path: Path, posterior: Posterior) -> None:
    write_die_file(path, die_of(posterior), posterior_table(posterior, {}, BASE.name, CONDITIONS))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """A chip all of whose unknowns were found."""
    path = tmp_path_factory.mktemp("die") / "die.toml"
    prior = before(unknowns_of(CONDITIONS, BASE))
    mean = drawn(1000, prior)
    for name, value in (("ahn input", -26.565), ("ahn line", -27.922)):  # with which it spikes
        mean[prior.names.index(name)] = value
    write(path, Posterior(prior.unknowns, mean, np.diag((SURE * prior.sd) ** 2)))
    theta = Theta(dict(zip(prior.names, mean.tolist(), strict=True)))
    silicon = Silicon(BASE, theta["temperature_c"], read_die_file(path))
    return Made(path, CoachBench(silicon, identified=path), Bench(theta, BASE))


PAIR = {"C2F0": "n1_counts", "C2F1": "n2_counts"}
COUNTED = {
    ("ndp_run1", "NDP", "AIN5", "AIN6"): PAIR,
    ("bab_runA", "BAB", "AIN12", "AIN13"): {"C2F5": "n1_counts", "C2F6": "n2_counts", "C2F7": "nout_counts"},
    ("nta_iout_vcm0.9_f42", "NTA", "AIN3", "AIN4"): {"C2F11": "n_plus_counts", "C2F12": "n_minus_counts"},
}


@pytest.mark.parametrize("case", COUNTED, ids=lambda case: case[1])
def test_converters_count_as_identified(made: Made, case: tuple[str, str, str, str]) -> None:
    name, circuit, plus, minus = case
    found = made.swept(name, circuit, {plus: "v1_V", minus: "v2_V"}, COUNTED[case])
    for model, bench in found.values():
        # the model scales a charge at the code that is set, the bench once: 2 % of a pair's currents, and 5 %
        # of the bump's share of the tail, which the code moves; chance is a few counts
        assert bench == pytest.approx(model, rel=0.05 if circuit == "BAB" else 0.02, abs=8.0)


@pytest.mark.parametrize(
    ("name", "circuit", "still"),
    [
        ("fet_n_sub_vg", "NFET", {"GO22": 1.7984, "GO20": 0.0}),
        ("fet_n_sat_vg", "NFET", {"GO22": 1.7984, "GO20": 0.0}),
        ("fet_p_sub_vg", "PFET", {"AIN1": 1.7984, "GO23": 1.7984, "GO21": 0.0}),
    ],
)
def test_ammeters_read_as_identified(made: Made, name: str, circuit: str, still: dict[str, float]) -> None:
    made.bench.set_range(DATA[name][0].settings["range"])
    column = next(iter(made.read(name)[2]))
    pin = "GO20" if circuit == "NFET" else "GO21"
    model, bench = made.swept(name, circuit, {"AIN0": "v_g_V", **still}, {pin: column}, 40)[column]
    span = made.bench.board.ranges[DATA[name][0].settings["range"]]
    inside = (model > 0.04 * span.full) & (model < 0.9 * span.full)
    assert inside.sum() > 2
    assert bench[inside] == pytest.approx(model[inside], rel=0.02)


@pytest.mark.parametrize(
    ("name", "circuit", "pins", "pin"),
    [("wrt_vout_1", "WRT", ("AIN7", "AIN8"), "ADC11"), ("nta_vout_1", "NTA", ("AIN3", "AIN4"), "ADC13")],
)
def test_voltages_are_read_as_identified(
    made: Made, name: str, circuit: str, pins: tuple[str, str], pin: str
) -> None:
    pins_at: dict[str, str | float] = {pins[0]: "v1_V", pins[1]: DATA[name][0].voltages["v2"]}
    model, bench = made.swept(name, circuit, pins_at, {pin: "v_out_V"})["v_out_V"]
    assert bench == pytest.approx(model, abs=1.5e-3)  # a step, and what one of the input is worth


def test_a_line_slews_and_a_neuron_spikes_as_identified(made: Made) -> None:
    condition, table, model = made.read("foi_step_large")
    bench = made.set("FOI", condition)
    bench.set_voltage("AIN9", condition.voltages["v_from"] + STEP)
    record = bench.record(["ADC10"], 200, 20e-6, steps={"AIN9": condition.voltages["v_to"] + STEP})
    levels = np.array([0.95, 1.1])
    took = np.diff(np.interp(levels, record.values["ADC10"], record.time))
    assert took == pytest.approx(np.diff(np.interp(levels, model["v_out_V"], table["t_s"])), rel=0.01)

    condition, _, model = made.read("ahn_pw2")
    bench = made.set("AHN", condition)
    v = bench.record(["ADC11"], 200, condition.settings["sample_s"] * 1.02).values["ADC11"]
    jumps = np.diff(np.flatnonzero(np.diff(v) > 0.3))
    theirs = np.diff(np.flatnonzero(np.diff(model["v_mem_V"]) > 0.3))
    assert jumps.size > 3
    assert np.mean(jumps) == pytest.approx(np.mean(theirs), rel=0.03)
    assert v.max() == pytest.approx(model["v_mem_V"].max(), abs=0.03)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Posterior, Bench]:
    """A known chip, identified from measurements of its pair and of the pair's converters that it made."""
    names = [n for n in DATA if n == "ndp_run1" or n.startswith("c2f_cal_ndp")]
    prior = before(unknowns_of(CONDITIONS, BASE))
    theta = Theta(dict(zip(prior.names, drawn(1001, prior).tolist(), strict=True)))
    truth, made = Bench(theta, BASE), {}
    for name in names:
        condition, table = DATA[name]
        clean = predicted(truth, condition, table)
        spread = MODELS[condition.circuit].noise(condition, clean)
        read = {
            c: v
            + spread[c]
            * standard_normals(Die("A", 1001), (("made", ()),), [((name, ()), (c, (v.size,)))], "r")
            for c, v in clean.items()
        }
        made[name] = (condition, Table({**table, **read}))
    found = fit(measured(made), prior, BASE, rounds=1)
    path = tmp_path_factory.mktemp("fitted") / "die.toml"
    write(path, found.posterior)
    return path, found.posterior, truth


def test_the_bench_of_a_die_identified_from_its_measurements_makes_them_again(
    fitted: tuple[Path, Posterior, Bench],
) -> None:
    path, posterior, truth = fitted
    condition, table = DATA["ndp_run1"]
    clean = predicted(truth, condition, table)
    normals = standard_normals(
        Die("A", 1002), (("draw", ()),), [(("d", (24,)), (n, ())) for n in posterior.names], "x"
    )
    draws = [
        predicted(Bench(Theta(values), BASE), condition, table)
        for values in posterior.draws(normals.reshape(len(posterior.names), 24).T)
    ]
    silicon = Silicon(BASE, posterior.values()["temperature_c"], read_die_file(path))
    identified = CoachBench(silicon, identified=path)
    spread = {c: np.std([d[c] for d in draws], axis=0) for c in clean}
    noise = MODELS[condition.circuit].noise(condition, clean)
    near = np.abs(table["v1_V"] - table["v2_V"]) < 0.15
    off = {}
    for kind, bench in (("identified", identified), ("nominal", CoachBench(replace(silicon, die=NOMINAL)))):
        one = Made(path, bench, truth)
        read = one.swept("ndp_run1", "NDP", {"AIN5": "v1_V", "AIN6": "v2_V"}, PAIR, 61)
        # a reading has the noise of one, and of 3 dark counts
        scores = [
            (made - clean[c]) / np.sqrt(spread[c] ** 2 + noise[c] ** 2 + 3.0) for c, (_, made) in read.items()
        ]
        off[kind] = np.concatenate([score[near] for score in scores])
    assert np.abs(off["identified"]).max() < 3.0
    assert np.sqrt(np.mean(off["identified"] ** 2)) < 1.2
    assert np.sqrt(np.mean(off["nominal"] ** 2)) > 2.0
    assert identified.found is not None
    assert {"channel 0 Q", "channel 1 t_d", "splitter bit 4"} <= set(identified.found.identified)
    assert {"s 60 pA", "dac offset", "p.v_t0"} <= set(identified.found.nominal)


def test_a_board_of_another_process_or_die_is_refused(made: Made) -> None:
    die = read_die_file(made.path)
    with pytest.raises(
        DataError, match=r"die.toml: identified on coach-180 with n.v_t0 0.504366 V, rolls-180 has"
    ):
        CoachBench(Silicon(ROLLS_180, die=die), identified=made.path)
    with pytest.raises(
        DataError, match=r"on a die whose differential_pair.m1.v_t0 deviates by .* it is as drawn"
    ):
        CoachBench(Silicon(BASE), identified=made.path)
    other = replace(die, edits=(Edit("set", ("differential_pair.m1",), "v_t0", 1e-3), *die.edits[1:]))
    with pytest.raises(
        DataError, match=r"m1.v_t0 deviates by .*, on this one it deviates by 0.001; give the"
    ):
        CoachBench(Silicon(BASE, die=other), identified=made.path)
    with pytest.raises(ParameterError, match=r"states board and generator; leave them out"):
        CoachBench(Silicon(BASE, die=die), Board(), identified=made.path)
    for changed in (die.healed("differential_pair.m1"), die.with_("differential_pair.m1", "v_t0", 1e-3)):
        assert CoachBench(Silicon(BASE, die=changed), identified=made.path).found is not None


def test_what_was_not_found_is_nominal(tmp_path: Path) -> None:
    prior = before(unknowns_of(CONDITIONS, BASE))
    write(tmp_path / "die.toml", prior)
    silicon = Silicon(BASE, 25.0)
    bench, nominal = CoachBench(silicon, identified=tmp_path / "die.toml"), CoachBench(silicon)
    assert bench.found is not None
    assert bench.found.identified == ()
    assert bench.board == replace(nominal.board, channels=bench.board.channels)
    for one in (bench, nominal):
        one.set_bias("NDP_VB_N", "N", 30e-9, 32)
        one.set_voltage("AIN5", 0.95)
        one.set_voltage("AIN6", 0.85)
    assert abs(bench.read_counts("C2F0") / nominal.read_counts("C2F0") - 1.0) < 0.2
    with pytest.raises(DataError, match=r"plain.toml: no posterior, must be a die of noctule identify"):
        (tmp_path / "plain.toml").write_text("die = 3\n")
        CoachBench(silicon, identified=tmp_path / "plain.toml")


def test_the_identified_die_of_the_evidence_counts_as_the_real_chip() -> None:
    path = ROOT / "evidence" / "coach" / "die.toml"
    bench = CoachBench(Silicon(BASE, 27.6, read_die_file(path)), identified=path)
    condition, table = DATA["ndp_run1"]
    bench.set_bias("NDP_VB_N", "N", 30e-9, condition.biases[0].fine or 0)
    for k in (18, 24, 30, 36, 42):
        for pin, column in (("AIN5", "v1_V"), ("AIN6", "v2_V")):
            bench.set_voltage(pin, float(table[column][k]) + STEP)
        for pin, column in (("C2F0", "n1_counts"), ("C2F1", "n2_counts")):
            if table[column][k] > 300:
                # what a channel drifts from run to run, 1.5 %, twice
                assert bench.read_counts(pin) == pytest.approx(table[column][k], rel=0.04)
