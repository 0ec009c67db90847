"""Structured comments: every kind comes back exactly as it was written."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import Resistor, Source, Transistor
from circuits.devices.source import PiecewiseLinear, Pulse, Sampled
from circuits.errors import DataError
from circuits.silicon.die import CORNERS, Die
from circuits.silicon.process import AMI_1500_IDEAL, TransistorModel, Variation
from circuits.silicon.sampling import Sampling
from circuits.silicon.silicon import Deviation, Silicon
from circuits.silicon.size import FOLLOWING, SizeTerms
from circuits.testbench import Testbench
from netlists.write.annotation import (
    KINDS,
    Annotation,
    ArrayNote,
    LocalDeviation,
    ParameterNote,
    bench_note,
    circuit_notes,
    device_notes,
    format_annotation,
    instance_notes,
    parse_annotation,
    silicon_notes,
    source_notes,
    to_parameters,
    to_silicon,
    to_source,
)
from tests.refusals import refusals

NUMBERS = st.floats(allow_nan=False)
TEXTS = st.text()
NAMES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,8}", fullmatch=True)
SHAPES = st.lists(st.integers(1, 99), max_size=3).map(tuple)
INDICES = st.lists(st.integers(0, 99), max_size=3).map(tuple)
REFERENCES = st.builds(lambda n, i: f"{n}[{','.join(map(str, i))}]" if i else n, NAMES, INDICES)
PAIRS = st.lists(st.tuples(NAMES, REFERENCES), max_size=5).map(tuple)
PLACES = st.none() | st.lists(st.tuples(TEXTS, INDICES), max_size=3).map(tuple)
MANY = st.lists(NUMBERS, max_size=20).map(tuple)
SIZES = st.floats(1e-5, 1e-3)  # m, F or Ohm that anybody means
CURRENTS = st.just(0.0) | st.floats(1e-15, 1.0) | st.floats(-1.0, -1e-15)
POSITIVE = st.floats(0.0, exclude_min=True, allow_infinity=False)
FLAGS = st.booleans()
KINDS_OF_PORT = st.sampled_from(["event", "analog", "bias", "supply"])
KINDS_OF_BIAS = st.sampled_from(["gate", "ideal", "voltage"])
POLARITIES = st.sampled_from(["n", "p"])
FOUR = st.tuples(*(st.floats(-1e3, 1e3) for _ in range(4)))
TERMS = st.builds(
    SizeTerms, *(st.just(side) for side in (1e-6, 2e-6, 1e-6, 3e-6)), **dict.fromkeys(FOLLOWING, FOUR)
)
MODELS = st.builds(
    TransistorModel,
    **{f.name: NUMBERS for f in fields(TransistorModel) if f.name not in {"law", "size"}},
    law=st.sampled_from(["ekv", "ekv-gamma"]),
    size=st.none() | TERMS,
)
FIELDS: dict[str, tuple[st.SearchStrategy[Any], ...]] = {
    "noctule": (st.integers(), TEXTS, TEXTS),
    "process": (TEXTS, NUMBERS, NUMBERS, NUMBERS, NUMBERS),
    "variation": (NUMBERS, NUMBERS),
    "components": (
        *(SIZES for _ in range(6)), *(st.floats(0.0, 0.5) for _ in range(2)),
        *(st.floats(-1.0, 1.0) for _ in range(2)),
    ),
    "diodes": (SIZES, SIZES),
    "silicon": (NUMBERS, PLACES),
    "die": (
        TEXTS, st.none() | st.integers(0, 2**63 - 1), st.sampled_from(CORNERS), FLAGS, FLAGS
    ),
    "plan": (TEXTS, st.lists(st.tuples(TEXTS, NUMBERS)).map(tuple)),
    "circuit": (TEXTS,),
    "port": (
        NAMES, KINDS_OF_PORT, st.sampled_from(["in", "out"]), SHAPES
    ),
    "node": (NAMES, SHAPES),
    "bias": (
        NAMES, NAMES, KINDS_OF_BIAS, CURRENTS | st.lists(CURRENTS, max_size=20).map(tuple),
        st.none() | NAMES, NUMBERS, PLACES,
    ),
    "transistor": (
        NAMES, POLARITIES, REFERENCES, REFERENCES, REFERENCES, REFERENCES, SIZES, SIZES, POSITIVE
    ),
    "amplifier": (
        NAMES, *(REFERENCES for _ in range(5)), POSITIVE, SIZES, SIZES
    ),
    "diode": (NAMES, REFERENCES, REFERENCES, POSITIVE),
    "deviation": (NUMBERS, NUMBERS),
    "change": (NUMBERS,),
    "instance": (NAMES, PAIRS),
    "array": (NAMES, SHAPES, PAIRS),
    "parameter": (TEXTS, MANY, NUMBERS, SHAPES),
    "testbench": (
        TEXTS, NUMBERS, st.lists(REFERENCES).map(tuple),
        st.lists(st.tuples(TEXTS, NUMBERS)).map(tuple),
    ),
    "source": (TEXTS, REFERENCES, st.sampled_from(["voltage", "current"])),
    "constant": (NUMBERS,),
    "pulse": (NUMBERS, NUMBERS, MANY, NUMBERS, NUMBERS, NUMBERS),
    "polyline": (MANY, MANY),
    "sampled": (NUMBERS, NUMBERS, MANY.map(np.array)),
    "driven": (NUMBERS,),
    "biased": (REFERENCES,),
    "parasitic": (NAMES,),
    "capacitor": (NAMES, REFERENCES, REFERENCES, SIZES),
    "resistor": (NAMES, REFERENCES, REFERENCES, SIZES),
    "transconductor": (
        NAMES, *(REFERENCES for _ in range(4)), st.floats(-1e300, 1e300)
    ),
}  # fmt: skip
VALUES = {kind: st.builds(KINDS[kind], *fields) for kind, fields in FIELDS.items()}
VALUES |= dict.fromkeys(("nmos", "pmos"), MODELS)


def read(lines: list[str], comment: str = "*") -> Annotation:
    assert lines[0].startswith(f"{comment}% ")
    assert all(line.startswith(f"{comment}%+ ") for line in lines[1:])
    return parse_annotation(" ".join(line.removeprefix(comment)[2:].lstrip() for line in lines))


def test_every_kind_has_an_example() -> None:
    assert set(VALUES) == set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_written_is_read_back(kind: str) -> None:
    @given(VALUES[kind])
    def round_trip(value: object) -> None:
        lines = format_annotation(Annotation(kind, value))
        assert all(line.isascii() and line.isprintable() for line in lines)
        found = read(lines)
        assert found.kind == kind
        if isinstance(value, Sampled):
            assert (found.value.start, found.value.rate) == (value.start, value.rate)
            np.testing.assert_array_equal(found.value.value, value.value)
        else:
            assert found.value == value

    round_trip()


def test_long_notes_are_continued_and_defaults_left_out() -> None:
    wave = PiecewiseLinear(tuple(k / 3.0 for k in range(100)), (0.0,) * 100)
    lines = format_annotation(Annotation("polyline", wave), "//")
    assert len(lines) > 20
    assert max(map(len, lines)) <= 110
    assert read(lines, "//").value == wave
    assert format_annotation(Annotation("port", Port("a", "analog"))) == ["*% port name=a kind=analog"]


def test_a_title_cannot_end_its_line() -> None:
    (line,) = format_annotation(bench_note(Testbench("a )\n.op  $", Circuit("c"), (), 1.0)))
    assert line == r'*% testbench title="a\u0020)\n.op\u0020\u0020$" stop=1.0'


@pytest.mark.parametrize(
    "silicon",
    [
        Silicon(AMI_1500_IDEAL),
        Silicon(AMI_1500_IDEAL, temperature_c=-20.0, die=Die("B", 1003, "ss", mismatch=False)),
        Silicon(AMI_1500_IDEAL, place=(("chip", ()), ("neuron", (2,)), ("bias copy", ()))),
        Silicon(replace(AMI_1500_IDEAL, n=TransistorModel(0.5, 0.6, 1e-4, "ekv-gamma"))),
        Silicon(replace(AMI_1500_IDEAL, variation=Variation(0.1, 0.2))),
        Silicon(AMI_1500_IDEAL, die=Die("B", 1003, variation="full")),
        Silicon(AMI_1500_IDEAL, die=Die("B", 3).only("a[2,3]", "b.*").healed("b.m1").with_("c", "beta", 0.1)),
        Silicon(replace(AMI_1500_IDEAL, components=None)),
    ],
    ids=["nominal", "die", "place", "process", "variation", "components", "edited", "none stated"],
)  # fmt: skip
def test_silicon_comes_back(silicon: Silicon) -> None:
    assert to_silicon(read(format_annotation(note)) for note in silicon_notes(silicon)) == silicon


def test_a_die_of_a_plan_has_its_draws() -> None:
    columns = {"process.n.shared.v_t0": 1, "c.m.v_t0": 0}
    plan = Sampling("lhs", 5, columns, np.array([[0.0, 0.0], [1.5, -2.0], [9.0, 9.0]]))
    silicon = Silicon(AMI_1500_IDEAL, die=Die("A", 6, sampling=plan))
    found = to_silicon(read(format_annotation(note)) for note in silicon_notes(silicon))
    assert found.law("n") == silicon.law("n")
    assert found.law("n") != Silicon(AMI_1500_IDEAL, die=Die("A", 6)).law("n")
    assert found.deviation("c", (("m", ()),), 1e-11) == silicon.deviation("c", (("m", ()),), 1e-11)
    assert str(found.die) == str(silicon.die)


def test_silicon_without_a_part_is_refused() -> None:
    with pytest.raises(DataError, match="note die: missing"):
        to_silicon(silicon_notes(Silicon(AMI_1500_IDEAL))[:-1])


def test_a_circuit_has_ports_nodes_and_biases() -> None:
    bias = Bias("v_ref", "v_ref", "voltage", (1.0, 2.0))
    ports = (Port("v_ref", "bias", "in", (2,)),)
    circuit = Circuit("c", ports, (), (), (Node("mid", (2, 3)),), (bias,))
    notes = [read(format_annotation(note)) for note in circuit_notes(circuit)]
    assert [note.kind for note in notes] == ["circuit", "port", "node", "bias"]
    assert [note.value for note in notes[1:]] == [*ports, *circuit.nodes, bias]


def test_instances_say_what_their_parameters_replace() -> None:
    part = Circuit("part", (Port("a", "analog"),), (Resistor("r", "a", "0", 1e3),))
    outer = Circuit("outer", (Port("a", "analog"),), (), (Instance("one", part, {"a": "a"}),))
    values = {"one.r.resistance": np.array([[1.0, 2.0, 3.0]] * 2)}
    head, parameter = instance_notes(InstanceArray("rows", outer, (2, 3), {"a": "x"}, values))
    assert head.value == ArrayNote("rows", (2, 3), (("a", "x"),))
    assert parameter.value == ParameterNote("one.r.resistance", (1.0, 2.0, 3.0) * 2, 1e3, (2, 3))
    assert to_parameters([parameter.value]) == {"one.r.resistance": ((1.0, 2.0, 3.0), (1.0, 2.0, 3.0))}
    head, parameter = instance_notes(Instance("one", part, {"a": "x"}, {"r.resistance": 5.0}))
    assert head.kind == "instance"
    assert to_parameters([parameter.value]) == {"r.resistance": 5.0}
    with pytest.raises(DataError, match="2 numbers, must fill the shape"):
        to_parameters([ParameterNote("r", (1.0, 2.0), 1.0, (3,))])
    with pytest.raises(DataError, match="must be one without a shape"):
        to_parameters([ParameterNote("r", (1.0, 2.0), 1.0)])


def test_only_devices_whose_lines_say_less_have_notes() -> None:
    device = Transistor("m", "n", "d", "g", "s", "0", 1e-6, 2e-6)
    assert device_notes(Resistor("r", "a", "b", 1.0), Deviation(0.0, 0.0)) == []
    assert device_notes(device, Deviation(0.0, 0.0)) == [("transistor", device)]
    assert device_notes(device, Deviation(0.0, -0.1)) == [
        ("deviation", LocalDeviation(0.0, -0.1)),
        ("transistor", device),
    ]


def test_sources_come_back() -> None:
    source = Source("odd name!", "a[2]", Pulse(0.0, 5e-9, (1e-3, 2e-3), 1e-5, 1e-7, 1e-7), "current")
    head, waveform = (read(format_annotation(note)) for note in source_notes(source))
    assert to_source(head.value, waveform.value) == source


test_malformed_notes_are_refused_by_name = refusals(
    DataError,
    parse_annotation,
    [
        ("", "note '': unknown kind"),
        ("memristor name=a", "note 'memristor': unknown kind"),
        ("constant value=1.0 offset=2.0", "note constant.offset: no such field"),
        ("constant", "note constant.value: missing"),
        ("constant value=1.0 value=2.0", "each once"),
        ("constant 1.0", "must be a field key=value"),
        ("constant value=five", "note constant.value: 'five', no value of its kind"),
        ("constant value=( 1.0 )", "note constant.value"),
        ("polyline time=( 0.0 1.0 value=( 0.0 1.0", "note polyline.time: no \\) at its end"),
        ("polyline time=0.0 value=1.0", "note polyline.time"),
        ("port name=a kind=optical", "note port.kind: 'optical', no value"),
        ('port name="a kind=analog', "note port.name"),
        ("port name=a kind=analog shape=-1", "note port.shape"),
        ("port name=a kind=analog shape=" + ",".join("1" * 17), "note port.shape"),
        ("die lot=A mismatch=maybe", "note die.mismatch"),
    ],
)
