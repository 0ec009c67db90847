"""Source cards to waveforms."""

import numpy as np
import pytest

from circuits.devices.source import Constant, PiecewiseLinear, Pulse, Sampled, Waveform
from circuits.errors import DataError
from netlists.read.card import Card
from netlists.read.expression.scope import Scope
from netlists.read.limits import Limits
from netlists.read.note import Notes
from netlists.read.waveform import Span, negated, read_waveform
from tests.refusals import refusals

SPAN = Span(1e-6, 1e-3)


def read(text: str, span: Span = SPAN, notes: Notes | None = None) -> Waveform:
    card = Card(f"v1 a 0 {text}", "a.cir", 5)
    scope = Scope(Limits(), values={"high": 5.0})
    return read_waveform(card, card.words()[3:], scope, span, Notes() if notes is None else notes).waveform


@pytest.mark.parametrize(
    ("text", "waveform"),
    [
        ("5", Constant(5.0)),
        ("dc 2.5m", Constant(2.5e-3)),
        ("dc={high/2}", Constant(2.5)),
        ("pwl(0 0 1u 5 2u 0)", PiecewiseLinear((0.0, 1e-6, 2e-6), (0.0, 5.0, 0.0))),
        ("pulse(0 5 1u 1n 2n 3u)", Pulse(0.0, 5.0, (1e-6,), 3e-6, 1e-9, 2e-9)),
        (
            "PULSE 0 high 1u 1n 1n 3u 0.4m",
            Pulse(0.0, 5.0, (1e-6, 1e-6 + 4e-4, 1e-6 + 8e-4), 3e-6, 1e-9, 1e-9),
        ),
        ("pulse(0 5 0 1n 1n 1u 10u 2)", Pulse(0.0, 5.0, (0.0, 1e-5), 1e-6, 1e-9, 1e-9)),
        ("pulse(0 5)", Pulse(0.0, 5.0, (0.0,), 1e-3, 1e-6, 1e-6)),
    ],
)
def test_waveform(text: str, waveform: Waveform) -> None:
    assert read(text) == waveform


def test_a_sine_is_sampled_and_noted() -> None:
    notes = Notes()
    sine = read("sin(2 1 10k 0.1m 0 90)", notes=notes)
    assert isinstance(sine, Sampled)
    assert (sine.start, sine.rate) == (1e-4, 2e6)
    assert sine.value[0] == 3.0
    time = np.linspace(0.0, 8e-4, 10_001)
    exact = 2.0 + np.cos(2.0 * np.pi * 1e4 * time)
    joined = np.interp(time, np.arange(sine.value.size) / sine.rate, sine.value)
    assert np.abs(joined - exact).max() < 1.3e-4  # (2 pi / 200)^2 / 8 of the amplitude
    assert "sampled" in notes.all()[0].what


def test_what_is_left_out_is_noted() -> None:
    notes = Notes()
    assert read("dc 1 pwl(0 0 1u 1) ac 1 0", notes=notes) == PiecewiseLinear((0.0, 1e-6), (0.0, 1.0))
    assert {note.what for note in notes.all()} == {"AC value of a source"}


@pytest.mark.parametrize(
    ("text", "span", "direct"),
    [
        ("dc 1 pwl(0 0.5 1u 2)", SPAN, 1.0),
        ("pwl(0 0.5 1u 2) dc 1", SPAN, 1.0),
        ("dc 0.5 pwl(0 0.5 1u 2)", SPAN, None),
        ("pwl(0 0.5 1u 2)", SPAN, None),
        ("dc 0 pulse(1 5 1u 1n 2n 3u)", SPAN, 0.0),
    ],
)
def test_a_dc_value_beside_a_waveform_is_kept(text: str, span: Span, direct: float | None) -> None:
    card = Card(f"v1 a 0 {text}", "a.cir", 5)
    found = read_waveform(card, card.words()[3:], Scope(Limits()), span, Notes())
    assert found.direct == direct
    assert found.negated().direct == (None if direct is None else -direct)


def test_without_a_transient_the_dc_value_is_all_of_a_sine() -> None:
    assert read("dc 1 sin(0 2 1k)", Span()) == Constant(1.0)
    assert read("sin(3 2 1k)", Span()) == Constant(3.0)


test_refused = refusals(
    DataError,
    read,
    [
        ("x", "unknown parameter"),
        ("5 6", "after the value"),
        ("exp(0 1)", "not supported"),
        ("pwl(0 0 1)", "must be pairs"),
        ("pwl(1 0 1 1)", "times must rise"),
        ("pwl(0 0 1 1) td=1", "td: not supported"),
        ("pulse(1)", "must be 2 to 8"),
        ("pulse(0 1 -1)", "a time below 0"),
        ("pulse(0 1 0 1u 1u 1u 2u)", "begins before the one before has ended"),
        ("pulse(0 1 0 1f 1f 1f 10f)", "the limit is 250000"),
        ("sin(0 1 1e12)", "must be 2 to 1000000"),
        ("sin(0)", "must be 2 to 6"),
        ("1e999", "must be finite"),
    ],
    start=r"^a\.cir:5: .*",
)


def test_a_pulse_needs_its_times_where_there_is_no_run() -> None:
    with pytest.raises(DataError, match=r"there is no \.tran to take it from"):
        read("pulse(0 5)", Span())


def test_without_a_run_only_the_value_at_its_begin_counts() -> None:
    assert read("sin(1 2 1k 0 0 90)", Span()) == Constant(3.0)


def test_brackets_mean_nothing_and_no_value_is_none() -> None:
    notes = Notes()
    assert read("0.7 (pwl 0 0 1u 5) (ac 1)", notes=notes) == PiecewiseLinear((0.0, 1e-6), (0.0, 5.0))
    assert read("", notes=notes) == Constant(0.0)
    assert "source without a value, which is 0" in {note.what for note in notes.all()}


@pytest.mark.parametrize("text", ["5", "pwl(0 0 1u 5)", "pulse(0 5 1u 1n 1n 1u)", "sin(1 2 10k)"])
def test_a_source_turned_round_twice_is_itself(text: str) -> None:
    waveform = read(text)
    there = negated(waveform)
    back = negated(there)
    if isinstance(waveform, Sampled) and isinstance(there, Sampled) and isinstance(back, Sampled):
        assert (there.value == -waveform.value).all()
        assert (back.value == waveform.value).all()
    else:
        assert there != waveform
        assert back == waveform
