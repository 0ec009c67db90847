"""Arguments of a function declare parameters with units, knobs and the supply; others are refused."""

from dataclasses import asdict, dataclass, fields
from typing import Annotated

from circuits.blocks.arguments import arguments_of
from circuits.blocks.block import Stimulus
from circuits.errors import ParameterError
from circuits.units import quantity
from tests.refusals import refusals


def _bench(w: Annotated[float, "m"] = 2e-6, gain=3, t_s=1e-3, taps=(1.0, 2.0), *, rate_Hz=9.0, v_dd=5.0):  # noqa: N803 - a unit
    return w, gain, t_s, taps, rate_Hz, v_dd


def test_units_come_from_annotations_and_names() -> None:
    found = arguments_of(_bench, knobs=True)
    assert asdict(found.params) == {"w": 2e-6, "gain": 3, "t_s": 1e-3, "taps": (1.0, 2.0)}
    assert [f.metadata["unit"] for f in fields(found.params)] == ["m", "", "s", ""]
    assert found.knobs == (Stimulus("rate_Hz", "Hz", 9.0, "an argument of the function"),)
    assert found.supply


def test_without_a_testbench_every_argument_is_a_parameter() -> None:
    found = arguments_of(_bench, knobs=False)
    assert [f.name for f in fields(found.params)] == ["w", "gain", "t_s", "taps", "rate_Hz", "v_dd"]
    assert not found.knobs


def test_a_call_gets_what_was_given_and_the_supply() -> None:
    found = arguments_of(_bench, knobs=True)
    assert _bench(**found.keywords(found.params, {}, 3.3)) == (2e-6, 3, 1e-3, (1.0, 2.0), 9.0, 3.3)
    given = found.keywords(found.params, {"rate_Hz": 0.5, "duration": 1.0}, 1.8)
    assert _bench(**given) == (2e-6, 3, 1e-3, (1.0, 2.0), 0.5, 1.8)


@dataclass(frozen=True, slots=True)
class _Sizes:
    width: float = quantity(6e-6, "m")


def test_one_dataclass_is_the_parameters_itself() -> None:
    usual = _Sizes(7e-6)

    def build(params: _Sizes = usual) -> _Sizes:
        return params

    found = arguments_of(build, knobs=False)
    assert build(**found.keywords(_Sizes(8e-6), {}, 5.0)) == _Sizes(8e-6)
    assert found.params is usual


def test_words_and_flags_are_no_numbers() -> None:
    found = arguments_of(lambda mode="a", on=True, n=2, none=None: (mode, on, n, none), knobs=False)
    assert [f.name for f in fields(found.params)] == ["n"]


test_what_cannot_be_given_is_refused_by_name = refusals(
    ParameterError,
    lambda function: arguments_of(function, knobs=True),
    [
        (lambda w: w, "argument w: has no default; write w=VALUE"),
        (lambda w=1.0, /: w, "argument w: cannot be given by its name"),
        (lambda *, w=(1.0, 2.0): w, "argument w: several numbers, a knob has one"),
    ],
)
