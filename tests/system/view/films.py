"""Films for tests: a small world with a robot, signals, spikes, a camera and a neuron."""

import numpy as np

from system.view.film import (
    Device,
    Eye,
    Film,
    Group,
    Line,
    Neuron,
    Panel,
    Raster,
    Shape,
    Stage,
    Track,
    circles,
    signal,
)


def film(events: int = 2000, spikes: int = 400, duration: float = 10.0) -> Film:
    """A robot on a straight way at 0.1 m/s, a ramp, a raster of eight neurons and a camera."""
    random = np.random.default_rng(0)
    time = np.linspace(0.0, duration, 1001)
    neurons = np.sort(random.uniform(0.0, duration, spikes))
    seen = np.sort(random.uniform(0.0, duration, events))
    raster = Raster(
        time=neurons,
        row=random.integers(0, 8, spikes),
        rows=tuple(f"neuron[{k}]" for k in range(8)),
        groups=(Group("left", 0, 4), Group("right", 4, 4)),
    )
    floor = Shape(role="floor", points=((-0.5, -0.5), (1.5, -0.5), (1.5, 0.5), (-0.5, 0.5)))
    robot = Track(name="robot", time=time, x=0.1 * time, y=0.0 * time, heading=0.0 * time, radius=0.05)
    wave = Line(name="v_mem", time=time, value=np.sin(time))
    inside = Panel(title="inside", unit="V", lines=(wave,))
    devices = (
        Device(path="neuron[2].m1", what="nFET 2/1 um", deviation="V_T0 +5.00 mV", sigma=1.5),
        Device(path="neuron[2].m2", what="pFET 4/1 um", deviation="V_T0 -1.00 mV", sigma=0.5),
    )
    return Film(
        title="a robot",
        headline="succeeded: time of 10 s over",
        duration=duration,
        command="noctule run robot",
        world=Stage(
            unit="m", shapes=(floor, *circles("obstacle", np.array([[1.0, 0.2]]), 0.05)), tracks=(robot,)
        ),
        panels=(
            signal("ramp", "V", time, 3.0 * time),
            Panel(title="neurons", raster=raster),
        ),
        eye=Eye(
            name="camera", columns=16, rows=16, time=seen, x=random.integers(0, 16, events),
            y=random.integers(0, 16, events), on=random.random(events) < 0.5,
        ),
        neurons=(Neuron(name="neuron[2]", devices=devices, waveform=inside),),
        facts={"die": "1000"},
    )  # fmt: skip
