"""An approach as a film: ranges, boards, calls and echoes, spikes, and what is inside each neuron."""

from __future__ import annotations

import numpy as np

from chips.ranging import circuit as ranging_chip
from system.approach.healing import explained
from system.approach.neuron import looked_into
from system.approach.trace import Trace
from system.view.film import (
    Film,
    Line,
    Panel,
    Raster,
    Shape,
    Stage,
    Track,
    busiest,
    merged,
)
from system.worlds.sound.targets import range_at


def film(trace: Trace, asked: tuple[str, ...] | None) -> Film:
    """Return the film of a run with what is inside the neurons that are asked for.

    asked: names of neurons; None for the `MOST` that spike most.
    """
    s = trace.scenario
    spikes = np.array(trace.spikes, dtype=np.float64).reshape(-1, 2)
    spikes = spikes[np.argsort(spikes[:, 0], kind="stable")]
    rows = tuple(f"neuron[{k}]" for k in range(ranging_chip.NEURONS))
    time = trace.time_s
    lost = explained(trace)
    neurons = {neuron.name: neuron for _, neuron in lost if neuron is not None}
    chosen = [name for name in busiest(rows, spikes[:, 1], asked) if name not in neurons]
    heard = merged((trace.calls[:, 0], trace.pulses, trace.echoes))
    return Film(
        title="",
        headline="",
        duration=s.duration,
        world=_world(trace),
        panels=(
            Panel(
                title="range",
                unit="m",
                lines=(
                    Line(name="first target", time=time, value=trace.range_m),
                    Line(name="estimate", time=time, value=trace.estimate_m),
                ),
            ),
            Panel(
                title="range-tuned neurons",
                raster=Raster(time=spikes[:, 0], row=spikes[:, 1].astype(np.int64), rows=rows),
            ),
            Panel(
                title="calls and what is heard",
                raster=Raster(time=heard[0], row=heard[1], rows=("call", "chip's call", "chip's echo")),
            ),
            Panel(
                title="proximity voltage",
                unit="V",
                lines=(Line(name="centroid board", time=time, value=trace.proximity_V),),
            ),
            Panel(
                title="call rate",
                unit="Hz",
                lines=(Line(name="vocalization board", time=time, value=trace.call_rate_Hz, step=True),),
            ),
        ),
        neurons=(*(looked_into(trace, name) for name in chosen), *neurons.values()),
        moments=tuple(moment for moment, _ in lost),
    )


def _world(trace: Trace) -> Stage:
    """The line of sight: the bat at 0, its targets on it, and where it takes the first one to be."""
    time, s = trace.time_s, trace.scenario
    zero = np.zeros(time.size)
    targets = [(t.name, range_at(t.trajectory, time)) for t in s.targets]
    farthest = max(float(np.max(r)) for _, r in targets)
    return Stage(
        unit="m",
        shapes=(
            Shape(
                role="floor",
                points=((-0.2, -0.5), (farthest + 0.3, -0.5), (farthest + 0.3, 0.5), (-0.2, 0.5)),
            ),
            Shape(role="way", points=((0.0, 0.0), (farthest, 0.0)), closed=False, name="line of sight"),
        ),
        tracks=(
            Track(name="bat", time=time, x=zero, y=zero, heading=zero, radius=0.08),
            *(Track(name=n, time=time, x=r, y=zero, radius=0.1, role="moving") for n, r in targets),
            Track(name="estimate", time=time, x=trace.estimate_m, y=zero - 0.25, radius=0.05),
        ),
    )
