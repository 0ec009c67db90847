"""A line is the gate of its output device at the code's current, and errs as its splitter and its die do."""

import pytest

from chips.coach.generator import (
    IDEAL_BITS,
    Code,
    Generator,
    line_current,
    line_share,
    line_voltage,
    master_named,
)
from circuits.bias import bias_voltages, gate_voltage, rebias
from circuits.blocks.bench import differential_pair, transamp
from circuits.blocks.bench.bias import MASTERS
from circuits.errors import ParameterError
from circuits.lowering.on_die import transistor_of
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.process_file import process_of
from circuits.silicon.silicon import Silicon

NOMINAL = Silicon(ROLLS_180)
IDEAL = Generator(IDEAL_BITS)


def test_a_code_is_its_share_of_the_master() -> None:
    for master in MASTERS:
        current = line_current(IDEAL, "X", Code("N", master, 50), NOMINAL)
        assert current == pytest.approx(master * 50 / 256)
    scaled = Generator(IDEAL_BITS, {MASTERS[3]: 2.4})
    assert line_current(scaled, "X", Code("N", MASTERS[3], 50), NOMINAL) == pytest.approx(
        2.4 * 30e-9 * 50 / 256
    )
    warm = line_current(IDEAL, "X", Code("N", MASTERS[0], 50), Silicon(ROLLS_180, 57.0))
    assert warm == pytest.approx(60e-12 * 50 / 256 * 330.15 / 300.15)


def test_a_line_s_own_bits_factor_and_codes_come_first() -> None:
    own = Generator(
        lines={"X": (2.0, *IDEAL_BITS[1:])}, factors={"X": 1.5}, codes={("X", MASTERS[3], 3): 1.2}
    )
    shares = [
        line_share(own, name, Code("N", MASTERS[3], k), NOMINAL) * 256 for name in "XY" for k in (1, 3, 4)
    ]
    assert shares == pytest.approx([1.5 * 2.0, 1.5 * 1.2 * 3.0, 1.5 * 4.0, 1.12, 1.12 + 1.05 * 2.0, 4.0])
    with pytest.raises(ParameterError, match=r"generator.X: 1, must be eight"):
        Generator(lines={"X": (1.0,)})


def test_a_line_may_be_the_gate_of_a_device_of_the_biased_one_s_size() -> None:
    silicon, code = Silicon(process_of("coach-180")), Code("P", MASTERS[3], 50)
    tail = transistor_of(transamp.with_pfets(), "open.mb")
    ruled = Generator(IDEAL_BITS, reference="biased")
    above = 1.8 - line_voltage(ruled, "X", code, silicon, tail)
    asked = 3.0 * tail.square * 30e-9 * 50 / 256
    assert above == pytest.approx(gate_voltage(silicon.law("p"), tail, asked), abs=1e-9)
    # by 12 um of length this process has 24 mV less of V_T0 than by 1 um
    assert above - (1.8 - line_voltage(IDEAL, "X", code, silicon, tail)) > 0.015


def test_a_line_is_the_block_s_own_bias() -> None:
    circuit = rebias(differential_pair.build(), kind="gate")
    of_block = float(bias_voltages(circuit, circuit.bias("i_tail"), NOMINAL))
    # a square's threefold of 4 um by 12 um: the Early effect of 1 um against 12 um is 1 mV
    assert line_voltage(IDEAL, "X", Code("N", MASTERS[3], 50), NOMINAL) == pytest.approx(of_block, abs=3e-3)


def test_the_other_type_parks_a_gate() -> None:
    assert line_voltage(IDEAL, "X", Code("P", MASTERS[3], 0), NOMINAL) == 1.8
    assert line_voltage(IDEAL, "X", Code("N", MASTERS[3], 0), NOMINAL) == 0.0
    small, large = (line_voltage(IDEAL, "X", Code("P", MASTERS[3], k), NOMINAL) for k in (1, 255))
    assert 1.2 < large < small < 1.7


def test_codes_step_down_where_a_bit_is_worth_less() -> None:
    current = [line_current(Generator(), "X", Code("N", MASTERS[3], k), NOMINAL) for k in (31, 32, 63, 64)]
    assert current[1] < current[0]
    assert current[3] < current[2]


def test_a_die_s_lines_deviate_each_by_itself_and_alike_each_time() -> None:
    on_die = Silicon(ROLLS_180, die=Die(number=1000))
    one, other = (line_current(IDEAL, name, Code("N", MASTERS[3], 85), on_die) for name in ("A", "B"))
    assert one != other
    assert abs(one / other - 1.0) < 0.2
    assert one == line_current(IDEAL, "A", Code("N", MASTERS[3], 85), on_die)
    volts = {
        line_voltage(IDEAL, "A", Code("N", MASTERS[3], 85), Silicon(ROLLS_180, die=Die(number=k)))
        for k in range(1000, 1003)
    }
    assert len(volts) == 3


def test_what_the_generator_lacks_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"bias fine code: 256, must be a whole number from 0 to 255"):
        Code("N", MASTERS[0], 256)
    with pytest.raises(ParameterError, match=r"bias type: 'Q', must be N or P"):
        Code("Q", MASTERS[0], 1)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"bias master: '1nA', must be one of 60pA, 460pA"):
        master_named("1nA")
    with pytest.raises(ParameterError, match=r"generator.bits: 3, must be eight"):
        Generator((1.0, 1.0, 1.0))
    assert master_named("3.8 nA") == 3.8e-9


def test_a_splitter_of_unit_devices_is_in_the_range_of_the_measured_process() -> None:
    measured = Silicon(process_of("coach-180"), die=Die(number=1000))
    current = line_current(IDEAL, "X", Code("N", MASTERS[3], 128), measured)
    assert current == pytest.approx(15e-9, rel=0.1)
