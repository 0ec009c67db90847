"""Cards about a run."""

import pytest

from circuits.errors import DataError
from netlists.read.analysis import (
    Controls,
    NoiseSpectrum,
    OperatingPoint,
    SmallSignals,
    Sweep,
    Transient,
    read_controls,
)
from netlists.read.card import Card
from netlists.read.expression.scope import Scope
from netlists.read.limits import Limits
from netlists.read.note import Notes
from netlists.read.waveform import Span
from tests.refusals import refusals


def read(*texts: str, notes: Notes | None = None) -> Controls:
    cards = [Card(text, "a.cir", k) for k, text in enumerate(texts, 1)]
    return read_controls(cards, Scope(Limits()), Notes() if notes is None else notes)


def test_analyses() -> None:
    controls = read(".TRAN 1u 2m 0 10u UIC", ".op", ".dc v1 0 5 0.1 i2 0 1n 0.1n", ".tran 1n 1u")
    assert controls.analyses == [
        Transient(1e-6, 2e-3, 0.0, 1e-5, uic=True),
        OperatingPoint(),
        Sweep(("v1", "i2"), (0.0, 0.0), (5.0, 1e-9), (0.1, 1e-10)),
        Transient(1e-9, 1e-6),
    ]
    assert controls.span == Span(1e-6, 2e-3)
    assert controls.uic
    assert not read(".tran 1n 1u", ".tran 1n 1u uic").uic
    assert read(".op").span == Span()


def test_steps_of_sources_and_temperature() -> None:
    controls = read(
        ".step temp -20 80 50", ".step lin v1 1 0 -0.5", ".step dec i1 1n 1u 1", ".step v2 list 3 1"
    )
    assert [(s.name, s.place) for s in controls.steps] == [
        ("temp", "a.cir:1"), ("v1", "a.cir:2"), ("i1", "a.cir:3"), ("v2", "a.cir:4")
    ]  # fmt: skip
    assert [s.values for s in controls.steps[::3]] == [(-20.0, 30.0, 80.0), (3.0, 1.0)]
    assert controls.steps[1].values == (1.0, 0.5, 0.0)
    assert controls.steps[2].values == pytest.approx((1e-9, 1e-8, 1e-7, 1e-6))


def test_steps_of_parameters() -> None:
    controls = read(".step param r 1k 3k 1k", ".step dec param C 1p 100p 1", ".step param n list 2 1 2")
    assert [(s.name, s.is_parameter) for s in controls.steps] == [("r", True), ("c", True), ("n", True)]
    assert [s.values for s in controls.steps[::2]] == [(1e3, 2e3, 3e3), (2.0, 1.0)]
    assert controls.steps[1].values == pytest.approx((1e-12, 1e-11, 1e-10))
    for card in (".step r1 1 2 1", ".step dm(is) list 1f 2f"):
        with pytest.raises(DataError, match=r"^a.cir:1: \.step of a device or a model"):
            read(card)


@pytest.mark.parametrize(
    "card", [".step v1 0 5 -1", ".step dec v1 0 5 10", ".step v1 0 1", ".step v1 0 1 1e-9"]
)
def test_steps_that_lead_nowhere_are_refused(card: str) -> None:
    with pytest.raises(DataError, match=r"^a.cir:1: \.step: "):
        read(card)


def test_starts_and_temperature() -> None:
    controls = read(".nodeset v(a)=1 V( x1.b ) = {2*2}", ".ic v(c)=5m", ".options temp=60 reltol=1e-4")
    assert {node: value for node, (value, _) in controls.starts.items()} == {"a": 1.0, "x1.b": 4.0}
    assert {node: value for node, (value, _) in controls.held.items()} == {"c": 5e-3}
    assert controls.temperature_c == 60.0
    assert read(".temp -20").temperature_c == -20.0


def test_what_is_not_taken_over_is_noted() -> None:
    notes = Notes()
    read(".save v(a)", ".save v(b)", ".tf v(a) v1", ".options gmin=1e-15", notes=notes)
    assert {note.what.split(",")[0]: note.count for note in notes.all()} == {
        ".save card": 2,
        ".tf analysis": 1,
        "option gmin": 1,
    }


def test_small_signals_noise_and_measures() -> None:
    controls = read(
        ".ac dec 10 1 1k",
        ".noise v(out, b) vin lin 5 1k 2k",
        ".meas tran t_rise TRIG v(a) VAL=1 RISE=1 TARG v(b) VAL=2 RISE=1",
    )
    assert controls.analyses == [
        SmallSignals("dec", 10, 1.0, 1e3),
        NoiseSpectrum("out", "b", "vin", SmallSignals("lin", 5, 1e3, 2e3)),
    ]
    (found,) = controls.measures
    assert found.analysis == "tran"
    assert found.text.startswith("t_rise = cross(")


test_refused_with_its_place = refusals(
    DataError,
    read,
    [
        (".wave a", ".wave: unknown card"),
        (".tran 1u", "must be 2 to 4"),
        (".tran 1u 0", "must be > 0"),
        (".tran 1u 1e999", "must be finite"),
        (".dc v1 0 1", "must be 4 or 8"),
        (".ic a=1", "must be v"),
        (".nodeset v(a)=", "must be v"),
        (".temp", "must be one"),
        (".ac 10 1 1k", "must be dec, oct or lin"),
        (".ac dec 10 1k 1", "of rising ends"),
        (".noise v(a) vin dec 10", "must be v"),
    ],
    start=r"^a\.cir:1: .*",
)
