"""What a network of populations has of each type of node of NIR, and what the linear ones do.

`NODES` is the table that the documents show and that `system.mapping.nir.read` keeps to. A node is faithful
where the network says the same equation, approximate where it says a near one, refused where it cannot; how
near a chip comes to the network is the report's of its mapping (`system.mapping.report`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from circuits.arrays import F64, I64
from circuits.errors import ParameterError

How = Literal["faithful", "approximate", "refused"]
DIRECT = 2e-3  # s, of a synapse for weights that reach a membrane at once; ours
SHARE = 0.05  # of the membrane's time constant, which such a synapse has where that is longer; ours
SLOW = 100e-3  # s, of the membrane that stands for none that leaks; ours
RATE = 500.0  # Hz, of the events that stand for a bias, the most of whose bursts do not overlap; ours
_NEF: How = "refused"  # the NEF chip takes ensembles, which no node of NIR is


class Node(NamedTuple):
    """A type of node: how it is read for ROLLS and for the NEF chip, and what of it."""

    type: str
    rolls: How
    nef: How
    note: str


NODES = (
    Node("Input", "faithful", _NEF, "an input, a channel each entry"),
    Node("Output", "faithful", _NEF, "a probe of the population before it"),
    Node("NIRGraph", "faithful", _NEF, "a graph in a graph: its nodes are named `graph.node`; it may recur"),
    Node(
        "LIF",
        "approximate",
        _NEF,
        f"a population; weights reach it through synapses of {1e3 * DIRECT:g} ms, or {SHARE:.0%} of the"
        " membrane's time constant where that is longer",
    ),
    Node("CubaLIF", "faithful", _NEF, "a population, and the time constant of all synapses to it"),
    Node("IF", "approximate", _NEF, f"a population whose membrane leaks, in {1e3 * SLOW:g} ms"),
    Node("LI", "faithful", _NEF, "synapses before a neuron; before an output, its probe's filter"),
    Node("CubaLI", "refused", _NEF, "two filters in series"),
    Node("I", "refused", _NEF, "an integrator that never forgets"),
    Node("Linear", "faithful", _NEF, "weights"),
    Node("Affine", "faithful", _NEF, f"weights; a bias approximately: an input of its own, {RATE:g} Hz"),
    Node("Scale", "faithful", _NEF, "weights of one to one"),
    Node("Conv1d", "faithful", _NEF, "weights, each by itself; a bias as that of Affine"),
    Node("Conv2d", "faithful", _NEF, "likewise"),
    Node("SumPool2d", "faithful", _NEF, "weights of 1"),
    Node("AvgPool2d", "faithful", _NEF, "weights of 1 over the size of the pool"),
    Node("Flatten", "faithful", _NEF, "the order of neurons"),
    Node("Delay", "refused", _NEF, "a delay other than 0: the chip has none"),
    Node("Threshold", "refused", _NEF, "events without a neuron"),
)
REMEDY: Mapping[str, str] = {
    "CubaLI": "take LI", "I": "take LI, with a time constant", "Delay": "leave it out, or add the delay to"
    " the events", "Threshold": "put a LIF there",
}  # fmt: skip


def linear(where: str, node: Any, signal: F64) -> F64:
    """Return what the weights of a linear node make of signals, float64[*shape, sources]; where: its path.

    Raises `ParameterError` as `check_linear`, and for a signal of another shape than the node takes.
    """
    check_linear(where, node)
    return _LINEAR[type(node).__name__](where, node, signal)


def check_linear(where: str, node: Any) -> None:
    """Raise `ParameterError` for a linear node with a delay or a number that is none; where: its path."""
    for name in ("weight", "scale", "bias"):
        given = getattr(node, name, None)
        values = np.zeros(1) if given is None else np.asarray(given, dtype=np.float64)
        if not np.isfinite(values).all():
            wrong = values[~np.isfinite(values)][0]
            raise ParameterError(f"{where}.{name}: {wrong:g}, must be a finite number; mend it")
    if np.any(np.asarray(getattr(node, "delay", 0.0))):
        raise ParameterError(f"{where}: Delay, is refused on rolls; {REMEDY['Delay']}")


def bias_of(node: Any) -> F64:
    """Return what a linear node adds to its signal, as it states it; one 0 where it adds nothing."""
    bias = getattr(node, "bias", None)
    return np.zeros(1) if bias is None else np.asarray(bias, dtype=np.float64)


def added(where: str, node: Any, shape: tuple[int, ...]) -> F64:
    """Return what a linear node adds to its signal, float64[*shape], one number a channel of a convolution.

    Raises `ParameterError` where it has not as many as the signal; where: its path.
    """
    bias = bias_of(node)
    if type(node).__name__ in _CONVOLUTIONS:
        bias = bias.reshape(-1, *(1,) * (len(shape) - 1))
    try:
        return np.broadcast_to(bias, shape)
    except ValueError:
        text = " x ".join(map(str, shape))
        raise ParameterError(f"{where}.bias: {bias.size} numbers, must be of {text}; mend it") from None


def is_linear(node: Any) -> bool:
    """Return whether a node is one of weights."""
    return type(node).__name__ in _LINEAR


def _matrix(where: str, node: Any, signal: F64) -> F64:
    weight = np.asarray(node.weight, dtype=np.float64)
    _check_size(where, weight.shape[-1], signal.shape[-2])
    return np.asarray(np.matmul(weight, signal))


def _scaled(where: str, node: Any, signal: F64) -> F64:
    scale = np.asarray(node.scale, dtype=np.float64)
    if scale.size > 1:
        _check_size(where, scale.size, int(np.prod(signal.shape[:-1])))
        scale = scale.reshape(signal.shape[:-1])
    return np.asarray(scale[..., None] * signal)


def _flat(_: str, node: Any, signal: F64) -> F64:
    """Axes from start_dim to end_dim as one; batches, of which a graph has none, count as the first."""
    rank = signal.ndim - 1
    if int(np.prod(np.asarray(node.input_type["input"]))) != int(np.prod(signal.shape[:-1])):
        return signal.reshape(-1, signal.shape[-1])
    last = node.end_dim % rank if node.end_dim < 0 else min(node.end_dim, rank - 1)
    first = min(node.start_dim, last)
    shape = (*signal.shape[:first], -1, *signal.shape[last + 1 : -1], signal.shape[-1])
    return signal.reshape(shape)


def _conv2d(where: str, node: Any, signal: F64) -> F64:
    return _convolved(where, node, signal, np.asarray(node.weight, dtype=np.float64))


def _conv1d(where: str, node: Any, signal: F64) -> F64:
    """As in two dimensions, of which the first has one row."""
    weight = np.asarray(node.weight, dtype=np.float64)[:, :, None, :]
    if signal.ndim == _PLANE - 1:
        signal = signal[:, None]
    one = _Kernel((1, _first(node.stride)), _padding_1d(node.padding), (1, _first(node.dilation)), node)
    return _convolved(where, one, signal, weight)[:, 0]


class _Kernel(NamedTuple):
    stride: tuple[int, int]
    padding: Any
    dilation: tuple[int, int]
    of: Any

    @property
    def groups(self) -> int:
        """Groups of the node that it is of."""
        return int(self.of.groups)

    @property
    def bias(self) -> Any:
        """Bias of that node."""
        return self.of.bias


_CONVOLUTIONS = ("Conv1d", "Conv2d")
_PLANE = 4  # axes of a signal in a plane: channel, two of space, sources


def _convolved(where: str, node: Any, signal: F64, weight: F64) -> F64:
    """Windows of the padded signal times the kernel; weight: float64[out, in of a group, height, width]."""
    groups = int(node.groups)
    if signal.ndim != _PLANE or signal.shape[0] != weight.shape[1] * groups:
        raise ParameterError(
            f"{where}: a signal of {' x '.join(map(str, signal.shape[:-1]))}, must have"
            f" {weight.shape[1] * groups} channels; state the input's shape"
        )
    size, dilation = np.array(weight.shape[2:]), _pair(node.dilation)
    windows = _windows(signal, size, _pair(node.stride), node.padding, dilation)
    parts = []
    for each, kernel in zip(np.split(windows, groups), np.split(weight, groups), strict=True):
        parts.append(np.einsum("chwnij,ocij->ohwn", each, kernel))
    return np.concatenate(parts)


def _pool(where: str, node: Any, signal: F64) -> F64:
    if signal.ndim != _PLANE:
        raise ParameterError(
            f"{where}: a signal of {signal.ndim - 1} axes, must have 3; state the input's shape"
        )
    size = _pair(node.kernel_size)
    windows = _windows(signal, size, _pair(node.stride), node.padding, np.ones(2, np.int64))
    total = windows.sum(axis=(-2, -1))
    return np.asarray(total / size.prod() if type(node).__name__ == "AvgPool2d" else total)


def _windows(signal: F64, size: I64, stride: I64, padding: Any, dilation: I64) -> F64:
    """Windows of a padded signal, float64[channels, rows, columns, sources, height, width]."""
    reach = dilation * (size - 1)
    if isinstance(padding, str):
        total = reach if padding == "same" else np.zeros(2, np.int64)
        edges = [(int(t // 2), int(t - t // 2)) for t in total]
    else:
        edges = [(int(p), int(p)) for p in _pair(padding)]
    padded = np.pad(signal, [(0, 0), *edges, (0, 0)])
    found = sliding_window_view(padded, tuple(int(r) + 1 for r in reach), axis=(1, 2))
    return found[:, :: stride[0], :: stride[1], :, :: dilation[0], :: dilation[1]]


def _same(where: str, node: Any, signal: F64) -> F64:
    return signal


def _pair(value: Any) -> I64:
    return np.broadcast_to(np.asarray(value, dtype=np.int64).ravel(), (2,))


def _first(value: Any) -> int:
    return int(np.asarray(value).ravel()[0])


def _padding_1d(padding: Any) -> Any:
    return padding if isinstance(padding, str) else (0, _first(padding))


def _check_size(where: str, takes: int, size: int) -> None:
    if takes != size:
        raise ParameterError(
            f"{where}: takes {takes} entries, {size} come; flatten them, or mend the weights"
        )


_LINEAR: Mapping[str, Callable[[str, Any, F64], F64]] = {
    "Linear": _matrix, "Affine": _matrix, "Scale": _scaled, "Flatten": _flat, "Conv1d": _conv1d,
    "Conv2d": _conv2d, "SumPool2d": _pool, "AvgPool2d": _pool, "Delay": _same,
}  # fmt: skip
