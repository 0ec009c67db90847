"""NIR export: weights, time constants, one step of the graph by hand, files, and a missing package."""

import sys
from dataclasses import replace
from pathlib import Path

import nir
import numpy as np
import pytest

from chips.rolls.program.address import PAPER_VIRTUAL
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.network import network_program
from chips.rolls.program.nir import LOST, Filter, nir_graph, nominal_linearisation, write_nir
from chips.rolls.program.program import Program, level_current
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.devices.transistor import Transistor, drain_current
from circuits.errors import DataError, ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.pushbot.network.plain import pushbot_network

PROGRAM = network_program(pushbot_network())


def test_the_graph_has_the_programs_weights_by_sign() -> None:
    graph = nir_graph(PROGRAM)
    model = nominal_linearisation(PROGRAM)
    positive, negative = graph.nodes["excitatory"].weight, graph.nodes["inhibitory"].weight
    assert ((positive > 0) == (PROGRAM.levels > 0)).all()
    assert ((negative < 0) == (PROGRAM.levels < 0)).all()
    post, pre = np.argwhere(PROGRAM.levels == 3)[0]
    charge = level_current(PROGRAM.biases, 3) * model.pulse[post]
    assert positive[post, pre] == pytest.approx(charge / model.threshold[post])
    assert graph.check_types()
    assert graph.metadata["lost"].splitlines() == list(LOST)


def test_nominal_time_constants_are_those_of_the_facts() -> None:
    model = nominal_linearisation(Program(np.zeros((1, 1)), tau1=(3,)))
    # facts: 15.8 ms a pF for IF_TAU1, 0.58 ms for IF_TAU2 at kappa 0.7 and 300 K; here kappa_n 0.75 and 2 pF
    assert model.membrane.tau[3] == pytest.approx(2 * 15.8e-3 * 0.7 / 0.75, rel=5e-3)  # three digits
    assert model.membrane.tau[0] == pytest.approx(2 * 0.58e-3 * 0.7 / 0.75, rel=1e-2)  # two digits
    # 0.37 ms a pF for NPDPIE_TAU; here kappa_p 0.66 and 1.5 pF
    assert model.filters["excitatory"].tau[0] == pytest.approx(1.5 * 0.37e-3 * 0.7 / 0.66, rel=1e-2)
    assert model.filters["excitatory"].gain[0] == 1.0  # IF THR = TAU in the default codes


def test_a_threshold_balances_feedback_and_leak() -> None:
    leak = default_biases().current("IF_TAU2_N")
    threshold = float(nominal_linearisation(Program(np.zeros((1, 1)))).threshold[0])
    # v_mem at which I_mem, exponential by definition, is the threshold, and the circuit's feedback there
    circuit = rolls_neuron.build()
    law = Silicon(ROLLS_180_IDEAL).law("n")
    v_mem = law.v_t0 + law.u_t / law.kappa * np.log(threshold / law.square_current)
    shift = float(np.asarray(circuit.bias("v_shift").value))
    sensing = circuit.device("sodium.mn1")
    assert isinstance(sensing, Transistor)
    feedback = drain_current(law, "n", sensing.width, sensing.length, ROLLS_180_IDEAL.v_dd, v_mem, shift, 0.0)
    # 2 %: the sensing transistor's first step into moderate inversion
    assert feedback == pytest.approx(leak, rel=0.02)


def test_one_event_through_the_graph_is_the_filters_step() -> None:
    graph, model = nir_graph(PROGRAM), nominal_linearisation(PROGRAM)
    weight, synapse = graph.nodes["virtual_excitatory_weight"], graph.nodes["virtual_excitatory_filter"]
    jump = synapse.r * weight.scale / synapse.tau * model.threshold  # of an impulse, by NIR's LI
    # facts: (I_th I_w / I_tau)(1 - e^(-t_p / tau)); equal to first order in t_p / tau
    width = model.pulse / synapse.tau
    exact = synapse.r * default_biases().current("VA_EXC_N") * (1 - np.exp(-width))
    assert jump == pytest.approx(exact, rel=float(width.max()))


def test_a_linearisation_of_ones_own_replaces_the_nominal_one() -> None:
    model = nominal_linearisation(PROGRAM)
    slower = replace(model, membrane=Filter(2 * model.membrane.tau, model.membrane.gain))
    assert (nir_graph(PROGRAM, slower).nodes["neurons"].tau == 2 * model.membrane.tau).all()
    with pytest.raises(
        ParameterError, match=r"linearisation.threshold: shape \(3,\), must be 256 numbers > 0"
    ):
        replace(model, threshold=np.ones(3))


def test_files_there_and_back(tmp_path: Path) -> None:
    path = tmp_path / "pushbot.nir"
    write_nir(path, PROGRAM)
    found, graph = nir.read(path), nir_graph(PROGRAM)
    assert set(found.nodes) == set(graph.nodes)
    assert sorted(found.edges) == sorted(graph.edges)
    assert (found.nodes["inhibitory"].weight == graph.nodes["inhibitory"].weight).all()
    assert (found.nodes["neurons"].v_leak == graph.nodes["neurons"].v_leak).all()
    with pytest.raises(DataError, match=r"pushbot.nir: No such file or directory, must be a file to write"):
        write_nir(tmp_path / "none" / "pushbot.nir", PROGRAM)


def test_virtual_synapses_that_are_not_there_have_no_input() -> None:
    graph = nir_graph(Program(np.zeros((1, 1)), virtual=PAPER_VIRTUAL))
    assert set(graph.inputs) == {"virtual_excitatory"}
    assert set(nir_graph(PROGRAM).inputs) == {"virtual_excitatory", "virtual_inhibitory"}
    assert set(nir_graph(PROGRAM).outputs) == {"spikes"}


def test_without_the_package_the_remedy_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nir", None)
    with pytest.raises(DataError, match=r"nir is not installed; pip install 'noctule\[nir\]'"):
        nir_graph(PROGRAM)
