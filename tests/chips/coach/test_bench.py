"""The bench's verbs: what is set is what the transistors get, and what is read is what they give."""

import numpy as np
import pytest

from chips.coach.bench import CoachBench
from chips.coach.chip import circuits
from chips.coach.generator import IDEAL_BITS, Generator
from chips.coach.readout import ADC_STEP
from chips.coach.wiring import CIRCUITS
from circuits.blocks.bench import differential_pair
from circuits.errors import ParameterError, SolverError, UnknownNameError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import simulate

IDEAL = Generator(IDEAL_BITS)


def pair(die: int | None = None, seed: int = 0) -> CoachBench:
    silicon = Silicon(ROLLS_180) if die is None else Silicon(ROLLS_180, die=Die(number=die))
    bench = CoachBench(silicon, generator=IDEAL, seed=seed)
    bench.set_bias("NDP_VB_N", "N", 30e-9, 50)
    bench.set_voltage("AIN5", 0.95)
    bench.set_voltage("AIN6", 0.85)
    return bench


def test_a_reading_is_the_block_s_own_current() -> None:
    bench = pair()
    one, other = bench.exact("C2F0"), bench.exact("C2F1")
    result = simulate(differential_pair.BLOCK.bench(), Silicon(ROLLS_180))
    ratio = float(
        np.interp(0.1, result["v1"] - result["v2"], drain_current(result, "m1") / drain_current(result, "m2"))
    )
    # the DAC cuts both voltages: 0.9 and 0.4 mV of 100 mV
    assert one / other == pytest.approx(ratio, rel=0.05)
    # the tail of 1 um has 0.37 V over an Early voltage of 4.75 V, the output device of 12 um none to speak of
    assert one + other == pytest.approx(1.08 * 3.0 * 30e-9 * 50 / 256, rel=0.01)


def test_readings_hang_on_die_and_seed_alone() -> None:
    assert pair(1000).read_counts("C2F1") == pair(1000).read_counts("C2F1")
    assert pair(1000).exact("C2F1") != pair(1001).exact("C2F1")
    again = [pair(1000, seed).read_counts("C2F0") for seed in range(4)]
    assert len(set(again)) > 1


def test_a_transistor_is_read_through_the_range_s_shunt() -> None:
    bench = CoachBench()
    bench.select("NFET")
    bench.set_voltage("GO22", 1.8)
    bench.set_voltage("AIN0", 0.55)
    low = bench.exact("GO20")
    assert bench.read_current("GO20") == pytest.approx(low, abs=0.25e-9)
    bench.set_range("high")
    assert bench.exact("GO20") > 1.1 * low
    assert bench.read_current("GO20") == 0.0  # below 2 uA
    with pytest.raises(ParameterError, match=r"range: 'middle', must be low or high"):
        bench.set_range("middle")


def test_a_circuit_with_hysteresis_stays_on_its_branch() -> None:
    bench = CoachBench(generator=IDEAL)
    bench.select("WTA")
    for pin in CIRCUITS["WTA"].inputs:
        bench.set_voltage(pin, 1.8)
    bench.set_voltage("AIN1", 1.65)
    for name, kind, fine in (("WTA_VB_N", "N", 100), ("WTA_VGAIN_P", "P", 2), ("WTA_VINH_N", "P", 0)):
        bench.set_bias(name, kind, 30e-9, fine)  # type: ignore[arg-type]
    leads = []
    for volt in (1.75, 1.65, 1.55, 1.65, 1.75):
        bench.set_voltage("AIN0", volt)
        leads.append(bench.read_voltage("ADC15") > bench.read_voltage("ADC14"))
    assert leads == [False, False, True, True, False]


def test_a_record_follows_a_step_and_counts() -> None:
    bench = CoachBench(generator=IDEAL)
    bench.select("FOI")
    bench.set_bias("FOI_VB_N", "N", 460e-12, 37)
    bench.set_voltage("AIN9", 0.9)
    record = bench.record(["ADC10"], 50, 40e-6, steps={"AIN9": 1.2})
    v = record.values["ADC10"]
    assert v[0] == pytest.approx(0.9, abs=0.02)
    assert v[25] - v[15] == pytest.approx(10 * 40e-6 * 220.0, rel=0.1)  # at I_b / C
    assert np.allclose(v / ADC_STEP, np.round(v / ADC_STEP))
    assert bench.read_voltage("ADC10") == pytest.approx(1.2, abs=0.02)


def test_a_synapse_answers_an_event() -> None:
    bench = CoachBench(generator=IDEAL)
    bench.select("DPI")
    for name, kind, master, fine in (
        ("DPI_VTAU_P", "P", 60e-12, 25), ("DPI_VTHR_N", "P", 60e-12, 30),
        ("DPI_VWEIGHT_N", "N", 30e-9, 100), ("PEX_VTAU_N", "N", 60e-12, 10),
    ):  # fmt: skip
        bench.set_bias(name, kind, master, fine)  # type: ignore[arg-type]
    record = bench.record(["ADC14", "C2F9"], 12, 25e-3, events=[1e-3])
    assert record.values["ADC14"].min() < 1.5
    assert record.values["C2F9"][:3].min() > 300
    assert record.values["C2F9"][-4:].max() < 10


def test_what_cannot_be() -> None:
    bench = pair()
    with pytest.raises(UnknownNameError, match=r"circuit of coach NPD: unknown; did you mean NDP"):
        bench.select("NPD")
    with pytest.raises(UnknownNameError, match=r"pin of coach.NDP AIN9: unknown"):
        bench.set_voltage("AIN9", 0.5)
    with pytest.raises(ParameterError, match=r"NDP_VB_N: bias fine code: 256, must be a whole number"):
        bench.set_bias("NDP_VB_N", "N", 30e-9, 256)
    with pytest.raises(ParameterError, match=r"AIN5: 2.4 V, must be within 0 V and the supply of 1.8 V"):
        bench.set_voltage("AIN5", 2.4)
    with pytest.raises(ParameterError, match=r"coach.NDP: no events come in here"):
        bench.record(["C2F0"], 10, 1e-3, events=[1e-3])
    with pytest.raises(ParameterError, match=r"record: 1 samples, must be 2 to 1000000"):
        bench.record(["C2F0"], 1, 1e-3)
    bench.select("AHN")
    bench.set_bias("AHN_VPW_N", "N", 60e-12, 8)
    with pytest.raises(SolverError, match=r"coach.AHN: comes to no rest with these biases; record"):
        bench.read_voltage("ADC11")


def test_every_pin_leads_somewhere() -> None:
    assert len(circuits()) == len(CIRCUITS)
    for name, wiring in CIRCUITS.items():
        bench = CoachBench()
        bench.select(name)
        ports = {port for each in bench._built().ports for port in each.elements()}
        driven = {*wiring.inputs.values(), *wiring.lines.values(), *wiring.held, *wiring.current}
        assert driven <= ports, name
        assert {*wiring.outputs.values()} <= ports, name
