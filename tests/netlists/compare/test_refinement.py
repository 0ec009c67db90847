"""Colour refinement, and the sides of every device."""

import numpy as np
import pytest

from netlists.compare.refinement import Structure, class_count, first_colours, label, labels, refine, sides
from tests.circuits.devices.examples import EXAMPLES


def test_every_terminal_of_every_device_has_one_side() -> None:
    for device in EXAMPLES.values():
        positions = sorted(k for _, terminals in sides(device) for _, k in terminals)
        assert positions == list(range(len(device.terminals())))


def test_a_device_without_sides_is_named() -> None:
    with pytest.raises(TypeError, match="int: no sides"):
        sides(3)  # type: ignore[arg-type]


def chain(count: int) -> Structure:
    """Two-ended devices in a row from a port."""
    ends = [(k, k + 1) for k in range(count)]
    node_label = np.full(count + 1, label("node"), dtype=np.uint64)
    node_label[0] = label("port")
    return Structure(
        np.arange(2 * count),
        np.array(ends, dtype=np.int64).ravel(),
        labels(["end"] * 2 * count),
        np.repeat(np.arange(count), 2),
        labels(["end"] * 2 * count),
        labels(["resistor"] * count),
        node_label,
    )


def test_every_link_of_a_chain_gets_a_colour_of_its_own() -> None:
    structure = chain(8)
    colours = first_colours(structure, np.zeros(8, dtype=np.uint64))
    assert class_count(colours) == 3  # the port, other nodes, devices
    counts = []
    for _ in range(9):
        colours = refine(structure, colours)
        counts.append(class_count(colours))
    assert counts[-1] == counts[-2] == 8 + 9
    assert sorted(counts) == counts


def test_a_colour_depends_on_nothing_but_the_structure() -> None:
    structure = chain(4)
    start = first_colours(structure, np.zeros(4, dtype=np.uint64))
    one, two = refine(structure, start), refine(structure, start)
    assert (one.device == two.device).all()
    assert (one.node == two.node).all()
    assert label("resistor") == label("resistor") != label("capacitor")
