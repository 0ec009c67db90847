"""Every name of the package `circuits` that users call, in one place.

A designer describes a circuit, gives it a testbench, puts it on silicon and asks the solver. The headings in
`__all__` are those of the reference; each thing's documentation stands where it is defined.
"""

from circuits.bias import bias_voltages, gate_voltage, rebias
from circuits.blocks.block import Block, ClosedForm, Stimulus
from circuits.blocks.drive import current_into, powered, step
from circuits.blocks.metric import Metric
from circuits.blocks.mos import inverter, mos
from circuits.blocks.ports import SUPPLY, analog_in, bias_in, event_in, event_out
from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import (
    Capacitor,
    ControlledSource,
    Device,
    Diode,
    OperationalAmplifier,
    Resistor,
    Source,
    Transistor,
)
from circuits.devices.noise import WHITE_ONLY, NoiseModel
from circuits.devices.source import Constant, Driven, PiecewiseLinear, Pulse, Sampled
from circuits.errors import (
    CircuitError,
    DataError,
    ParameterError,
    SimulatorError,
    SolverError,
    TopologyError,
    UnknownNameError,
)
from circuits.lowering.analysis import to_equation
from circuits.lowering.graph import to_graph
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.measure.measure import measure
from circuits.measure.scope import device_currents
from circuits.place import circuit_at
from circuits.registry import block_names, load_block, load_metric, metric_names
from circuits.silicon.die import CORNERS, NOMINAL, Die
from circuits.silicon.process import (
    AMI_1500,
    AMI_1500_IDEAL,
    PROCESSES,
    ROLLS_180,
    ROLLS_180_IDEAL,
    Process,
    TransistorModel,
    Variation,
)
from circuits.silicon.process_file import process_of
from circuits.silicon.silicon import Deviation, Silicon
from circuits.solver.batch import Sample, map_dies
from circuits.solver.device_table import TransistorTable, transistor_table_at
from circuits.solver.noise.analysis import Noise, noise
from circuits.solver.noise.event_jitter import EventJitter, event_jitter
from circuits.solver.noise.transient import NoiseRun, simulate_noisy
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.outcome import Outcome
from circuits.solver.power import drain_current, supply_power
from circuits.solver.small_signal import Linear, Response, ac, frequency_grid, linearise
from circuits.solver.sweep import dc_sweep
from circuits.solver.transient import Result, Runner, State, simulate
from circuits.sweep.sweep import sweep
from circuits.testbench import Testbench
from circuits.units import format_quantity, parse_quantity, quantity

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Description of a circuit
    "Circuit",
    "Port",
    "Node",
    "Instance",
    "InstanceArray",
    "Bias",
    "circuit_at",
    # Devices
    "Transistor",
    "Capacitor",
    "Resistor",
    "Diode",
    "ControlledSource",
    "OperationalAmplifier",
    "Device",
    "mos",
    "inverter",
    # Sources and testbenches
    "Source",
    "Constant",
    "Pulse",
    "PiecewiseLinear",
    "Sampled",
    "Driven",
    "Testbench",
    # Biases
    "rebias",
    "bias_voltages",
    "gate_voltage",
    # Silicon
    "Process",
    "TransistorModel",
    "Variation",
    "AMI_1500",
    "AMI_1500_IDEAL",
    "ROLLS_180",
    "ROLLS_180_IDEAL",
    "PROCESSES",
    "process_of",
    "Die",
    "NOMINAL",
    "CORNERS",
    "Silicon",
    "Deviation",
    # Operating point, sweeps and measures
    "operating_point",
    "OperatingPoint",
    "device_currents",
    "transistor_table_at",
    "TransistorTable",
    "dc_sweep",
    "sweep",
    "measure",
    # Transient
    "simulate",
    "Result",
    "Runner",
    "State",
    "Outcome",
    "drain_current",
    "supply_power",
    # Small signals
    "frequency_grid",
    "linearise",
    "Linear",
    "ac",
    "Response",
    # Noise
    "NoiseModel",
    "WHITE_ONLY",
    "noise",
    "Noise",
    "simulate_noisy",
    "NoiseRun",
    "event_jitter",
    "EventJitter",
    # Many dies
    "map_dies",
    "Sample",
    # What a circuit becomes
    "to_kernel",
    "Machine",
    "on_die",
    "to_graph",
    "to_equation",
    # Blocks and metrics
    "block_names",
    "load_block",
    "metric_names",
    "load_metric",
    "Block",
    "Stimulus",
    "ClosedForm",
    "Metric",
    "SUPPLY",
    "event_in",
    "event_out",
    "analog_in",
    "bias_in",
    "powered",
    "current_into",
    "step",
    # Quantities as text
    "quantity",
    "parse_quantity",
    "format_quantity",
    # Errors
    "CircuitError",
    "ParameterError",
    "TopologyError",
    "UnknownNameError",
    "DataError",
    "SolverError",
    "SimulatorError",
]
