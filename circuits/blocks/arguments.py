"""What the arguments of a user's function declare: parameters of a block, and knobs of its testbench.

`def follower(w: Annotated[float, "m"] = 2e-6, gain=1.0, *, step_V=0.2)` has the parameters `w` in metres and
`gain`, a plain number, and behind the `*` the knob `step_V` in volts. The unit of an argument is the text
in its annotation, else the one that its name ends with (`circuits.units.unit_of_name`), else it is a plain
number. An argument `v_dd` is no knob where there is a testbench: it takes the supply of the process, V.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass, make_dataclass
from inspect import Parameter, signature
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from circuits.blocks.block import Stimulus, Values
from circuits.errors import ParameterError
from circuits.units import quantity, unit_of_name

SUPPLY = "v_dd"  # an argument of this name takes the process's supply, V


@dataclass(frozen=True, slots=True)
class Arguments:
    """Arguments of a function.

    Attributes
    ----------
    params : a value of a frozen dataclass with a field for each parameter.
    knobs : arguments that can be given by their name alone.
    supply : whether there is an argument for the supply.
    whole : name of the argument that takes `params` itself; empty where each field is an argument.
    """

    params: Any
    knobs: tuple[Stimulus, ...] = ()
    supply: bool = False
    whole: str = ""

    def keywords(self, params: Any, knobs: Values, v_dd: float) -> dict[str, Any]:
        """Arguments by name for a call with parameters, knobs that differ, and a supply, V."""
        given = {f.name: getattr(params, f.name) for f in fields(params)}
        told: dict[str, Any] = {self.whole: params} if self.whole else given
        known = {knob.name for knob in self.knobs}
        told |= {name: value for name, value in knobs.items() if name in known}
        return told | ({SUPPLY: v_dd} if self.supply else {})


def no_arguments() -> Arguments:
    """The arguments of what takes none."""
    return numbers_as_arguments({})


def numbers_as_arguments(values: Mapping[str, float]) -> Arguments:
    """The arguments of what takes plain numbers by name, with their usual values."""
    return Arguments(_params((name, value, "") for name, value in values.items()))


def arguments_of(function: Callable[..., Any], *, knobs: bool) -> Arguments:
    """Read what a function's arguments declare.

    knobs: whether those behind `*` are knobs of a testbench, and `v_dd` its supply; else all are parameters.
    Raises `ParameterError` naming an argument that has no default, or that cannot be given by its name.
    """
    declared = [p for p in signature(function).parameters.values() if p.kind not in _COLLECTING]
    hints = _hints(function)
    for each in declared:
        if each.default is each.empty or each.kind is each.POSITIONAL_ONLY:
            rule = "has no default" if each.default is each.empty else "cannot be given by its name"
            raise ParameterError(f"argument {each.name}: {rule}; write {each.name}=VALUE, behind no /")
    if len(declared) == 1 and is_dataclass(declared[0].default):
        return Arguments(declared[0].default, whole=declared[0].name)
    supply = knobs and any(p.name == SUPPLY for p in declared)
    numbers = [p for p in declared if _is_number(p.default) and not (supply and p.name == SUPPLY)]
    turned = [p for p in numbers if knobs and p.kind is p.KEYWORD_ONLY]
    sizes = ((p.name, p.default, _unit(p, hints)) for p in numbers if p not in turned)
    return Arguments(_params(sizes), tuple(_knob(p, hints) for p in turned), supply)


_COLLECTING = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)


def _params(declared: Any) -> Any:
    made = [(name, type(default), quantity(default, unit)) for name, default, unit in declared]
    return make_dataclass("Params", made, frozen=True, slots=True)()


def _knob(argument: Parameter, hints: Mapping[str, Any]) -> Stimulus:
    if isinstance(argument.default, tuple):
        raise ParameterError(
            f"argument {argument.name}: several numbers, a knob has one; put it before the *"
        )
    return Stimulus(argument.name, _unit(argument, hints), argument.default, "an argument of the function")


def _is_number(value: object) -> bool:
    if isinstance(value, tuple):
        return bool(value) and all(_is_number(each) for each in value)
    return isinstance(value, int | float) and not isinstance(value, bool)


def _unit(argument: Parameter, hints: Mapping[str, Any]) -> str:
    hint = hints.get(argument.name)
    if get_origin(hint) is Annotated:
        return next((each for each in get_args(hint)[1:] if isinstance(each, str)), "")
    return unit_of_name(argument.name)


def _hints(function: Callable[..., Any]) -> Mapping[str, Any]:
    """Annotations of the arguments; none where one of them leads nowhere."""
    try:
        return get_type_hints(function, include_extras=True)
    except (NameError, TypeError, AttributeError, SyntaxError):
        return {}
