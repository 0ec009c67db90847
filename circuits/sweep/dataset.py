"""What a sweep has found as labelled arrays: a dimension a swept name, in the order of the names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from circuits.measure.measure import Measure, Reading
from circuits.sweep.axis import DIRECTION, Axis, Way
from circuits.sweep.line import Line


def points_dataset(
    axes: Sequence[Axis], ways: Sequence[Way], nodes: Sequence[str], lines: Sequence[Line]
) -> xr.Dataset:
    """Operating points: `voltage` by node (V), `current` by device (A), and `stable`.

    lines: over the first axis, for each way and each combination of the other axes, the second one fastest.
    """
    flips = [slice(None, None, -1) if way == "down" else slice(None) for way in ways]
    turned = [flips[k % len(ways)] for k in range(len(lines))]
    devices = list(lines[0].currents)
    inner = axes[0]
    dims = [*(axis.name for axis in axes[:0:-1]), DIRECTION, inner.name]
    shape = [*(len(axis.values) for axis in axes[:0:-1]), len(ways), len(inner.values)]
    voltage = np.stack([line.voltage[flip] for line, flip in zip(lines, turned, strict=True)])
    current = np.stack(
        [np.stack([line.currents[d] for d in devices], axis=-1)[flip] if devices else np.zeros((shape[-1], 0))
         for line, flip in zip(lines, turned, strict=True)]
    )  # fmt: skip
    stable = np.stack([line.stable[flip] for line, flip in zip(lines, turned, strict=True)])
    found = xr.Dataset(
        {
            "voltage": ((*dims, "node"), voltage.reshape(*shape, -1), {"units": "V"}),
            "current": ((*dims, "device"), current.reshape(*shape, -1), {"units": "A"}),
            "stable": (dims, stable.reshape(shape)),
        },
        coords={**_coordinates(axes, ways), "node": list(nodes), "device": devices},
    )
    return _in_order(found, axes, ways)


def measures_dataset(
    axes: Sequence[Axis],
    ways: Sequence[Way],
    measures: Sequence[Measure],
    readings: Sequence[Sequence[Reading]],
) -> xr.Dataset:
    """A variable a measure, with its unit and expression, and `reason` where one has no value.

    readings: one after the other for each way and each combination of the axes, the first one fastest.
    """
    if not measures:
        return xr.Dataset()
    dims = [*(axis.name for axis in axes[::-1]), DIRECTION]
    shape = [*(len(axis.values) for axis in axes[::-1]), len(ways)]
    found: dict[str, Any] = {
        each.name: (
            dims,
            np.array([r[k].value for r in readings]).reshape(shape),
            {"units": each.unit, "expression": each.text},
        )
        for k, each in enumerate(measures)
    }
    reasons = ["; ".join(f"{r.name}: {r.reason}" for r in each if r.reason) for each in readings]
    found["reason"] = (dims, np.array(reasons, dtype=object).reshape(shape))
    return _in_order(xr.Dataset(found, coords=_coordinates(axes, ways)), axes, ways)


def _coordinates(axes: Sequence[Axis], ways: Sequence[Way]) -> dict[str, Any]:
    swept: dict[str, Any] = {
        axis.name: (axis.name, np.array(axis.values), {"units": axis.unit} if axis.unit else {})
        for axis in axes
    }
    return {**swept, DIRECTION: list(ways)}


def _in_order(found: xr.Dataset, axes: Sequence[Axis], ways: Sequence[Way]) -> xr.Dataset:
    """Dimensions in the order of the names, and that of the direction only where there are two."""
    turned = found.transpose(*(axis.name for axis in axes), DIRECTION, ...)
    return turned if len(ways) > 1 else turned.isel({DIRECTION: 0}, drop=True)
