"""A testbench written as a circuit of PySpice, and a simulator for circuits of PySpice.

`to_pyspice` gives a `PySpice.Spice.Netlist.Circuit`. Each definition is a `SubCircuit`, each element an
object of PySpice's own. Transistors are B sources with the same expressions as in the exported text: names
and values come from `netlists.dialects.ngspice`, so that the two cannot differ. Numbers are plain floats,
because with units PySpice would write `1@u_F` as `1F`, and a current of a piecewise-linear source as `5.0A`:
femto and atto to SPICE.

`pyspice_simulator` gives a simulator for any PySpice circuit. It mends what stops PySpice 1.5 from
simulating: its search for `libngspice.so`, its taking notes on stderr for failures, and `save` of a text.
`.simulator()` of a circuit made here is the same one, with the tolerances that these circuits need. Results
are PySpice's; `numpy.asarray` makes them arrays.

`--engine ngspice` runs the exported text in the same library (`netlists.ngspice.run`), which PySpice's
`NgSpiceShared` binds; it builds no objects of PySpice on the way.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

from PySpice.Spice.Netlist import Circuit, SubCircuit
from PySpice.Spice.NgSpice.Simulation import NgSpiceCircuitSimulator

from circuits.devices import Source
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_device, node_name, run_name
from netlists.naming import element
from netlists.ngspice import run as ngspice
from netlists.registry import DEFAULT_RELTOL, POINTS
from netlists.write.deck import held_at_start
from netlists.write.traversal import Definition, as_made, to_design

OPTIONS = {"gmin": 1e-15, "abstol": 1e-15, "chgtol": 1e-17, "trtol": 1.0, "method": "gear"}


class TestbenchCircuit(Circuit):  # type: ignore[misc]
    """A PySpice circuit with its sources, and what its testbench says about a run.

    Attributes
    ----------
    stop : float
        End of the run, s.
    temperature_c : float
        Temperature whose laws the expressions have, degC: they do not follow another one.
    start : dict of str to float
        Voltages (V) by name in a run, from which the operating point is sought.
    held : dict of str to float
        Voltages (V) by name in a run that hold at time 0.
    uic : bool
        Whether a run begins with these and the capacitors' own, and without an operating point.
    run_names : dict of str to str
        Name in a run by our path, of every node but ground.
    """

    __test__ = False  # the name alone would make pytest collect it

    def __init__(
        self,
        testbench: Testbench,
        temperature_c: float,
        run_names: Mapping[str, str],
        held: Mapping[str, float],
    ) -> None:
        super().__init__(testbench.title)
        self.stop, self.temperature_c, self.run_names = testbench.stop, temperature_c, dict(run_names)
        guess = {} if testbench.begin == "uic" else testbench.start
        self.start = {self.run_names[path]: v for path, v in guess.items()}
        self.held = {self.run_names[path]: v for path, v in held.items()}
        self.uic = testbench.begin == "uic"

    def simulator(self, *, reltol: float = DEFAULT_RELTOL, **options: object) -> Simulator:
        """Make a simulator at the circuit's temperature.

        Parameters
        ----------
        reltol
            Relative tolerance of ngspice, dimensionless.
        options
            Options of ngspice by name, which override `OPTIONS`.
        """
        made = pyspice_simulator(self, self.temperature_c, **{**OPTIONS, "reltol": reltol, **options})
        made.node_set(**self.start)
        made.initial_condition(**self.held)
        return made

    def transient(self) -> Any:
        """Run to `stop`, in steps of a 2000th of it at most, and return PySpice's transient analysis."""
        step = self.stop / POINTS
        return self.simulator().transient(
            step_time=step, end_time=self.stop, max_time=step, use_initial_condition=self.uic
        )


class Simulator(NgSpiceCircuitSimulator):  # type: ignore[misc]
    """PySpice's simulator on our binding of ngspice's shared library; its analyses are PySpice's own methods.

    Parameters
    ----------
    circuit
        Any `PySpice.Spice.Netlist.Circuit`.
    options
        Options of PySpice's simulator, such as `temperature` (degC).
    """

    def __init__(self, circuit: Any, **options: Any) -> None:
        super().__init__(circuit, pipe=False, **options)

    def save(self, *nodes: Any) -> None:
        """Keep the voltages of these nodes only; `nodes` are texts, nodes of PySpice, or lists of them."""
        for node in nodes:
            self._saved_nodes |= {str(n) for n in (node if isinstance(node, list | tuple | set) else [node])}

    def _run(self, analysis_method: str, *arguments: Any, **options: Any) -> Any:
        """Run one analysis; raises `SimulatorError` in one line where ngspice fails."""
        super()._run(analysis_method, *arguments, **options)
        deck = str(self)
        self.reset_analysis()
        return ngspice.run_for_pyspice(deck, self).to_analysis()


def pyspice_simulator(circuit: Any, temperature_c: float = 27.0, **options: object) -> Simulator:
    """Make a simulator of any PySpice circuit, one that works with Debian's library and with numpy 2.

    Parameters
    ----------
    circuit
        A `PySpice.Spice.Netlist.Circuit`.
    temperature_c
        Temperature and nominal temperature, degC.
    options
        Options of ngspice by name, numbers plain.
    """
    made = Simulator(circuit, temperature=temperature_c, nominal_temperature=temperature_c)
    made.options(**options)
    return made


def to_pyspice(testbench: Testbench, silicon: Silicon) -> TestbenchCircuit:
    """Build the PySpice circuit of a testbench, with its sources.

    Parameters
    ----------
    testbench
        The circuit and its stimuli.
    silicon
        The die and the temperature (degC) that its values are for.

    Raises
    ------
    TopologyError
        Two names of one circuit, or of two sources, differ in case only.
    """
    design = to_design(testbench, silicon)
    top = design.top
    names = {path: run_name(path, top) for path in design.nodes}
    held = held_at_start(testbench, silicon)
    circuit = TestbenchCircuit(testbench, silicon.temperature_c, names, held)
    for definition in design.definitions:
        circuit.subcircuit(_subcircuit(definition, silicon))
    ports = [node_name(p) for p in top.ports]
    circuit.X(node_name(top.name), node_name(top.name), *ports)
    for source in design.sources:
        _add_source(circuit, source, silicon)
    return circuit


def _subcircuit(definition: Definition, silicon: Silicon) -> Any:
    sub = SubCircuit(node_name(definition.name), *map(node_name, definition.ports))
    for device, deviation in definition.devices:
        made, local = as_made(device, deviation)
        for line in "\n".join(format_device(made, silicon, local)).replace("\n+ ", " ").split("\n"):
            _add_element(sub, line)
    for call in itertools.chain.from_iterable(definition.calls):
        name = node_name(element(call.name, call.index))
        sub.X(name, node_name(call.definition), *map(node_name, call.nodes))
    return sub


def _add_element(netlist: Any, line: str) -> None:
    """Add the element that a line of text describes: its letter and name, its nodes, its value."""
    name, *words = line.split()
    letter, name = name[0], name[1:]
    if letter == ".":
        netlist.model(
            words[0], words[1], **{w: float(v) for w, _, v in (x.partition("=") for x in words[2:])}
        )
        return
    if letter == "d":
        netlist.D(name, *words[:2], model=words[2], area=float(words[3].removeprefix("area=")))
        return
    begin = {"initial_condition": float(words.pop()[3:])} if words[-1].startswith("ic=") else {}
    *nodes, value = words
    if letter == "b":
        netlist.B(name, *nodes, current_expression=value.removeprefix("i="))
        return
    add = {"c": netlist.C, "r": netlist.R, "g": netlist.VCCS}[letter]
    add(name, *nodes, float(value), **begin)


def _add_source(circuit: Any, source: Source, silicon: Silicon) -> None:
    """Add a source; its waveform is raw text because PySpice puts units behind each of its numbers."""
    lines = (line.removeprefix("+ ") for line in format_device(source, silicon))
    name, plus, minus, _, value, *rest = " ".join(lines).split()
    add = {"v": circuit.V, "i": circuit.I}[name[0]]
    add(name[1:], plus, minus, float(value), raw_spice=" ".join(rest))
