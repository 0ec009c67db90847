"""What a sweep has found as labelled arrays: a dimension a swept name, in the order of the names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.catalogue import later
from circuits.lowering.kernel import Machine
from circuits.measure.branch import branches, inner_devices
from circuits.measure.measure import Measure, Reading
from circuits.sweep.axis import DIRECTION, Axis, Way
from circuits.sweep.line import Line

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")


def points_dataset(
    axes: Sequence[Axis], ways: Sequence[Way], machine: Machine, lines: Sequence[Line]
) -> xr.Dataset:
    """Operating points: `voltage` by node (V), `current` by device (A), and `stable`.

    A node that stands for the current of an element is not among the nodes: the element is among the devices.

    machine: of which they are. lines: over the first axis, for each way and each combination of the other
    axes, the second one fastest.
    """
    flips = [slice(None, None, -1 if ways[k % len(ways)] == "down" else 1) for k in range(len(lines))]
    inner, standing = inner_devices(machine), branches(machine)
    devices = [name for name in lines[0].currents if name not in inner]
    kept = [k for k, name in enumerate(machine.names) if name not in standing]
    currents = [np.array([line.currents[d] for d in devices]).reshape(len(devices), -1).T for line in lines]
    found = {
        "voltage": [line.voltage[:, kept] for line in lines],
        "current": currents,
        "stable": [line.stable for line in lines],
    }
    stacked = {
        name: np.array([array[flip] for array, flip in zip(arrays, flips, strict=True)])
        for name, arrays in found.items()
    }
    dims = _dimensions(axes, ways)
    return xr.Dataset(
        {
            "voltage": ((*dims, "node"), _arranged(stacked["voltage"], axes, ways), {"units": "V"}),
            "current": ((*dims, "device"), _arranged(stacked["current"], axes, ways), {"units": "A"}),
            "stable": (dims, _arranged(stacked["stable"], axes, ways)),
        },
        coords={**_coordinates(axes, ways), "node": [machine.names[k] for k in kept], "device": devices},
    )


def measures_dataset(
    axes: Sequence[Axis],
    ways: Sequence[Way],
    measures: Sequence[Measure],
    readings: Sequence[Sequence[Reading]],
) -> xr.Dataset:
    """A variable a measure, with its unit and expression, and `reason` where one has no value.

    readings: one after the other for each way and each combination of the axes, the first one fastest.
    """
    # as lines of one point over an axis that is none
    point, dims = Axis("", "parameter", "", (0,)), _dimensions(axes, ways)
    found: dict[str, Any] = {}
    for k, each in enumerate(measures):
        values = _arranged(np.array([[r[k].value] for r in readings]), (point, *axes), ways)[0]
        found[each.name] = (dims, values, {"units": each.unit, "expression": each.text})
    reasons = ["; ".join(f"{r.name}: {r.reason}" for r in each if r.reason) for each in readings]
    words = np.array([[reason] for reason in reasons], dtype=object)
    found["reason"] = (dims, _arranged(words, (point, *axes), ways)[0])
    return xr.Dataset(found, coords=_coordinates(axes, ways))


def _dimensions(axes: Sequence[Axis], ways: Sequence[Way]) -> tuple[str, ...]:
    """Names of the dimensions, the direction's only where there are two."""
    return (*(axis.name for axis in axes), *([DIRECTION] if len(ways) > 1 else []))


def _coordinates(axes: Sequence[Axis], ways: Sequence[Way]) -> dict[str, Any]:
    swept: dict[str, Any] = {
        axis.name: (axis.name, np.array(axis.values), {"units": axis.unit} if axis.unit else {})
        for axis in axes
    }
    return {**swept, **({DIRECTION: list(ways)} if len(ways) > 1 else {})}


def _arranged(stacked: Any, axes: Sequence[Axis], ways: Sequence[Way]) -> Any:
    """Lines one below the other, [lines, inner, ...], as an array over the axes in order, then the way."""
    sizes = [len(axis.values) for axis in axes]
    array = stacked.reshape(*sizes[:0:-1], len(ways), sizes[0], *stacked.shape[2:])
    outer = len(sizes) - 1
    order = [outer + 1, *range(outer - 1, -1, -1), outer, *range(outer + 2, array.ndim)]
    turned = array.transpose(order)
    return turned if len(ways) > 1 else turned.reshape(*sizes, *stacked.shape[2:])
