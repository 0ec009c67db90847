"""A network of values as pure data, which the NEF chip is asked to be.

    x = sum over what ends at an ensemble of low-pass(T f(x of another)), or low-pass(T u) of an input

Neurons are drawn from the network's seed. `lowered` gives what `chips.nef` builds. A function takes all
points at once, float64[points, dimensions] -> float64[points, results]; it is one of `FUNCTIONS`, or
`FILE.py:NAME` of one's own, from the folder where the command is given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chips.nef.network import network as nef
from circuits.errors import ParameterError, unknown_name
from system.mapping.network import Input, Matrix
from system.option import Checked, check_options, option, required, tupled
from system.options.code import code_of, guarded, load_code

FUNCTIONS: Mapping[str, nef.Function] = {
    "square": np.square,
    "absolute": np.abs,
    "positive": lambda x: np.maximum(x, 0.0),
    "product": lambda x: np.prod(x, axis=1, keepdims=True),
    "sum": lambda x: np.sum(x, axis=1, keepdims=True),
    "length": lambda x: np.sqrt((x**2).sum(axis=1, keepdims=True)),
}
IDENTITY = "identity"


@dataclass(frozen=True, slots=True)
class Ensemble:
    """Neurons that together represent a vector x.

    Attributes
    ----------
    name : str
        Its name, by which connections and probes call it.
    neurons, dimensions : int
        How many neurons it has, and the length of x.
    radius : float
        Largest length of x that is represented well, in the unit of x.
    max_rates : (float, float)
        Rates where x along a neuron's encoder is the radius, drawn evenly from low to high, Hz.
    intercepts : (float, float)
        x along its encoder, over the radius, where a neuron begins to fire, drawn evenly from low to high.

    Raises
    ------
    ParameterError
        A value is outside of its limits.
    """

    name: str = required("Its name")
    neurons: int = required("How many neurons it has", least=1, most=1_000_000)
    dimensions: int = option(1, "Length of the vector", least=1)
    radius: float = option(1.0, "Largest length that is represented well", unit="", above=0.0)
    max_rates: tuple[float, float] = option((200.0, 400.0), "Rates at the radius, low and high", unit="Hz")
    intercepts: tuple[float, float] = option(
        (-1.0, 0.9), "Shares of the radius where neurons begin to fire", unit=""
    )

    def __post_init__(self) -> None:
        for name in ("max_rates", "intercepts"):
            object.__setattr__(self, name, tupled(getattr(self, name)))
        check_options(self)
        self.lowered()

    def lowered(self) -> nef.Ensemble:
        """Return what the chip builds; raises `ParameterError` for rates and intercepts that none has."""
        return nef.Ensemble(
            self.name, self.neurons, self.dimensions, self.radius, self.max_rates, self.intercepts
        )


@dataclass(frozen=True, slots=True)
class Connection(Checked):
    """What an ensemble gets of an ensemble or an input.

    Attributes
    ----------
    source, target : str
        Names of what is connected.
    function : str
        f, a name of `FUNCTIONS`, `identity`, or `FILE.py:NAME`; an input has `identity` alone.
    transform : float or tuple of tuple of float
        T: a number, or a row each result; an array is taken too.
    synapse : float
        Time constant of the low-pass, s.

    Raises
    ------
    ParameterError
        A value is outside of its limits.
    """

    source: str = required("Name of an ensemble or an input", name="from")
    target: str = required("Name of an ensemble", name="to")
    function: str = option(IDENTITY, f"{', '.join(FUNCTIONS)}, identity, or FILE.py:NAME")
    transform: float | Matrix = option(1.0, "A number, or rows of numbers, one each result", unit="")
    synapse: float = option(5e-3, "Time constant of the low-pass", unit="s", least=0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "transform", tupled(self.transform))
        check_options(self)
        if isinstance(self.transform, tuple) and len({len(row) for row in self.transform}) != 1:
            where = f"{self.source}->{self.target}"
            raise ParameterError(f"{where}.transform: rows must be as long, and one each result")

    def lowered(self) -> nef.Connection:
        """Return what the chip builds; raises as `function_of`."""
        function = function_of(self.function)
        return nef.Connection(self.source, self.target, function, self.transform, self.synapse)


@dataclass(frozen=True, slots=True)
class Probe(Checked):
    """What of a network is an output: a function of an ensemble, low-passed.

    Attributes
    ----------
    name, ensemble : str
        Names of the output and of the ensemble.
    function : str
        As of a connection.
    synapse : float
        Time constant of the low-pass, s.

    Raises
    ------
    ParameterError
        The time constant is below 0.
    """

    name: str = required("Its name")
    ensemble: str = required("Name of the ensemble")
    function: str = option(IDENTITY, "As of a connection")
    synapse: float = option(20e-3, "Time constant of the low-pass", unit="s", least=0.0)

    def lowered(self) -> nef.Probe:
        """Return what the chip builds; raises as `function_of`."""
        return nef.Probe(self.name, self.ensemble, function_of(self.function), synapse=self.synapse)


@dataclass(frozen=True, slots=True)
class ValueNetwork:
    """A network of values: ensembles, inputs, what connects them, and its outputs.

    Attributes
    ----------
    ensembles : tuple of Ensemble
        Its neurons.
    inputs : tuple of Input
        What comes from outside; its channels are the numbers of a vector.
    connections : tuple of Connection
        What connects them.
    probes : tuple of Probe
        Its outputs.
    seed : int
        Of the draws of its neurons.

    Raises
    ------
    TopologyError
        A name is given twice.
    UnknownNameError
        A connection or probe names what is not there, or a function is not known.
    """

    ensembles: tuple[Ensemble, ...] = required("Neurons that represent a vector each", name="ensemble")
    inputs: tuple[Input, ...] = option((), "An input each", name="input")
    connections: tuple[Connection, ...] = option((), "What connects them", name="connection")
    probes: tuple[Probe, ...] = option((), "An output each", name="probe")
    seed: int = option(0, "Of the draws of its neurons", least=0)

    def __post_init__(self) -> None:
        own = self.lowered()
        ends = [e.name for e in self.ensembles]
        for one in self.connections:
            if one.target not in ends:
                raise unknown_name(f"target of {one.source}->{one.target}", one.target, ends)
        known = [*(e.name for e in self.ensembles), *(one.name for one in self.inputs)]
        for one in self.connections:
            if one.source not in known:
                raise unknown_name(f"source of {one.source}->{one.target}", one.source, known)
        for probe in self.probes:
            own.ensemble(probe.ensemble)

    @property
    def channels(self) -> int:
        """How many numbers come from outside."""
        return sum(one.size for one in self.inputs)

    def lowered(self) -> nef.Network:
        """Return what the chip builds."""
        return nef.Network(
            tuple(e.lowered() for e in self.ensembles),
            tuple(nef.Node(one.name, one.size) for one in self.inputs),
            tuple(c.lowered() for c in self.connections),
            tuple(p.lowered() for p in self.probes),
        )


def function_of(text: str) -> nef.Function | None:
    """Return the function of a name, None for the identity.

    Raises `UnknownNameError` for a name that is none, and as `load_code` for `FILE.py:NAME`.
    """
    if text == IDENTITY:
        return None
    code = code_of(text)
    if code is not None:
        return guarded(load_code(code), code.path)
    if text not in FUNCTIONS:
        raise unknown_name("function", text, [IDENTITY, *FUNCTIONS])
    return FUNCTIONS[text]
