"""What we write comes back: every block, in every dialect, with the models that it has."""

from __future__ import annotations

import functools
import re
from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.diode import Diode
from circuits.devices.source import Constant, Driven, PiecewiseLinear, Pulse, Sampled
from circuits.errors import DataError
from circuits.lowering.flatten import flatten
from circuits.lowering.kernel import to_kernel
from circuits.lowering.made import change_of, kind_of
from circuits.registry import BLOCKS, load_block
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500_IDEAL, DiodeVariation
from circuits.silicon.sampling import Sampling
from circuits.silicon.silicon import Change, Silicon
from circuits.testbench import Begin, Testbench
from netlists.compare.circuits import compare
from netlists.read import Imported, read_netlist
from netlists.read.analysis import Transient
from netlists.registry import DIALECTS, Settings, load_dialect
from tests.chips.whole import WHOLE_CHIPS
from tests.refusals import refusals

UM = 1e-6
NOMINAL_SILICON = Silicon(AMI_1500_IDEAL)
DEFAULT = Settings()
DIE = Silicon(AMI_1500_IDEAL, temperature_c=40.0, die=Die(number=1003))
# Arrays as short as they can be with an index of two digits: texts of the whole chips take seconds.
FEWER = {"wavefront-chip": {"rows": 2, "columns": 11}, "latency-chip": {"paths": 11, "taps": 2}}
WRITTEN = [(name, models) for name in DIALECTS for models in load_dialect(name).devices]


@functools.cache
def bench_of(name: str) -> Testbench:
    block = WHOLE_CHIPS.get(name) or load_block(name)
    return block.bench(block.build(block.params(**FEWER.get(name, {}))))


def write(
    bench: Testbench,
    silicon: Silicon = NOMINAL_SILICON,
    dialect: str = "ngspice",
    settings: Settings = DEFAULT,
) -> str:
    return load_dialect(dialect).write(bench, silicon, settings)


def require_same(found: Testbench, expected: Testbench) -> None:
    """Equal as dataclasses; samples, which are compared by identity, by their values."""
    for a, b in zip(found.sources, expected.sources, strict=True):
        if isinstance(a.waveform, Sampled) and isinstance(b.waveform, Sampled):
            assert (a.waveform.start, a.waveform.rate) == (b.waveform.start, b.waveform.rate)
            np.testing.assert_array_equal(a.waveform.value, b.waveform.value)
            assert replace(a, waveform=b.waveform) == b
        else:
            assert a == b
    assert replace(found, sources=()) == replace(expected, sources=())


def everything() -> Testbench:
    """Each thing that a note can say, and names that dialects keep for themselves."""
    cell = Circuit(
        "Cell",
        (
            Port("vdd", "supply"),
            Port("a_", "analog"),
            Port("out", "event", "out", (2,), threshold=0.75),
            Port("v_tau", "bias"),
        ),
        (
            Transistor("m1", "n", "out[0]", "v_tau", "0", "0", 3 * UM, 2 * UM),
            Transistor("m_2", "p", "out[1]", "a_", "vdd", "vdd", 6 * UM, 2 * UM, 3.0),
            Transistor("m3", "n", "vdd", "out[1]", "time", "0", 3 * UM, 2 * UM),
            Capacitor("c_", "time", "0", 1.25e-13),
            Capacitor("c__x", "w[1,2]", "0", 1e-13, ic=-0.25),
            Resistor("r1", "w[1,2]", "vdd", 1.0 / 3.0 * 1e7),
            ControlledSource("g1", "w[0,0]", "0", "a_", "vdd", -1e-9),
            Resistor("r2", "w[0,0]", "temp", 1e9),
            Resistor("r3", "temp", "0", 1e9),
            OperationalAmplifier("A", "a_", "out[0]", "out[0]", "vdd", gain=1e3, offset=-1e-3),
        ),
        nodes=(Node("w", (2, 3)),),
        biases=(Bias("i_tau", "v_tau", "gate", 1e-10, "m1"),),
    )
    ports = cell.wired()
    chip = Circuit(
        "chip",
        (
            Port("vdd", "supply"),
            Port("a_", "analog", "in", (3,)),
            Port("v_tau", "bias", "in", (3,)),
            Port("V_ref", "bias"),
            Port("v_gen", "bias"),
        ),
        (Resistor("r_ref", "V_ref", "v_gen", 1e9),),
        (
            InstanceArray(
                "cells",
                cell,
                (3,),
                {**ports, "out": "o"},
                {"m1.width": (3e-6, 4e-6, 5e-6), "c_.capacitance": 2e-13},
            ),
            Instance(
                "lone",
                cell,
                {**ports, "a_": "a_[1]", "out": "p", "v_tau": "v_tau[0]"},
                {"m_2.multiplicity": 2.0},
            ),
        ),
        (Node("o", (3, 2)), Node("p", (2,))),
        (
            Bias(
                "i_tau",
                "v_tau",
                "ideal",
                (1e-10, 2e-10, 3e-10),
                "cells.m1",
                30.0,
                (("chip", ()), ("lone", ())),
            ),
            Bias("v_ref", "V_ref", "voltage", 1.5),
            Bias("i_gen", "v_gen", "gate", 1e-9, "lone.m1"),
        ),
    )
    sources = (
        Source("vdd", "vdd", Constant(5.0)),
        Source("a 0", "a_[0]", Pulse(0.0, 5.0, (1e-6, 1e-3), 1e-5, 1e-9, 2e-9)),
        Source("a[1]", "a_[1]", PiecewiseLinear((-1.0, 0.5, 1.0), (0.0, 1.0, 2.0))),
        Source("a2", "a_[2]", Sampled(0.0, 1e4, np.array([0.0, 0.1, 1.0 / 3.0])), "current"),
        Source("ref", "V_ref", Driven(1.25)),
    )
    start = {"cells[1].time": 0.5, "cells[2].w[1,2]": 4.5, "p[0]": 0.1}
    held = {"cells[2].time": 0.75, "o[1,1]": 2.5}
    return Testbench("a title; with = (all) sorts", chip, sources, 2e-3, ("lone.out[0]",), start, held)


@pytest.mark.parametrize("name", [*BLOCKS, *WHOLE_CHIPS])
@pytest.mark.parametrize(("dialect", "models"), WRITTEN)
def test_a_block_comes_back(name: str, dialect: str, models: str) -> None:
    bench = bench_of(name)
    found = read_netlist(write(bench, dialect=dialect, settings=Settings(models=models)))
    require_same(found.testbench, bench)
    assert (found.dialect, found.models, found.silicon, found.deviations) == (
        dialect,
        models,
        Silicon(AMI_1500_IDEAL),
        {},
    )


@pytest.mark.parametrize(("dialect", "models"), WRITTEN)
def test_everything_that_notes_can_say_comes_back(dialect: str, models: str) -> None:
    for silicon in (Silicon(AMI_1500_IDEAL), DIE):
        found = read_netlist(write(everything(), silicon, dialect, Settings(models=models)))
        require_same(found.testbench, everything())
        assert found.silicon == (replace(silicon, die=NOMINAL) if dialect == "cdl" else silicon)


@pytest.mark.parametrize("begin", ["at_rest", "uic"])
@pytest.mark.parametrize(("dialect", "models"), WRITTEN)
def test_where_a_run_begins_comes_back(dialect: str, models: str, begin: Begin) -> None:
    bench = replace(everything(), begin=begin)
    found = read_netlist(write(bench, dialect=dialect, settings=Settings(models=models)))
    require_same(found.testbench, bench)
    if dialect not in {"cdl", "verilog-a"}:  # which have no run
        (run,) = found.analyses
        assert isinstance(run, Transient)
        assert run.uic == (begin == "uic")


@pytest.mark.parametrize("dialect", sorted({*DIALECTS} - {"cdl"}))
def test_the_deviations_of_a_die_come_back(dialect: str) -> None:
    bench = everything()
    found = read_netlist(write(bench, DIE, dialect))
    flat = flatten(bench.circuit)
    expected = {}
    for group in flat.groups:
        if isinstance(group.device, Transistor):
            size = group.parameters
            area = size["width"] * size["length"] * size["multiplicity"]
            shift = DIE.deviation("chip", (*group.path, (group.device.name, ())), area)
            for k in range(area.size):
                expected[group.label(k)] = tuple(float(np.ravel(x)[k]) for x in shift)
    assert found.deviations == expected


@pytest.mark.parametrize("dialect", sorted({*DIALECTS} - {"cdl"}))
def test_what_a_die_changes_of_capacitors_and_resistors_comes_back(dialect: str) -> None:
    bench, silicon = everything(), replace(DIE, die=replace(DIE.die, variation="full"))
    text = write(bench, silicon, dialect)
    found = read_netlist(text)
    require_same(found.testbench, bench)
    assert found.silicon == silicon
    flat = flatten(bench.circuit)
    changed = {
        group.label(k): Change(float(change_of(group, kind, "chip", silicon).value[k]))  # type: ignore[index]
        for group in flat.groups
        if (kind := kind_of(group.device)) is not None
        for k in range(group.nodes.shape[1])
    }
    assert {path: d for path, d in found.deviations.items() if isinstance(d, Change)} == changed
    assert len({change.value for change in changed.values()}) > 2
    assert write(found.testbench, found.silicon, dialect) == text


def test_diodes_of_a_die_come_back_and_are_written_as_made() -> None:
    cell = Circuit(
        "cell",
        (Port("a", "analog"),),
        (Diode("d", "a", "x", area=2.0, saturation_current=1e-15), Resistor("r", "x", "0", 1e6)),
    )
    both = InstanceArray("both", cell, (2,), {"a": "a"})
    circuit = Circuit("rows", (Port("a", "supply"),), (), (both,))
    bench = Testbench("rows", circuit, (Source("v", "a", Constant(1.0)),), 1e-6)
    silicon = Silicon(replace(AMI_1500_IDEAL, diodes=DiodeVariation(0.05, 0.1)), die=Die(number=1003))
    made = to_kernel(bench, silicon).kernel.diodes.saturation / 2.0
    for dialect in sorted({*DIALECTS} - {"cdl"}):
        text = write(bench, silicon, dialect)
        found = read_netlist(text)
        require_same(found.testbench, bench)
        assert found.silicon == silicon
        changes = [change.value for change in found.deviations.values()]
        np.testing.assert_allclose(np.array(changes), made / 1e-15 - 1.0, rtol=1e-9)
        word = r"saturation_current\(" if dialect == "verilog-a" else r"\bis="
        lines = [line for line in text.splitlines() if not line.startswith(("*%", "//%"))]
        written = [float(x) for x in re.findall(rf"{word}([-0-9.e]+)", "\n".join(lines))]
        np.testing.assert_allclose(written, made, rtol=1e-12)
    bare = read_netlist(write(bench, silicon).replace("*%", "*"), dialect="ngspice")
    deviations = read_netlist(write(bench, silicon)).deviations
    assert compare(bench.circuit, bare.circuit, deviations=(deviations, {})).equal
    assert not compare(bench.circuit, bare.circuit).equal


def test_a_changed_value_is_the_same_without_notes() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1003, mismatch=False, variation="full"))
    deck = write(bench_of("rebound-neuron"), silicon, settings=Settings(models="bsim3"))
    noted = read_netlist(deck)
    bare = read_netlist(deck.replace("*%", "*"), dialect="ngspice", drop=[".model"])
    changes = {path: d for path, d in noted.deviations.items() if isinstance(d, Change)}
    assert changes
    assert compare(noted.circuit, bare.circuit, deviations=(changes, {})).equal
    assert not compare(noted.circuit, bare.circuit).equal  # drawn, not made


def test_decks_of_a_die_are_equal_and_of_different_dies_are_not() -> None:
    bench = bench_of("rebound-neuron")

    def read(number: int, dialect: str) -> Imported:
        return read_netlist(write(bench, Silicon(AMI_1500_IDEAL, die=Die(number=number)), dialect))

    a, b, other = read(1003, "ngspice"), read(1003, "spectre"), read(1004, "ngspice")
    assert compare(a.circuit, b.circuit, deviations=(a.deviations, b.deviations)).equal
    found = compare(a.circuit, other.circuit, deviations=(a.deviations, other.deviations))
    assert {d.kind for d in found.differences} == {"size"}
    assert len(found.differences) == 10


@pytest.mark.parametrize("dialect", DIALECTS)
def test_parasitics_come_back_and_are_no_part_of_the_circuit(dialect: str) -> None:
    bench = everything()
    parasitics = {"cells[1].time": 1e-15, "lone.w[1,2]": 3e-15, "v_gen": 2e-15}
    found = read_netlist(write(bench, dialect=dialect, settings=Settings(parasitics=parasitics)))
    require_same(found.testbench, bench)
    assert found.parasitics == parasitics


def test_options_and_run_may_be_edited() -> None:
    deck = write(bench_of("vocalization-controller"))
    deck = deck.replace("reltol=1e-05", "reltol=1e-4").replace("\n.save ", "\n.print tran ")
    require_same(read_netlist(deck).testbench, bench_of("vocalization-controller"))


def test_plain_devices_may_be_edited_and_added() -> None:
    deck = write(bench_of("vocalization-controller"))
    match = re.search(r"\ncc_in (\S+) (\S+) (\S+)\n", deck) or re.search(r"\ncc\w+ (\S+) (\S+) (\S+)\n", deck)
    assert match is not None
    line = match.group()
    found = read_netlist(deck.replace(line, line.rsplit(" ", 1)[0] + " 2pF\nrnew vdd 0 1meg\n"))
    devices = found.circuit.devices
    assert Resistor("new", "vdd", "0", 1e6) in devices
    assert any(isinstance(d, Capacitor) and d.capacitance == 2e-12 for d in devices)


def test_the_last_digits_may_differ() -> None:
    deck = write(bench_of("vocalization-controller"))
    match = re.search(r"i=(\d\.\d{10})(\d+)e", deck)
    assert match is not None
    found = read_netlist(deck.replace(match.group(), f"i={match.group(1)}0e", 1))
    require_same(found.testbench, bench_of("vocalization-controller"))


def edited(old: str, new: str) -> str:
    deck = write(everything())
    assert old in deck
    return deck.replace(old, new, 1)


test_a_line_that_is_not_what_its_note_says_is_refused = refusals(
    DataError,
    lambda changed: read_netlist(edited(*changed)),
    [
        (("\nbm1 ", "\nbm1x "), "bm1x: edited, bm1x .* is bm1 .* by its notes"),
        (("^2-", "^3-"), "edited"),
        (("width=3e-06", "width=4e-06"), "edited"),
        (("\ncm1#gb ", "\n* "), "edited"),
        (("\n.ends Cell\n", "\nr9 vdd 0 1\n.ends Cell\n"), "edited|missing"),
        (("\nxlone ", "\nrnew vdd 0 1\nxlone "), "edited|missing"),
        (("\n.ends chip\n", "\n.ends chip\nrnew vdd 0 1\n"), "edited"),
        ((" 0.002 0 1e-06\n", " 0.003 0 1e-06\n"), r"\.tran: stops at 0.003 s"),
        ((" 0.002 0 1e-06\n", " 0.002 0 1e-06 uic\n"), "uic of .tran: True, by the testbench note disturbed"),
        (("=0.75 ", "=0.85 "), "edited"),
        ((" ic=-0.25", ""), "edited|missing"),
        (("temp=27.0", "temp=60.0"), "60 degC, by the silicon note 27 degC"),
        (("dialect=ngspice", "dialect=other"), "dialect other: unknown"),
        (("models=ekv", "models=level1"), "cannot be written again"),
        (("*% testbench", "*% test"), "unknown kind"),
        (("silicon temperature_c=27.0", "silicon temperature_c=1000.0"), "must be within -40 to 125"),
        (("kappa=0.7", "kappa=0.0"), "cannot be written again"),
        (("polarity=n", "polarity=x"), "no value of its kind"),
        (("*% array name=cells shape=3", "*% array name=cells shape=4"), "3 calls after its note, must be 4"),
        (("cells shape=3", "cells shape=1000000,1000000"), "calls after its note"),
        (("c_.capacitance", "c_.resistance"), "unknown"),
        (("\n.ends chip\n", "\n"), "not closed|another"),
    ],
    start=r"^netlist:\d+: .*",
)


@pytest.mark.parametrize(("dialect", "models"), [("cdl", "ekv"), ("ngspice", "bsim3"), ("hspice", "bsim3")])
def test_transistors_as_m_elements_are_the_same_circuit_without_notes(dialect: str, models: str) -> None:
    deck = write(bench_of("rebound-neuron"), dialect=dialect, settings=Settings(models=models))
    with_notes = read_netlist(deck)
    without = read_netlist(deck.replace("*%", "*"), dialect=dialect, drop=[".model"])
    found = compare(with_notes.circuit, without.circuit)
    assert found.equal, found.differences
    assert without.silicon is None


def test_without_its_header_the_deck_is_read_as_it_stands() -> None:
    deck = write(bench_of("vocalization-controller"))
    with pytest.raises(DataError, match="supported is I= linear"):  # an EKV current
        read_netlist(deck.replace("*% noctule", "* noctule"))


def planned(number: int = 1005) -> Silicon:
    """A die of a sampling plan that sets three draws of a chip, and leaves the others to the die."""
    columns = {
        "ranging_chip.neuron[3].membrane.m1.v_t0": 0,
        "ranging_chip.neuron[12].axon.ma7.beta": 1,
        "process.p.shared.v_t0": 2,
    }
    rows = np.array([[0.1, 0.2, 0.3], [2.5, -1.75, 1.0 / 3.0]])
    return Silicon(AMI_1500_IDEAL, die=Die("B", number, sampling=Sampling("lhs/7", 1004, columns, rows)))


@pytest.mark.parametrize(("dialect", "models"), [w for w in WRITTEN if w[0] != "cdl"])
def test_a_die_of_a_sampling_plan_comes_back_with_its_draws(dialect: str, models: str) -> None:
    silicon, bench = planned(), bench_of("ranging-chip")
    found = read_netlist(write(bench, silicon, dialect, Settings(models=models)))
    assert found.silicon is not None
    assert str(found.silicon.die) == str(silicon.die) == "die B/1005 plan lhs/7"
    for part, device in (("membrane", "m1"), ("axon", "ma7")):
        path = (("neuron", (13,)), (part, ()), (device, ()))
        for drawn, expected in zip(
            found.silicon.deviations("ranging_chip", [path], 18e-12),
            silicon.deviations("ranging_chip", [path], 18e-12),
            strict=True,
        ):
            np.testing.assert_array_equal(drawn, expected)
    own = Silicon(AMI_1500_IDEAL, die=Die("B", 1005))
    assert found.silicon.law("p").v_t0 == silicon.law("p").v_t0 != own.law("p").v_t0
    assert found.silicon.law("n") == own.law("n")
    assert compare(found.circuit, bench.circuit).equal


def test_dies_of_a_plan_are_equal_in_two_dialects_and_no_others() -> None:
    bench = bench_of("ranging-chip")
    decks = [
        read_netlist(write(bench, silicon, dialect))
        for silicon, dialect in (
            (planned(), "ngspice"),
            (planned(), "spectre"),
            (Silicon(AMI_1500_IDEAL, die=Die("B", 1005)), "ngspice"),
        )
    ]
    first, again, own = ((deck.circuit, deck.deviations) for deck in decks)
    assert compare(first[0], again[0], deviations=(first[1], again[1])).equal
    found = compare(first[0], own[0], deviations=(first[1], own[1]), most=1000)
    assert {d.path.partition(".")[0] for d in found.differences} == {"neuron[3]", "neuron[12]"}
    assert {d.path.rpartition(".")[2] for d in found.differences} == {"m1", "ma7"}


def test_a_draw_that_was_edited_is_refused() -> None:
    deck = write(bench_of("ranging-chip"), planned())
    old = "neuron[3].membrane.m1.v_t0:2.5"
    assert deck.count(old) == 1
    with pytest.raises(DataError, match="edited"):
        read_netlist(deck.replace(old, "neuron[3].membrane.m1.v_t0:2.4"))
