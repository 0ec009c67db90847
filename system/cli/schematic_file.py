"""The file of a schematic that `noctule show` writes, with the operating point where it is asked for."""

from __future__ import annotations

import numpy as np

from circuits.circuit import GROUND
from circuits.devices import Diode
from circuits.lowering.kernel import to_kernel
from circuits.measure.scope import device_currents
from circuits.solver.device_table import resistor_table_at, transistor_table_at
from circuits.solver.operating_point import operating_point
from system.cli.output import working
from system.options.block import Choice, silicon_line
from system.options.target import deck_of
from system.plot import save_picture
from system.schematic.picture import Solved, draw_schematic


def save_schematic(path: str, target: str, choice: Choice, *, solved: bool) -> None:
    """Write the schematic of a block; of a deck the sources that drive it are drawn too.

    Parameters
    ----------
    path
        The file, .svg, .png or .pdf.
    target
        What the command was asked about.
    choice
        The block on silicon, under its stimuli at 0 s.
    solved
        Whether node voltages and currents are written into it.
    """
    sources = () if deck_of(target) is None else choice.testbench().sources
    numbers = _solve(choice) if solved else Solved()
    save_picture(path, lambda figure: draw_schematic(choice.circuit, figure, sources, numbers))


def _solve(choice: Choice) -> Solved:
    with working("solving"):
        point = operating_point(to_kernel(choice.testbench(), choice.silicon))
    volts = {node: v for node, v in point.voltages().items() if node != GROUND}
    transistors, resistors = transistor_table_at(point), resistor_table_at(point)
    diodes = device_currents(point, point.machine.flat.labels(Diode))
    names = (*transistors.name, *resistors.name, *diodes)
    currents = np.abs((
        *transistors.drain_current.tolist(), *resistors.current.tolist(), *(i[0] for i in diodes.values())
    ))  # fmt: skip
    state = "" if point.stable else ", which is not stable"
    note = f"operating point at {silicon_line(choice.silicon)}{state}"
    return Solved(volts, dict(zip(names, currents.tolist(), strict=True)), note)
