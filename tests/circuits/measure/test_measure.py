"""Measures of runs with known answers, and all that is refused before a run."""

import math

import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear, Pulse
from circuits.errors import ParameterError
from circuits.measure.formula import usage_of
from circuits.measure.function import FUNCTIONS
from circuits.measure.grammar import MeasureError
from circuits.measure.measure import measure
from circuits.silicon.silicon import Silicon
from circuits.solver.power import delivered_energy
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from tests.circuits.solver.examples import TAU, C, R, low_pass
from tests.documents import ROOT

STEP = PiecewiseLinear((0.0, 1e-12), (0.0, 1.0))
WAVES = Pulse(0.0, 1.0, tuple(1e-6 * k for k in (1.0, 5.0, 9.0)), 1e-6, 1e-9, 1e-9)


@pytest.fixture(scope="module")
def step() -> Result:
    return simulate(low_pass(STEP, 20.0 * TAU), Silicon(), rtol=1e-8)


@pytest.fixture(scope="module")
def waves() -> Result:
    return simulate(low_pass(WAVES, 14.0 * TAU, watch=True))


STEP_ANSWERS = [
    ("cross(y, 0.5)", TAU * math.log(2.0), "s"),
    ("cross(y, 900mV, rise) - cross(y, 0.1, rise)", TAU * math.log(9.0), "s"),
    ("value(y, at=1us)", 1.0 - math.exp(-1.0), "V"),
    ("slope(y, at=1us)", math.exp(-1.0) / TAU, "V/s"),
    ("slope(y, from=1us, to=2us)", (math.exp(-1.0) - math.exp(-2.0)) / TAU, "V/s"),
    ("mean(y, from=0.5us, to=3us)", 1.0 - TAU * (math.exp(-0.5) - math.exp(-3.0)) / 2.5e-6, "V"),
    ("integral(a - y)", TAU, "V*s"),
    ("integral(i(r))", C, "C"),
    ("value(i(c), at=1us)", math.exp(-1.0) / R, "A"),
    ("value(i(a), at=1us)", -math.exp(-1.0) / R, "A"),
    ("value(v(a, y), at=1us) / value(i(r), at=1us)", R, "Ohm"),
    ("rms(v(a, y), from=1us, to=2us)", math.sqrt(0.5 * (math.exp(-2.0) - math.exp(-4.0))), "V"),
    ("energy(a)", C, "J"),
    ("max(y, from=0, to=1us) + min(a, from=1us)", 2.0 - math.exp(-1.0), "V"),
    ("swing(y, to=1us)", 1.0 - math.exp(-1.0), "V"),
    ("max_at(i(r), from=1us)", 1e-6, "s"),
    ("-ln(value(1 - y, at=1us) / 1V) * 2^-1", 0.5, ""),
    ("sqrt(value(y, at=1us) ** 2)", 1.0 - math.exp(-1.0), "V"),
    ("max(1us, 2us) / min(1us, 2us)", 2.0, ""),
    ("db(value(y, at=1us) / 1V)", 20.0 * math.log10(1.0 - math.exp(-1.0)), "dB"),
]


@pytest.mark.parametrize(("text", "value", "unit"), STEP_ANSWERS)
def test_a_step_through_a_low_pass(step: Result, text: str, value: float, unit: str) -> None:
    (found,) = measure(step, text).values()
    # the local error of a step is 1e-8, and the run has some hundred of them
    assert (found.value, found.unit, found.reason) == (pytest.approx(value, rel=2e-5), unit, "")


def test_pulses_have_period_duty_and_spikes(waves: Result) -> None:
    found = measure(
        waves, "t = period(a, 0.5)", "d = duty(a, 0.5)", "n = spikes(y)", "m = spikes(y, 0.5)",
        "late = spikes(y, from=4us)", "third = cross(a, 0.5, rise, 3)", "end = cross(a, 0.5, fall, last)",
        "width = end - third",
    )  # fmt: skip
    assert found["t"].value == pytest.approx(4e-6)
    assert found["d"].value == pytest.approx(1.001e-6 / 4e-6)
    assert [found[k].value for k in ("n", "m", "late")] == [waves.spikes["y"].size, 3.0, 0.0]
    assert found["width"].value == pytest.approx(1.001e-6)


def test_spikes_are_those_of_the_solver() -> None:
    run = simulate(low_pass(Pulse(0.0, 5.0, (1e-6, 9e-6), 5e-6, 1e-9, 1e-9), 20.0 * TAU, watch=True))
    found = measure(run, "n = spikes(y)", "first = cross(y, 2.5, rise)", "last = cross(y, 2.5, rise, last)")
    assert found["n"].value == run.spikes["y"].size == 2
    # the same parabola: equal but for its bisection
    assert [found["first"].value, found["last"].value] == pytest.approx(run.spikes["y"].tolist(), abs=1e-16)


def test_energy_is_that_of_the_run(waves: Result) -> None:
    assert measure(waves, "e = energy(a)")["e"].value == pytest.approx(
        delivered_energy(waves)["a"], rel=1e-12
    )
    parts = measure(waves, "e = energy(a, to=3us) + energy(a, from=3us)")["e"]
    assert parts.value == pytest.approx(delivered_energy(waves)["a"], rel=1e-12)


REASONS = {
    "cross(y, 2)": "y does not pass through 2V",
    "cross(a, 0.5, rise, 4)": "a does not rise through 500mV 4 times, but 3",
    "mean(y, from=3us, to=2us)": "window from 3us to 2us is empty",
    "mean(y, to=15us)": "to 15us is outside the run, 0s to 14us",
    "value(y, at=-1us)": "at -1us is outside the run, 0s to 14us",
    "period(y, 0.95)": "y has no whole period: it rises through 950mV never",
    "1 / max(y, from=0, to=0.1us)": "division by 0",
    "ln(-1)": "-1 is not above 0",
}


@pytest.mark.parametrize(("text", "reason"), REASONS.items())
def test_what_does_not_occur_says_why(waves: Result, text: str, reason: str) -> None:
    found = measure(waves, text)["measure_1"]
    assert (math.isnan(found.value), found.reason) == (True, reason)


REFUSED = {
    "": 'measure: ">", column 1: the end, must be a name or a number',
    "t = cross(y, 0.5": 'measure: "t = cross(y, 0.5>", column 17: the end, must be ) or a comma',
    "cros(y, 1)": 'measure: ">cros(y, 1)", column 1: function cros: unknown; did you mean cross?',
    "max(y) + max(yy)": 'measure: "max(y) + max(>yy)", column 14: node yy: unknown; did you mean y?',
    "max(y) 3": 'measure: "max(y) >3", column 8: 3, must be an operator or the end',
    "max(y) + cross(y, 1)": 'measure: "max(y) + >cross(y, 1)", column 10: a number in V + a number in s,'
    " must have one unit",
    "cross(y, 2A)": 'measure: "cross(y, >2A)", column 10: cross(): level 2A in A, must be in V',
    "cross(y, 1, up)": 'measure: "cross(y, 1, >up)", column 13: cross(): direction up, must be one of rise,'
    " fall, either",
    "cross(y, 1, frm=0)": 'measure: "cross(y, 1, >frm=0)", column 13: cross() has no frm; did you mean from?;'
    " write cross(signal, level[, direction, n, from=, to=])",
    "y * 2": 'measure: ">y * 2", column 1: a waveform, must be a number; write max(...), mean(...) or'
    " value(..., at=...)",
    "max(r)": 'measure: "max(>r)", column 5: r: no node; write i(r) for its current',
    "max(i(q))": 'measure: "max(i(>q))", column 7: device or source q: unknown; known are a, c, r',
    "energy(r)": 'measure: "energy(>r)", column 8: source r: unknown; it takes a source of voltage',
    "max(y, 2M)": 'measure: "max(y, >2M)", column 8: number: "2M", must be a plain number; write 2m or 2Meg',
    "value(y)": 'measure: ">value(y)", column 1: value(): must have at; write value(signal, at)',
    "max(y) ^ 1.5": 'measure: "max(y) ^ >1.5", column 10: exponent of a number in V, must be whole; write ^2',
    "sqrt(max(y))": 'measure: ">sqrt(max(y))", column 1: the square root of a number in V has no unit',
    "__import__('os')": "measure: \"__import__(>'os')\", column 12: 'os', must be a name or a number",
    "spikes(a)": 'measure: ">spikes(a)", column 1: a: not watched for spikes; give a level, as'
    " spikes(a, 0.9)",
    "mean(y, 1us, 2us, 3us)": 'measure: "mean(y, 1us, 2us, >3us)", column 19: mean(): too many arguments;'
    " write mean(signal[, from=, to=])",
    "mean(y, to=1us, to=1us)": 'measure: "mean(y, to=1us, >to=1us)", column 17: mean(): to is there twice;'
    " write mean(signal[, from=, to=])",
    "mean(2)": 'measure: "mean(>2)", column 6: mean(): signal 2, must be a waveform, as v(node)',
    "n[1] = max(y)": 'measure: ">n[1] = max(y)", column 1: n[1]: must be a name without dots and brackets',
}  # fmt: skip


@pytest.mark.parametrize(("text", "error"), REFUSED.items())
def test_what_is_no_measure_is_one_line_with_its_column(waves: Result, text: str, error: str) -> None:
    with pytest.raises(MeasureError) as caught:
        measure(waves, text)
    assert str(caught.value) == error


def test_a_long_measure_is_shown_around_the_column(waves: Result) -> None:
    with pytest.raises(ParameterError, match=r'measure: "\.\.\..{20,40}>cros\(y\).*\.\.\.", column 605'):
        measure(waves, "1 + " * 150 + "1 + cros(y)" + " + 1" * 100)
    with pytest.raises(ParameterError, match="must be at most 4000"):
        measure(waves, "1 + " * 1500 + "1")


def test_names_of_measures() -> None:
    circuit = Circuit(
        "c",
        (Port("a", "analog"), Port("t", "analog")),
        (Resistor("r", "a", "t", 1.0), Resistor("s", "t", "0", 1.0)),
    )
    run = simulate(Testbench("b", circuit, (Source("a", "a", Constant(1.0)),), 1.0))
    assert [*measure(run, "x = 1", "2")] == ["x", "measure_2"]
    with pytest.raises(MeasureError, match="x: stands twice, must be once"):
        measure(run, "x = 1", "x = 2")
    with pytest.raises(MeasureError, match=r"t: both a node and a measure; write v\(t\), or rename it"):
        measure(run, "t = 1", "max(t)")
    assert measure(run, "t = 1", "z = max(v(t))")["z"].value == pytest.approx(0.5)
    with pytest.raises(ParameterError, match="no expression"):
        measure(run)


def test_every_function_has_a_summary_and_distinct_parameters() -> None:
    for forms in FUNCTIONS.values():
        for form in forms:
            names = [p.name for p in form.parameters]
            assert form.summary
            assert len(names) == len(set(names))


def test_every_function_is_on_the_page_of_measures() -> None:
    page = (ROOT / "docs" / "reference" / "measures.md").read_text(encoding="utf-8")
    usages = {usage_of(name, form) for name, forms in FUNCTIONS.items() for form in forms}
    told = {usage for usage in usages if f"`{usage}`" in page}
    assert usages - told <= {usage_of(name, forms[1]) for name, forms in FUNCTIONS.items() if len(forms) > 1}
