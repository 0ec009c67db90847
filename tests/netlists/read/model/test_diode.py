"""D cards with their `.model`: what they become, what is refused by name, and ngspice on the same decks."""

import numpy as np
import pytest

from circuits.devices import Diode, Resistor
from circuits.errors import DataError
from circuits.measure.current import static_currents
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import noise
from circuits.solver.operating_point import operating_point
from circuits.solver.power import node_voltages
from circuits.solver.small_signal import ac
from circuits.solver.sweep import dc_sweep
from circuits.solver.transient import simulate
from netlists.ngspice import run as ngspice
from netlists.ngspice.small_signal import _plots
from netlists.read.netlist import read_netlist
from tests.refusals import refusals

MODEL = ".model dm d(is=7.03n rs=0.5 n=1.81 eg=1.06 xti=5 bv=6.2 ibv=5m cjo=10p vj=0.7 m=0.42 tt=100n)"
EXACT = ".options gmin=1e-21 reltol=1e-9 abstol=1e-18"


def deck(*cards: str) -> str:
    return "\n".join(["diodes", *cards, ".end", ""])


def read(*cards: str):
    return read_netlist(deck("v1 a 0 1", *cards)).testbench.circuit.devices


def test_a_card_becomes_a_diode_and_its_resistor() -> None:
    diode, series = read("d1 a 0 dm area=2 m=3 off", MODEL, ".options tnom=40")
    assert isinstance(series, Resistor)
    assert (series.a, series.b, series.resistance) == ("a", diode.anode, pytest.approx(0.5 / 6.0))
    assert diode == Diode(
        "d1", series.b, "0", 6.0, 7.03e-9, 1.81, 10e-12, 0.7, 0.42, 0.5, 100e-9, 6.2, 15e-3, 1.81,
        1.06, 5.0, 40.0,
    )  # fmt: skip
    (plain,) = read("d1 0 a x 2", ".model x d")
    assert plain == Diode("d1", "0", "a", 2.0)


NOT_COVERED = [
    (("d1 a 0 x", ".model x d(ikf=0.1)"), r"d1: model x\.ikf: 0\.1, not covered but for 0"),
    (("d1 a 0 x", ".model x d(level=3)"), r"d1: model x\.level: 3, not covered but for 1"),
    (("d1 a 0 x", ".model x d(wm=1u)"), r"d1: model x\.wm: of a diode, not covered"),
    (("d1 a 0 x", ".model x d(m=0.95)"), r"d1\.grading: 0\.95, must be below 0\.9"),
    (("d1 a 0 x area=0", ".model x d"), r"d1\.area: 0, must be > 0"),
    (("d1 a 0 x w=1u", ".model x d"), r"d1\.w: of a diode, not covered"),
    (("d1 a 0 x 2 3", ".model x d"), "d1: 3 is not understood"),
    (("d1 a 0 x temp=50", ".model x d"), "temp of a diode"),
    (("d1 a 0 x", ".model x numd"), "d1: a diode, which the native solver has not"),
    (("d1 a 0 y", ".model x d"), "d1: model y: unknown"),
]
test_what_is_not_covered_is_refused_by_name = refusals(
    DataError,
    lambda cards: read(*cards),
    [(cards, rf"{says}[^\n]*\Z") for cards, says in NOT_COVERED],
    start="^(?:netlist|deck):3: ",
)


def test_what_is_off_is_read() -> None:
    (diode,) = read(
        "d1 a 0 x", ".model x d(level=1 ikf=0 kf=0 af=1 cjsw=0 mjsw=0.3 js=1p cj0=2p pb=0.6 mj=0.3)"
    )
    assert diode == Diode(
        "d1", "a", "0", saturation_current=1e-12, junction_capacitance=2e-12, junction_potential=0.6,
        grading=0.3,
    )  # fmt: skip
    (faint,) = read("d1 a 0 x", ".model x d(is=1e-30)")
    assert faint == Diode("d1", "a", "0", saturation_current=1e-28)  # as in ngspice


@pytest.mark.usefixtures("ngspice_library")
@pytest.mark.parametrize("degrees", [-20.0, 27.0, 85.0])
def test_currents_and_capacitance_are_ngspices(degrees: float) -> None:
    """From breakdown at 0.4 A to 30 mA forward. ngspice finds breakdown to 1e-3, its k / q is 3e-6 off."""
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=degrees)
    own = "d1 b 0 dm area=0.7 m=2", MODEL, f"{EXACT} temp={degrees} tnom=40"
    text = deck("v1 b 0 0", *own, ".dc v1 -6.5 0.8 0.05")
    peer = ngspice.run(text, vectors=("v1#branch",))
    found = dc_sweep(read_netlist(text).testbench, "v1", peer.axis, silicon)
    current = static_currents(found.machine, node_voltages(found))["v1"]
    np.testing.assert_allclose(current, peer.values["v1#branch"], rtol=2e-4, atol=1e-20)
    for volt in (-4.0, 0.0, 0.5):
        cards = (f"v1 a 0 dc {volt} ac 1", "rs a b 50", *own, ".ac lin 2 1e6 3e7")
        plots = _plots(deck(*cards), None).values()
        theirs = next(p["b"] for p in plots if "b" in p)
        point = operating_point(read_netlist(deck(*cards)).testbench, silicon)
        ours = ac(point, "v1", np.array([1e6, 3e7]), ("b",)).transfer[:, 0]
        np.testing.assert_allclose(ours[: theirs.size], theirs, rtol=1e-4)


@pytest.mark.usefixtures("ngspice_library")
def test_noise_is_ngspices() -> None:
    """Of an area of 1: ngspice counts the area twice in the noise of RS."""
    text = deck("v1 a 0 dc 1.2 ac 1", "r1 a o 10k", "d1 o 0 dm", MODEL, EXACT, ".noise v(o) v1 dec 1 1e4 1e8")
    theirs = next(p for p in _plots(text, None).values() if "onoise_spectrum" in p)
    found = noise(operating_point(read_netlist(text).testbench), "o", theirs["frequency"].real, "v1")
    np.testing.assert_allclose(found.output, theirs["onoise_spectrum"].real ** 2, rtol=1e-4)


@pytest.mark.usefixtures("ngspice_library")
def test_a_rectifier_with_its_capacitor_is_ngspices() -> None:
    text = deck(
        "vp p 0 sin(0 6 1k)", "rs p a 10", "d1 a o dm", "d2 0 a dm", "rl o 0 1k", "cl o 0 2u",
        MODEL.replace("bv=6.2 ibv=5m", "bv=50"), ".options gmin=1e-15 reltol=1e-5", ".tran 4u 2m 0 4u",
    )  # fmt: skip
    peer, ours = ngspice.run(text), simulate(read_netlist(text).testbench)
    for node in ("a", "o"):
        apart = np.interp(peer.axis, ours.time, ours[node]) - peer.values[node]
        assert np.abs(apart).max() < 2e-3 * np.ptp(peer.values[node])
    assert np.ptp(peer.values["o"]) > 4.0
