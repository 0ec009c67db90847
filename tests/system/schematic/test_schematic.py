"""Schematics of every block: nothing overlaps, wires meet no other net, each terminal is drawn or named."""

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from circuits.blocks.drive import current_into
from circuits.blocks.mos import mos
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor
from circuits.devices.device import Device
from circuits.errors import ParameterError
from circuits.registry import block_names, load_block
from system.cli.command_line import main
from system.schematic.geometry import GATE, HALF, Box, Layout, Symbol, Wire
from system.schematic.part import MANY, Part, cells_of, parts_of, rails_of
from system.schematic.picture import Solved, draw_schematic, layout_of
from system.schematic.placement import pairs, place
from system.schematic.symbol import shape_of
from tests.pictures import figure_of_files


def overlaps(layout: Layout) -> list[tuple[object, object]]:
    """Symbols, labels and rails that have an inner point in common; within 1e-6 points."""
    things = [
        (thing, Box(b.left + 1e-6, b.bottom + 1e-6, b.right - 1e-6, b.top - 1e-6))
        for thing in (*layout.symbols, *layout.labels, *layout.rails)
        for b in (thing.box,)
    ]
    return [(a, b) for (a, one), (b, other) in combinations(things, 2) if one.overlaps(other)]


def span(w: Wire) -> Box:
    return Box(min(w.x0, w.x1), min(w.y0, w.y1), max(w.x0, w.x1), max(w.y0, w.y1))


def touches(a: Box, b: Box) -> bool:
    near = 1e-6
    across = a.left <= b.right + near and b.left <= a.right + near
    return across and a.bottom <= b.top + near and b.bottom <= a.top + near


def shorts(layout: Layout) -> list[tuple[Wire, Wire]]:
    """Wires of different nets that touch."""
    spans = [(w, span(w)) for w in layout.wires]
    return [
        (a, b) for (a, one), (b, other) in combinations(spans, 2) if a.net != b.net and touches(one, other)
    ]


def struck(layout: Layout) -> list[tuple[Wire, object]]:
    """Wires that run through a label, or through a symbol none of whose terminals is on their net."""
    labels = [(label, inside(label.box, 0.1)) for label in layout.labels]
    symbols = [(symbol, inside(symbol.box, 1.0)) for symbol in layout.symbols]
    found: list[tuple[Wire, object]] = []
    for w in layout.wires:
        at = span(w)
        found += [(w, label) for label, inner in labels if touches(at, inner)]
        for symbol, inner in symbols:
            p = symbol.part
            if touches(at, inner) and w.net not in {p.top, p.bottom, *p.left, *p.right}:
                found.append((w, symbol))
    return found


def inside(b: Box, margin: float) -> Box:
    return Box(b.left + margin, b.bottom + margin, b.right - margin, b.top - margin)


def terminals(symbol: Symbol) -> Iterator[tuple[str, float, float]]:
    """Net and place of each terminal of a symbol."""
    part, turn = symbol.part, -1.0 if symbol.flipped else 1.0
    yield part.top, symbol.x, symbol.y + HALF
    yield part.bottom, symbol.x, symbol.y - HALF
    for nets, side in ((part.left, -turn), (part.right, turn)):
        rises = (0.0,) if len(nets) == 1 else (10.0, -10.0)
        for net, rise in zip(nets, rises, strict=False):
            yield net, symbol.x + side * GATE, symbol.y + rise


def unnamed(layout: Layout) -> list[tuple[str, str]]:
    """Terminals from which no wire of their net leads to a label, or a rail, of that net."""
    lost = []
    marks = [(label.net, label.box) for label in layout.labels if label.net]
    marks += [(rail.net, rail.box) for rail in layout.rails]
    for symbol in layout.symbols:
        for net, x, y in terminals(symbol):
            spans = [span(w) for w in layout.wires if w.net == net]
            reached, grown = [Box(x, y, x, y)], True
            while grown:
                new = [box for box in spans if box not in reached]
                new = [box for box in new if any(touches(box, r) for r in reached)]
                reached, grown = reached + new, bool(new)
            near = [Box(r.left - 5.0, r.bottom - 2.0, r.right + 5.0, r.top + 2.0) for r in reached]
            if not any(net == named and touches(box, r) for named, box in marks for r in near):
                lost.append((symbol.part.name, net))
    return lost


@pytest.mark.parametrize("name", block_names())
def test_nothing_overlaps_and_each_net_is_drawn_or_named(name: str) -> None:
    block = load_block(name)
    circuit = block.build(block.sizes)
    volts = {n: -1.234 for p in parts_of(circuit) for n in (p.top, p.bottom, *p.left, *p.right)}
    for solved in (Solved(), Solved(volts, {p.name: 123.4e-12 for p in parts_of(circuit)})):
        layout = layout_of(circuit, solved=solved)
        assert overlaps(layout) == []
        assert shorts(layout) == []
        assert struck(layout) == []
        assert unnamed(layout) == []


def test_what_overlaps_or_is_lost_would_be_found() -> None:
    layout = layout_of(follower())
    first = layout.symbols[0]
    layout.symbols.append(first._replace(x=first.x + 5.0, box=Box(*(v + 5.0 for v in first.box))))
    assert overlaps(layout) != []
    layout = layout_of(follower())
    layout.labels = [label for label in layout.labels if label.net != "v_s"]
    assert {net for _, net in unnamed(layout)} == {"v_s"}
    layout = layout_of(follower())
    at = layout.symbols[0]
    layout.wires.append(Wire("v_in", at.x - 9.0, at.y + 3.0, at.x + 9.0, at.y + 3.0))
    assert len(struck(layout)) == 2  # the transistor, and its size
    layout.wires.append(Wire("v_in", at.x - 9.0, at.y + HALF, at.x + 9.0, at.y + HALF))
    assert {b.net for _, b in shorts(layout)} | {a.net for a, _ in shorts(layout)} == {"v_in", "v_s"}


@pytest.mark.parametrize("name", block_names())
def test_each_device_is_drawn_or_counted(name: str) -> None:
    block = load_block(name)
    circuit = block.build(block.sizes)
    layout, parts = layout_of(circuit), parts_of(circuit)
    assert [s.part for s in layout.symbols] == list(parts)
    assert bool(cells_of(circuit)) <= (len(circuit.instances) > 0)
    assert all(len(part.lines) * 10.0 <= 2.0 * HALF for part in parts)


def follower() -> Circuit:
    devices = (
        mos("tail", "n", "v_s", "v_b", "0", 6, 6),
        mos("plus", "n", "v_d", "v_in", "v_s", 6, 6),
        mos("minus", "n", "v_out", "v_fb", "v_s", 6, 6),
        mos("diode", "p", "v_d", "v_d", "vdd", 6, 6),
        mos("copy", "p", "v_out", "v_d", "vdd", 6, 6),
        Capacitor("c", "v_out", "0", 1e-12),
    )
    return Circuit("follower", (Port("vdd", "supply"), Port("v_in", "analog"), Port("v_b", "bias")), devices)


def test_pairs_and_mirrors_are_side_by_side_and_current_flows_down() -> None:
    parts, rails = parts_of(follower()), rails_of(follower())
    names = [p.name for p in parts]
    kinds = {(names[i], names[j]): kind for (i, j), kind in pairs(parts, rails.high | rails.low).items()}
    assert kinds == {("plus", "minus"): "pair", ("diode", "copy"): "mirror"}
    at = dict(zip(names, place(parts, rails, ["v_in"]), strict=True))
    assert [at[n].row for n in ("diode", "copy", "plus", "minus", "tail")] == [0, 0, 1, 1, 2]
    assert at["diode"].column == at["plus"].column
    assert abs(at["diode"].column - at["copy"].column) == 1
    left, right = sorted(("diode", "copy"), key=lambda n: at[n].column)
    assert (at[left].flipped, at[right].flipped) == (True, False)  # gate to gate
    left, right = sorted(("plus", "minus"), key=lambda n: at[n].column)
    assert (at[left].flipped, at[right].flipped) == (False, True)  # gates outside
    wires = [w for w in layout_of(follower()).wires if w.net == "v_d" and w.y0 == w.y1]
    assert max(abs(w.x1 - w.x0) for w in wires) > GATE  # from gate to gate


def test_the_arrow_of_a_transistor_is_at_its_source_along_the_current() -> None:
    n, p = (Part("", kind, "a", "b", ("g",), source_up=up) for kind, up in (("nfet", False), ("pfet", True)))
    for part, height, direction in ((n, -9.0, 1.0), (p, 9.0, -1.0)):
        tip, base, _ = shape_of(part).filled[0]
        assert tip[1] == height
        assert (tip[0] - base[0]) * direction > 0.0


def test_texts_fit_their_boxes() -> None:
    figure = figure_of_files()
    circuit = follower()
    draw_schematic(circuit, figure)
    figure.draw_without_rendering()
    boxes = {label.text: label.box for label in layout_of(circuit).labels}
    scale = 72.0 / figure.dpi
    texts = [t for t in figure.axes[0].texts if t.get_text() in boxes]
    assert len(texts) == len(layout_of(circuit).labels)
    for text in texts:
        seen, box = text.get_window_extent(), boxes[text.get_text()]
        assert seen.width * scale <= box.right - box.left + 0.7  # hinting rounds to pixels
        assert seen.height * scale <= box.top - box.bottom + 0.7


def test_the_command_writes_it_with_the_operating_point(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "s.svg"
    assert main(["show", "nef-neuron", "--schematic", str(path), "--op"]) == 0
    drawn = path.read_text()
    assert "mc4" in drawn
    assert "0.5/16um" in drawn
    assert "operating point at 27 degC, die nominal" in drawn
    assert "mV" in drawn
    assert "pA" in drawn
    capsys.readouterr()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nef-neuron", "--op"), "--op"),
        (("nef-neuron", "--schematic", "s.svg", "--stimulus", "current=1nA"), "--stimulus"),
        (("rolls", "--schematic", "s.svg"), "--schematic"),
        (("nef-chip", "--schematic", "s.svg"), "--schematic"),
        (("nef-neuron", "--schematic", "s.gif"), "s.gif"),
    ],
)
def test_what_has_no_schematic_is_refused(
    arguments: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["show", *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_source_of_a_testbench_is_drawn() -> None:
    layout = layout_of(follower(), [current_into("v_out", 1e-9)])
    assert [s.part.kind for s in layout.symbols].count("current source") == 1
    assert overlaps(layout) == []


def test_a_supply_that_only_gates_are_at_is_no_rail() -> None:
    ports = (Port("vdd", "supply"), Port("a", "supply"), Port("vss", "supply"))
    circuit = Circuit("one", ports, (mos("m", "p", "vss", "a", "vdd", 6, 6),))
    assert rails_of(circuit).high == {"vdd"}
    assert rails_of(circuit).low == {"0", "vss"}


def test_a_circuit_without_devices_is_refused() -> None:
    with pytest.raises(ParameterError, match="0 devices"):
        layout_of(Circuit("empty"))


def test_large_arrays_are_drawn_by_one_cell() -> None:
    block = load_block("winner-take-all")
    circuit = block.build(block.sizes)
    parts = parts_of(circuit)
    assert len(parts) < MANY
    assert cells_of(circuit) == {"cell": 9}
    assert "x9 in all" in {line for part in parts for line in part.lines}


def random_circuit(seed: int) -> Circuit:
    """Devices of every type between random nets: circles of current, shorted and upside down ones too."""
    draw = np.random.default_rng(seed)
    nets = ["0", "vdd", *(f"n{k}" for k in range(draw.integers(2, 9)))]
    devices: list[Device] = []
    for k in range(draw.integers(1, 20)):
        a, b, c, d = (nets[j] for j in draw.integers(len(nets), size=4))
        devices.append(
            (
                mos(f"d{k}", "n", a, b, c, 6, 6),
                mos(f"d{k}", "p", a, b, c, 6, 6),
                Resistor(f"d{k}", a, b, 1e6),
                Capacitor(f"d{k}", a, b, 1e-12),
                ControlledSource(f"d{k}", a, b, c, d, 1e-6),
                OperationalAmplifier(f"d{k}", a, b, c, "vdd"),
            )[draw.choice(6, p=[0.3, 0.3, 0.1, 0.1, 0.1, 0.1])]
        )
    ports = (Port("vdd", "supply"), Port("n0", "analog"), Port("n1", "event", "out"))
    return Circuit("random", ports, tuple(devices))


@pytest.mark.parametrize("seed", range(0, 30, 3))
def test_circuits_that_nobody_designed_are_drawn_too(seed: int) -> None:
    for k in range(seed, seed + 3):
        layout = layout_of(random_circuit(k))
        assert overlaps(layout) == []
        assert shorts(layout) == []
        assert struck(layout) == []
        assert unnamed(layout) == []
