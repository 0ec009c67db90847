"""BSIM3 cards from a process's figures, against our law, in ngspice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.devices.transistor import drain_current
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, POLARITIES, Polarity, Process
from circuits.silicon.silicon import Deviation, Silicon
from circuits.solver.transient import simulate
from netlists.ngspice import run as ngspice
from netlists.ngspice.engine import node_names, upward_crossings
from netlists.registry import Settings, load_dialect
from netlists.write import bsim3

SIZE = 6e-6
NONE = Deviation(0.0, 0.0)
GAMMA = replace(
    AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, law="ekv-gamma"), p=replace(AMI_1500_IDEAL.p, law="ekv-gamma")
)


def currents(
    silicon: Silicon,
    polarity: Polarity,
    gate: F64,
    v_s: float = 0.0,
    deviation: Deviation = NONE,
    folded: Deviation | None = None,
) -> F64:
    """Drain currents in ngspice with the drain at 5 V from the bulk, voltages mirrored for a pFET."""
    sign = 1.0 if polarity == "n" else -1.0
    words = " ".join(f"{k}={v!r}" for k, v in bsim3.card(silicon, polarity, folded).items())
    own = " ".join(f"{k}={v!r}" for k, v in bsim3.deviating(polarity, deviation).items())
    temperature = silicon.temperature_c
    step = sign * float(gate[1] - gate[0])
    deck = (
        f"* one device\n.model x {polarity}mos level=8 version=3.3.0 {words}\n"
        f"m1 d g s 0 x w={SIZE} l={SIZE} {own}\nvd d 0 {sign * 5.0}\nvs s 0 {sign * v_s}\nvg g 0 0\n"
        f".options temp={temperature} tnom={temperature} gmin=1e-18 abstol=1e-18 reltol=1e-6\n"
        f".dc vg {sign * gate[0]} {sign * (gate[-1] + 0.1 * (gate[1] - gate[0]))} {step}\n.save i(vd)\n.end\n"
    )
    waveforms = ngspice.run(deck)
    assert not [m for m in waveforms.messages if "unrecognized" in m or "Fatal" in m]
    (found,) = waveforms.values.values()
    return np.abs(found)


def ours(silicon: Silicon, polarity: Polarity, gate: F64, v_s: float = 0.0) -> F64:
    sign = 1.0 if polarity == "n" else -1.0
    return np.abs(
        drain_current(silicon.law(polarity), polarity, SIZE, SIZE, sign * 5.0, sign * gate, sign * v_s)
    )


def sweep(process: Process, polarity: Polarity, temperature: float, v_s: float) -> tuple[F64, F64, float]:
    """Our currents from 1e-13 A up, those of BSIM3, and the specific current."""
    silicon = Silicon(process, temperature)
    gate = np.arange(0.0, 5.0, 0.02)
    i = ours(silicon, polarity, gate, v_s)
    # below 1e-13 A ngspice's own gmin and junctions count
    seen = i > 1e-13
    return i[seen], currents(silicon, polarity, gate, v_s)[seen], float(silicon.law(polarity).square_current)


@pytest.mark.parametrize("temperature", [-20.0, 27.0, 85.0])
@pytest.mark.parametrize("polarity", POLARITIES)
def test_nominal_devices_agree_in_weak_inversion(polarity: Polarity, temperature: float) -> None:
    """Source at the bulk. The factor is that of moderate inversion's onset; deeper down it goes to 1."""
    i, peer, specific = sweep(AMI_1500_IDEAL, polarity, temperature, 0.0)
    weak = i < 0.1 * specific
    assert np.abs(np.log(peer / i))[weak].max() < np.log(1.15)
    deep = i < 1e-3 * specific
    slope = np.diff(np.log(peer[deep])) / np.diff(np.log(i[deep]))
    assert slope.mean() == pytest.approx(1.0, abs=0.02)
    assert np.abs(np.log(peer / i)).max() < np.log(1.20)  # weak to strong


@pytest.mark.parametrize("polarity", POLARITIES)
def test_the_current_at_threshold_agrees(polarity: Polarity) -> None:
    silicon = Silicon(AMI_1500_IDEAL)
    gate = silicon.law(polarity).v_t0 + np.array([0.0, 0.01])
    ratio = currents(silicon, polarity, gate)[0] / ours(silicon, polarity, gate)[0]
    assert ratio == pytest.approx(0.94, abs=0.06)


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, GAMMA], ids=["ekv", "ekv-gamma"])
@pytest.mark.parametrize("v_s", [1.0, 1.8])
@pytest.mark.parametrize("polarity", POLARITIES)
def test_the_body_effect_is_that_of_the_law(polarity: Polarity, v_s: float, process: Process) -> None:
    i, peer, _ = sweep(process, polarity, 27.0, v_s)
    assert np.abs(np.log(peer / i)).max() < np.log(1.6)
    other = GAMMA if process is AMI_1500_IDEAL else AMI_1500_IDEAL
    j, wrong, _ = sweep(other, polarity, 27.0, v_s)
    n = min(i.size, j.size)
    assert np.abs(np.log(wrong[-n:] / i[-n:])).max() > np.log(2.0)


@pytest.mark.parametrize("polarity", POLARITIES)
def test_second_order_effects_are_those_of_the_law(polarity: Polarity) -> None:
    """The Early effect in weak inversion, where it is exact, and the mobility in strong inversion."""
    plain = GAMMA.model(polarity)
    steep = replace(plain, early_field=2e6)  # 12 V at 6 um
    i, peer, specific = sweep(replace(GAMMA, n=steep, p=steep), polarity, 27.0, 0.0)
    flat, flat_peer, _ = sweep(replace(GAMMA, n=plain, p=plain), polarity, 27.0, 0.0)
    n = min(i.size, flat.size)
    # this element has no areas, for which ngspice takes a junction of 10 fA
    deep = (flat[-n:] > 5e-12) & (flat[-n:] < 1e-3 * specific)
    ours_by, theirs_by = (i[-n:] / flat[-n:])[deep], (peer[-n:] / flat_peer[-n:])[deep]
    assert ours_by == pytest.approx(1.0 + 5.0 / 12.0, rel=1e-9)
    assert theirs_by == pytest.approx(1.0 + 5.0 / 12.0, rel=0.03)
    reduced = replace(plain, mobility_reduction=0.5)
    i, peer, _ = sweep(replace(GAMMA, n=reduced, p=reduced), polarity, 27.0, 0.0)
    fallen, fallen_peer = i[-1] / flat[-1], peer[-1] / flat_peer[-1]
    assert fallen < 0.6
    assert fallen_peer == pytest.approx(fallen, rel=0.1)


@pytest.mark.parametrize("polarity", POLARITIES)
@pytest.mark.parametrize("shift", [-0.05, 0.03])
def test_deviations_are_exact(polarity: Polarity, shift: float) -> None:
    """A higher |V_T0| by 30 mV is the curve moved by 30 mV, a higher beta the same current times 1 + beta."""
    silicon, gate = Silicon(AMI_1500_IDEAL), np.linspace(0.4, 2.0, 9)
    plain = currents(silicon, polarity, gate)
    moved = currents(silicon, polarity, gate + shift, deviation=Deviation(shift, 0.0))
    assert moved == pytest.approx(plain, rel=1e-3)
    stronger = currents(silicon, polarity, gate, deviation=Deviation(0.0, 0.2))
    assert stronger == pytest.approx(1.2 * plain, rel=1e-3)
    both = Deviation(shift, 0.2)
    folded = currents(silicon, polarity, gate, folded=both)
    assert folded == pytest.approx(currents(silicon, polarity, gate, deviation=both), rel=1e-6)


def test_a_die_s_deviations_are_shared_and_local_together() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die("A", 3))
    local = Deviation(0.01, -0.05)
    for polarity in POLARITIES:
        total = bsim3.total_deviation(silicon, polarity, local)
        nominal, shared = Silicon(AMI_1500_IDEAL).law(polarity), silicon.law(polarity)
        assert nominal.v_t0 + total.v_t0 == pytest.approx(shared.v_t0 + 0.01, rel=1e-12)
        assert nominal.square_current * (1 + total.beta) == pytest.approx(
            shared.square_current * 0.95, rel=1e-12
        )
    assert bsim3.total_deviation(Silicon(AMI_1500_IDEAL), "n", Deviation(0.0, 0.0)) == (0.0, 0.0)


def test_constant_capacitances_and_leakage_are_those_of_the_process() -> None:
    leaky = replace(AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, junction_leakage=1e-9))
    silicon = Silicon(leaky, 45.0)
    card = bsim3.card(silicon, "n")
    size = bsim3.size(Transistor("m", "n", "d", "g", "s", "0", 3e-6, 1.5e-6, 2.0))
    assert card["cj"] * size["ad"] == pytest.approx(leaky.n.junction_capacitance * 3e-6)
    assert card["js"] * size["as"] == pytest.approx(silicon.law("n").junction_leakage * 3e-6)
    assert size["pd"] == pytest.approx(2 * (3e-6 + 3.75e-6))
    assert size["m"] == 2.0
    assert card["cgdo"] == leaky.n.overlap_capacitance


def test_a_card_at_another_temperature_follows_the_process_s_laws() -> None:
    """A card made at 27 degC and run at 85 is the card made at 85, but for what V_off does."""
    hot = Silicon(AMI_1500_IDEAL, temperature_c=85.0)
    there, here = bsim3.card(hot, "p"), bsim3.card(Silicon(AMI_1500_IDEAL), "p")
    ratio = (85.0 + 273.15) / (27.0 + 273.15)
    # kt1 is of the magnitude in BSIM3 too: vth0 of a pFET is made more negative by a negative one
    assert abs(here["vth0"]) + here["kt1"] * (ratio - 1.0) == pytest.approx(abs(there["vth0"]), rel=1e-9)
    assert here["u0"] * ratio ** here["ute"] == pytest.approx(there["u0"], rel=1e-9)


@pytest.mark.parametrize("name", ["ngspice", "hspice", "xyce", "spectre"])
def test_a_deviating_device_has_parameters_or_a_card_of_its_own(name: str) -> None:
    write = load_dialect(name).devices["bsim3"]
    device = Transistor("m", "p", "d", "g", "s", "vdd", 3e-6, 1.5e-6)
    nominal = write(device, Silicon(AMI_1500_IDEAL))
    assert "bsim3_p" in " ".join(nominal)
    text = " ".join(write(device, Silicon(AMI_1500_IDEAL), Deviation(0.01, -0.05)))
    if name in {"ngspice", "hspice"}:
        assert "delvto=-0.01 mulu0=0.95" in text
    else:
        assert "delvto" not in text
        assert "model bsim3_m " in text
        assert "vth0=-0.86 " in text


def test_only_cards_that_are_used_are_written() -> None:
    block = load_block("rebound-neuron")
    bench = block.bench()
    text = load_dialect("ngspice").write(bench, Silicon(AMI_1500_IDEAL), Settings("bsim3"))
    assert text.count("\n.model bsim3_") == 2
    assert "\nb" not in text
    board = load_block("centroid-board")
    bench = board.bench()
    assert (
        load_dialect("ngspice").write(bench, Silicon(AMI_1500_IDEAL), Settings("bsim3")).count("\nb") > 0
    )  # its amplifier


@pytest.mark.parametrize("die", [Die(), Die("A", 1003)], ids=str)
def test_the_rebound_neuron_runs_on_bsim3(die: Die) -> None:
    """One spike after the rebound, within 10 % of our law's: moderate inversion moves it by some 5 %."""
    block = load_block("rebound-neuron")
    bench = block.bench()
    silicon = Silicon(AMI_1500_IDEAL, die=die)
    text = load_dialect("ngspice").write(bench, silicon, Settings("bsim3", reltol=1e-4, tmax=10e-6))
    waveforms = ngspice.run(text)
    spikes = upward_crossings(waveforms.axis, waveforms.values[node_names(bench, silicon)["spike"]], 2.5)
    expected = simulate(bench, silicon).spikes["spike"]
    assert spikes.size == expected.size == 1
    assert spikes[0] == pytest.approx(expected[0], rel=0.1)
