"""A testbench as a file of Python: a function for each circuit, and one that returns the testbench.

The file needs nothing of the netlist that it came from. `FILE.py:testbench` names it to a command. Every part
of it is written as a user would write it, so that it can be changed there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from keyword import iskeyword

import numpy as np

from circuits.circuit import Circuit, Instance, InstanceArray
from circuits.testbench import Testbench

_MODULES = {
    "circuits.circuit": ("Bias", "Circuit", "Instance", "InstanceArray", "Node", "Port"),
    "circuits.devices": (
        "Capacitor", "ControlledSource", "Diode", "OperationalAmplifier", "Resistor", "Source", "Transistor",
    ),
    "circuits.devices.source": ("Constant", "PiecewiseLinear", "Pulse", "Sampled"),
    "circuits.testbench": ("Testbench",),
}  # fmt: skip
_KNOWN = {name for names in _MODULES.values() for name in names} | {"np"}


def format_python(testbench: Testbench, about: str) -> str:
    """Write a testbench as a file of Python, the same text for the same input.

    about: what the file says of itself, in a line.
    """
    circuits = _circuits(testbench.circuit)
    names = _names(circuits)
    functions = [_function(circuit, names) for circuit in circuits]
    body = "\n\n\n".join([*functions, _testbench(testbench, names)])
    line = " ".join(about.replace("\\", "/").replace('"', "'").split()).rstrip(".")
    return f'"""{line}."""\n\n{_imports(body)}\n\n\n{body}\n'


def _circuits(circuit: Circuit) -> list[Circuit]:
    """The circuit and those inside it, each once, inner ones first."""
    found: dict[int, Circuit] = {}
    for each in _inside(circuit):
        found.setdefault(id(each), each)
    return list(found.values())


def _inside(circuit: Circuit) -> Iterator[Circuit]:
    for instance in circuit.instances:
        yield from _inside(instance.circuit)
    yield circuit


def _names(circuits: Iterable[Circuit]) -> dict[int, str]:
    """Name of the function that returns each circuit, by its identity."""
    found: dict[int, str] = {}
    taken = {"testbench", *_KNOWN}
    for circuit in circuits:
        name, number = circuit.name, 2
        while name in taken or iskeyword(name):
            name, number = f"{circuit.name}_{number}", number + 1
        taken.add(name)
        found[id(circuit)] = name
    return found


def _function(circuit: Circuit, names: Mapping[int, str]) -> str:
    """Text of the function that returns a circuit."""
    parts = [("ports", [_value(p) for p in circuit.ports]), ("devices", [_value(d) for d in circuit.devices])]
    parts.append(("instances", [_instance(each, names) for each in circuit.instances]))
    parts += [("nodes", [_value(n) for n in circuit.nodes]), ("biases", [_value(b) for b in circuit.biases])]
    lines = [f"def {names[id(circuit)]}():", f'    """The circuit {circuit.name}."""', "    return Circuit("]
    lines.append(f"        {circuit.name!r},")
    for name, texts in parts:
        if texts:
            lines += [f"        {name}=(", *(f"            {text}," for text in texts), "        ),"]
    return "\n".join([*lines, "    )"])


def _instance(instance: Instance | InstanceArray, names: Mapping[int, str]) -> str:
    shape = f", {instance.shape!r}" if isinstance(instance, InstanceArray) else ""
    connections = dict(instance.connections)
    parameters = f", {dict(instance.parameters)!r}" if instance.parameters else ""
    called = f"{type(instance).__name__}({instance.name!r}, {names[id(instance.circuit)]}()"
    return f"{called}{shape}, {connections!r}{parameters})"


def _testbench(testbench: Testbench, names: Mapping[int, str]) -> str:
    stop = "float('inf')" if testbench.stop == float("inf") else repr(testbench.stop)
    lines = [
        "def testbench():",
        '    """What drives the circuit, and how long."""',
        "    return Testbench(",
        f"        {testbench.title!r},",
        f"        {names[id(testbench.circuit)]}(),",
        "        (",
        *(f"            {_value(source)}," for source in testbench.sources),
        "        ),",
        f"        {stop},",
    ]
    for name in ("watch", "start", "initial", "begin"):
        value = getattr(testbench, name)
        if value and value != "disturbed":
            lines.append(f"        {name}={dict(value) if isinstance(value, Mapping) else value!r},")
    return "\n".join([*lines, "    )"])


def _value(thing: object) -> str:
    """Text of a dataclass by its fields that are not as by default, else what Python itself writes."""
    if isinstance(thing, np.ndarray):
        return f"np.array({thing.tolist()!r})"
    if not is_dataclass(thing) or isinstance(thing, type):
        return repr(thing)
    texts = []
    for field in sorted(fields(thing), key=lambda each: each.default is not MISSING):
        value = getattr(thing, field.name)
        if field.default is MISSING:
            texts.append(_value(value))
        elif value != field.default:
            texts.append(f"{field.name}={_value(value)}")
    return f"{type(thing).__name__}({', '.join(texts)})"


def _imports(body: str) -> str:
    """The imports that a body uses, a line a module."""
    lines = ["import numpy as np\n"] if "np.array(" in body else []
    for module, known in _MODULES.items():
        used = [name for name in known if f"{name}(" in body]
        if used:
            lines.append(f"from {module} import {', '.join(used)}")
    return "\n".join(lines)
