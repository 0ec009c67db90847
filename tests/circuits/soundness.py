"""What is wrong with a circuit's wiring, as text that a test can compare."""

from __future__ import annotations

from circuits.circuit import Circuit
from circuits.errors import TopologyError
from circuits.lowering.check import check_circuit


def fault(circuit: Circuit) -> str:
    """What `check_circuit` refuses, empty for a sound circuit."""
    try:
        check_circuit(circuit)
    except TopologyError as error:
        return str(error)
    return ""
