"""Lines of the generator on dies: the operating point of its circuit, and shared where a chip shares them."""

import math
from dataclasses import replace
from statistics import mean, stdev

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.bias import bias_voltages, die_current, lone_voltages, rebias
from circuits.blocks.bias.generator import Params, build, output_current
from circuits.blocks.bias.generator import testbench as block_bench
from circuits.circuit import Bias, BiasKind, Circuit, Instance, Port
from circuits.devices import Source, Transistor
from circuits.devices.source import Constant
from circuits.devices.transistor import drain_current
from circuits.errors import ParameterError, SolverError
from circuits.generator.circuit import MASTER_CURRENT, line, line_sizes, masters
from circuits.generator.code import codes_of, currents_of
from circuits.generator.voltage import GENERATOR, Line, line_voltages, lone_line_voltages, resistor_of
from circuits.lowering.kernel import Machine, to_kernel
from circuits.place import circuit_at
from circuits.registry import load_block
from circuits.silicon.die import NOMINAL, Die, Path
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, ROLLS_180, ROLLS_180_IDEAL, Polarity, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

CHIP = (("chip", ()),)
DIES = range(1000, 1060)
LAWS = pytest.mark.parametrize(
    "process",
    [AMI_1500_IDEAL, AMI_1500, ROLLS_180_IDEAL, ROLLS_180],
    ids=["ami", "ami-full", "rolls", "rolls-full"],
)


def biased(polarity: Polarity = "n") -> Transistor:
    bulk = "0" if polarity == "n" else "vdd"
    return Transistor("m", polarity, "out", "gate", bulk, bulk, 6e-6, 6e-6)


def cell(current: float | tuple[float, ...], polarity: Polarity = "n") -> Circuit:
    shape = np.shape(current)
    device = replace(biased(polarity), gate="gate[0]" if shape else "gate")
    ports = (Port("vdd", "supply"), Port("gate", "bias", shape=shape), Port("out", "analog"))
    return Circuit("cell", ports, (device,), biases=(Bias("i", "gate", "generator", current, "m"),))


def volts(circuit: Circuit, silicon: Silicon) -> F64:
    return bias_voltages(circuit, circuit.bias("i"), silicon)


def current(wanted: float, silicon: Silicon) -> float:
    circuit = cell(wanted)
    return die_current(circuit, circuit.bias("i"), silicon)


def code_for(wanted: float) -> tuple[int, int]:
    coarse, fine = codes_of(np.array(wanted)).tolist()
    return coarse, fine


def whole(code: tuple[int, int], device: Transistor, silicon: Silicon) -> Machine:
    """Masters and one line as a circuit, on the deviations that both have on a chip's die."""
    coarse, fine = code
    sizes = line_sizes(silicon.process)
    shared, own = masters(resistor_of(silicon.process), sizes), line(fine, device, sizes[coarse])
    joined = tuple(
        replace(d, gate=f"range_{coarse}") if isinstance(d, Transistor) and d.gate == "range_n" else d
        for d in own
    )
    circuit = Circuit("generator", (Port("vdd", "supply"),), (*shared, *joined))
    supply = Source("vdd", "vdd", Constant(silicon.process.v_dd))
    machine = to_kernel(Testbench("generator", circuit, (supply,), 1.0), replace(silicon, die=Die()))
    kernel = machine.kernel
    transistors = [d for d in circuit.devices if isinstance(d, Transistor)]
    there: list[Path] = [
        (GENERATOR, ("gate", ()) if d in joined else ("shared masters", ()), (d.name, ()))
        for d in transistors
    ]
    areas = np.array([d.gate_area for d in transistors])
    v_t0, beta = replace(silicon, place=CHIP).deviations("", there, areas)
    laws = [silicon.law(d.polarity) for d in transistors]
    moved = np.array([law.v_t0 for law in laws]) + v_t0
    square = np.array([law.square_current * d.square for law, d in zip(laws, transistors, strict=True)])
    own_arrays = kernel.transistors._replace(v_t0=moved, specific_current=square * (1.0 + beta))
    return replace(machine, kernel=kernel._replace(transistors=own_arrays))


@pytest.mark.parametrize(
    "process", [AMI_1500_IDEAL, AMI_1500, ROLLS_180_IDEAL, ROLLS_180], ids=lambda p: p.name
)
@pytest.mark.parametrize(
    ("number", "celsius", "wanted", "polarity"),
    [(2001, 27.0, 100e-12, "n"), (2002, -10.0, 5e-9, "p"), (2003, 60.0, 1e-6, "n"), (2004, 27.0, 2e-12, "p")],
)
def test_a_line_is_at_the_operating_point_of_its_circuit(
    process: Process, number: int, celsius: float, wanted: float, polarity: Polarity
) -> None:
    silicon = Silicon(process, celsius, Die("A", number))
    lines = Line(CHIP, "gate", (), None, biased(polarity))
    found = float(line_voltages(lines, np.array(wanted), silicon))
    point = operating_point(whole(code_for(wanted), biased(polarity), silicon))
    # 1e-9 V is where either solver ends
    assert found == pytest.approx(point["v_n" if polarity == "n" else "v_p"], abs=1e-8)


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, ROLLS_180], ids=lambda p: p.name)
def test_many_lines_at_once_are_each_alone(process: Process) -> None:
    silicon = Silicon(process, die=Die("A", 1003))
    wanted = (1e-12, 80e-12, 3e-9, 2e-6)
    lines = Line(CHIP, "gate", (4,), None, biased())
    together = line_voltages(lines, np.array(wanted), silicon)
    alone = [line_voltages(replace(lines, index=(k,)), np.array(i), silicon) for k, i in enumerate(wanted)]
    assert together == pytest.approx(np.array(alone), abs=1e-9)
    assert np.unique(line_voltages(lines, np.full(4, 1e-9), silicon)).size == 4


@pytest.mark.parametrize("die", [NOMINAL, Die("A", 1003)], ids=["nominal", "drawn"])
@pytest.mark.parametrize("process", [AMI_1500_IDEAL, ROLLS_180], ids=lambda p: p.name)
def test_lone_lines_side_by_side_are_each_alone_to_the_last_bit(process: Process, die: Die) -> None:
    silicon = Silicon(process, 40.0, die)
    wanted = (2e-12, 80e-12, 3e-9, 0.2e-6, 2e-6)
    polarities: tuple[Polarity, ...] = ("n", "p", "p", "n", "p")
    lines = [Line(CHIP, f"port {k}", (), None, biased(p)) for k, p in enumerate(polarities)]
    currents = [np.array(current) for current in wanted]
    alone = [float(line_voltages(*each, silicon)) for each in zip(lines, currents, strict=True)]
    assert lone_line_voltages(lines, currents, silicon) == alone
    # of which some are known, and another code is asked of one
    currents[1] = np.array(1e-9)
    alone[1] = float(line_voltages(lines[1], currents[1], silicon))
    assert lone_line_voltages(lines, currents, silicon) == alone


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, ROLLS_180_IDEAL], ids=lambda p: p.name)
def test_the_nominal_line_gives_its_code_s_current_and_follows_the_temperature(process: Process) -> None:
    for wanted in (100e-12, 10e-9, 1e-6):
        for celsius in (-10.0, 27.0, 60.0):
            silicon = Silicon(process, celsius)
            ptat = float(currents_of(codes_of(np.array(wanted)))) * (celsius + 273.15) / 300.15
            # 1 %: splitters and mirrors without mismatch; below 1 nA warm devices leak 4 % more and beyond
            if wanted > 1e-9 or celsius < 0.0:
                assert current(wanted, silicon) == pytest.approx(ptat, rel=0.01)


@pytest.mark.parametrize(
    "process", [AMI_1500_IDEAL, AMI_1500, ROLLS_180_IDEAL, ROLLS_180], ids=lambda p: p.name
)
def test_the_resistor_makes_the_master_current_of_its_process(process: Process) -> None:
    nominal = Silicon(process)
    supply = Source("vdd", "vdd", Constant(nominal.process.v_dd))
    resistance = resistor_of(nominal.process)
    circuit = Circuit("masters", (Port("vdd", "supply"),), masters(resistance, line_sizes(process)))
    point = operating_point(Testbench("masters", circuit, (supply,), 1.0), nominal)
    assert point["core_r"] / resistance == pytest.approx(MASTER_CURRENT, rel=1e-6)
    assert resistor_of(AMI_1500_IDEAL) == pytest.approx(147.93e3, rel=1e-4)  # the block's


@pytest.mark.parametrize(
    ("celsius", "wanted", "least", "most"),
    # Shares of the code. A 1/9 device carries 0.005, 0.10 and 0.86 pA with its gate at its source, which
    # keeps it from less; 0.1 pA is twice the least code
    [(-10.0, 0.1e-12, 0.95, 1.30), (27.0, 0.5e-12, 0.95, 1.20), (27.0, 1e-12, 0.95, 1.08),
     (27.0, 2e-12, 0.95, 1.03), (27.0, 100e-12, 0.95, 1.03), (60.0, 5e-12, 0.95, 1.10)],
)  # fmt: skip
@pytest.mark.parametrize("process", [ROLLS_180_IDEAL, ROLLS_180], ids=["ideal", "full"])
@pytest.mark.parametrize("polarity", ["n", "p"])
def test_a_line_of_0_18_um_follows_its_code_below_a_picoampere(
    polarity: Polarity, process: Process, celsius: float, wanted: float, least: float, most: float
) -> None:
    circuit = cell(wanted, polarity)
    device = replace(biased(polarity), width=1e-6, length=9e-6)
    found = die_current(replace(circuit, devices=(device,)), circuit.bias("i"), Silicon(process, celsius))
    ptat = float(currents_of(codes_of(np.array(wanted)))) * (celsius + 273.15) / 300.15
    assert least < found / ptat < most


def test_lines_of_a_chip_share_its_masters_and_have_their_own_splitters() -> None:
    wanted = (1e-6, 1e-6)
    dies = [volts(cell(wanted), Silicon(AMI_1500_IDEAL, die=Die("A", n, process=False))) for n in DIES]
    both = np.array(dies)
    apart = np.abs(both[:, 0] - both[:, 1])
    assert apart.min() > 0.0
    # the masters' share of the variance is common to both lines; without it they would not go together
    assert np.corrcoef(both.T)[0, 1] > 0.2


def test_a_part_of_a_chip_has_the_line_of_its_chip() -> None:
    part = replace(cell(1e-9), name="part")
    ports = (Port("vdd", "supply"), Port("b", "bias"), Port("out", "analog"))
    wires = {"vdd": "vdd", "gate": "b", "out": "out"}
    bias = Bias("i_b", "b", "generator", 2e-9, "cell.m")
    chip = Circuit("chip", ports, (), (Instance("cell", part, wires),), biases=(bias,))
    silicon = Silicon(AMI_1500_IDEAL, die=Die("A", 1007))
    inner, place = circuit_at(chip, (("cell", ()),))
    there = bias_voltages(inner, inner.bias("i"), replace(silicon, place=place))
    assert there == pytest.approx(bias_voltages(chip, bias, silicon), abs=1e-12)


def test_spread_over_dies_is_the_block_s() -> None:
    # CV of the block at 100 pA over these 60 dies: 15.3 %. Two standard deviations of 60 draws differ by 13 %
    # (one sigma) of each other; within 2.5 of that
    ours = [current(100e-12, Silicon(AMI_1500_IDEAL, die=Die("A", n))) for n in DIES]
    circuit = build(Params(*code_for(100e-12)))
    bench = block_bench(circuit, {"output": 2.5, "duration": None}, 5.0)
    block = [output_current(operating_point(bench, Silicon(AMI_1500_IDEAL, die=Die("A", n)))) for n in DIES]
    assert stdev(block) / mean(block) == pytest.approx(0.153, abs=0.001)
    assert stdev(ours) / mean(ours) == pytest.approx(stdev(block) / mean(block), rel=0.33)


@pytest.mark.parametrize(("process", "least", "most"), [(AMI_1500_IDEAL, 0.0, 1e-4), (AMI_1500, 0.04, 0.08)])
def test_a_supply_moves_a_line_by_the_early_effect_alone(process: Process, least: float, most: float) -> None:
    # shares of the current a volt; mirrors of devices 3 to 6 um long at 10 V/um move by some per cent each
    nominal = Silicon(process)
    law = nominal.law("n")

    def at(v_dd: float) -> float:
        lines = Line(CHIP, "gate", (), None, biased())
        silicon = Silicon(replace(process, v_dd=v_dd))
        gate = line_voltages(lines, np.array(100e-12), silicon, resistor_of(process))
        return float(drain_current(law, "n", 6e-6, 6e-6, 2.5, gate, 0.0).item())

    slope = math.log(at(5.25) / at(4.75)) / 0.5
    assert least <= slope <= most


def test_a_supply_without_room_is_told() -> None:
    with pytest.raises(SolverError, match=r"no operating point at 0.01 V .* give a higher supply"):
        volts(cell(100e-12), Silicon(replace(AMI_1500_IDEAL, v_dd=0.01)))


def test_biases_of_all_kinds_together_are_each_alone() -> None:
    device = biased()
    kinds: tuple[BiasKind, ...] = ("generator", "gate", "voltage", "ideal", "generator")
    biases = tuple(
        Bias(f"i{k}", f"gate{k}", kind, 1e-9 * (k + 1), None if kind == "voltage" else "m")
        for k, kind in enumerate(kinds)
    )
    ports = (Port("vdd", "supply"), Port("out", "analog"), *(Port(b.port, "bias") for b in biases))
    circuit = Circuit("cell", ports, (replace(device, gate="gate0"),), biases=biases)
    silicon = Silicon(ROLLS_180, 27.0, Die("A", 1004))
    wanted = {b.port: float(bias_voltages(circuit, b, silicon)) for b in biases}
    assert lone_voltages(circuit, biases, silicon) == wanted


def test_of_biases_together_the_one_that_no_code_reaches_is_named() -> None:
    circuit = cell(1e-3)
    with pytest.raises(ParameterError, match=r"cell\.i: bias code: 0.001 A, must be > 0 and at most"):
        lone_voltages(circuit, circuit.biases, Silicon(AMI_1500_IDEAL))


def test_what_no_code_reaches_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"cell\.i: bias code: 0.001 A, must be > 0 and at most"):
        volts(cell(1e-3), Silicon(AMI_1500_IDEAL))


@pytest.mark.parametrize("variation", ["transistors", "full"])
def test_a_die_with_components_of_variation_has_its_lines(variation: str) -> None:
    """A block biased by the generator on such a die: its shared part moves, so its lines do."""
    block = load_block("rebound-neuron")
    circuit = rebias(block.build(), kind="generator")
    bias = circuit.bias("i_rtau")
    plain, varied = (
        bias_voltages(circuit, bias, Silicon(block.process, die=Die("A", 2001, variation=each)))  # type: ignore[arg-type]
        for each in ("plain", variation)
    )
    assert np.isfinite(varied).all()
    assert 1e-4 < abs(float(varied) - float(plain)) < 0.3
