"""A transient of a circuit as a film: every node and device, its schematic, and the command that makes it."""

from pathlib import Path

import numpy as np
import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import GROUND
from circuits.lowering.on_die import on_die
from circuits.measure.scope import TransientRecord
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from system.cli.command_line import main
from system.schematic import film as films
from system.schematic.film import film_of
from system.view.film import Film
from system.view.kept import kept
from system.view.page import page

FOLLOWER = Path(__file__).parents[3] / "examples" / "circuits" / "follower.py"


@pytest.fixture(scope="module")
def result() -> Result:
    circuit, block = rebound_neuron.build(), rebound_neuron.BLOCK
    stimuli = {each.name: each.default for each in block.stimuli} | {"duration": 2e-3}
    bench = block.testbench(circuit, stimuli, AMI_1500.v_dd)
    return simulate(bench, Silicon(AMI_1500, die=Die(number=1003)))


def lines(film: Film, unit: str) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    (panel,) = [p for p in film.panels if p.unit == unit]
    return {line.name: line.value for line in panel.lines}


def test_all_voltages_and_currents_are_in_it(result: Result) -> None:
    film = film_of(result, rebound_neuron.BLOCK.plotted)
    assert film.drawing is not None
    volts, amperes = lines(film, "V"), lines(film, "A")
    assert set(volts) == set(result.nodes) - {GROUND}
    assert np.array_equal(volts["v_mem"], result["v_mem"])
    record = TransientRecord(result)
    for name in ("membrane.mr1", "membrane.c_m", "vdd"):
        assert np.array_equal(amperes[name], record.current(name).value)
    nets = {t.net for t in film.drawing.texts if t.value and t.net}
    assert nets <= set(volts)
    assert "v_mem" in nets
    devices = {t.device for t in film.drawing.texts if t.value and t.device}
    assert devices == {n.name for n in film.neurons} == set(amperes) - set(result.machine.source_names)
    assert not any("8.88" in t.text for t in film.drawing.texts)  # what kept their room


def test_a_device_has_what_deviates_in_it_on_the_die(result: Result) -> None:
    (found,) = [n.devices[0] for n in film_of(result).neurons if n.name == "membrane.mr1"]
    fet = on_die(rebound_neuron.build(), result.machine.silicon).fet["membrane.mr1"]
    assert found.deviation == f"V_T0 {1e3 * float(fet.v_t0):+.2f} mV, beta {100 * float(fet.beta):+.2f} %"
    assert found.sigma > 0.0
    assert "drain v_mem" in found.what


def test_of_too_many_waveforms_those_of_the_schematic_stay_and_that_is_said(
    result: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    total = sum(len(lines(film_of(result), unit)) for unit in "VA")
    monkeypatch.setattr(films, "MOST", 1000)
    film = film_of(result)
    assert "v_mem" in lines(film, "V")
    assert "vdd" not in lines(film, "A")  # a source, which the schematic does not draw
    left = sum(len(lines(film, unit)) for unit in "VA")
    assert film.facts["waveforms"] == f"{left} of {total}: those that the schematic names"


def test_simulate_keeps_a_circuit_of_ones_own_and_view_plays_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, html, both = (str(tmp_path / name) for name in ("run.nc", "run.html", "both.html"))
    words = ["simulate", f"{FOLLOWER}:step", "--die", "1003"]
    assert main([*words, "-o", run, "--view", html]) == 0
    film = kept(run)
    assert page([film]) == Path(html).read_text("utf-8")
    assert "die A/1003" in film.title
    assert film.drawing is not None
    assert main(["view", run, "--beside", run, "-o", both]) == 0
    for wrong, said in (
        (["--view", "run.txt"], "run.txt: must end with .html"),
        (["--view", html, "--engine", "ngspice"], "--view: of the native engine"),
        (["--view", html, "--analysis", "ac"], "--view: not of --analysis ac"),
    ):
        capsys.readouterr()
        assert main([*words, *wrong]) == 2
        err = capsys.readouterr().err
        assert said in err
        assert err.count("\n") == 1
