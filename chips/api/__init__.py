"""Every name of the package `chips` that users call, in one place.

A chip is circuits on a die, as a behavioural model whose error was measured. The names for programming
and running ROLLS are in `chips.api.rolls`, those for networks on the NEF chip in `chips.api.nef`. The
simulator for networks of nengo, an optional extra, is in `chips.api.nengo`.
"""

from chips.aer import Bus, Events, read_events, send, write_events
from chips.cell import Cell
from chips.coach.bench import CoachBench
from chips.latency.calibration import calibrated
from chips.latency.chip import LatencyChip, PingResponse
from chips.latency.design import Design
from chips.live.chip import LiveChip
from chips.live.table import open_chip
from chips.model import Model, characterise, load_model, model_names
from chips.noise import SiliconNoise
from chips.part import Output, Part
from chips.ranging.chip import RangingChip
from chips.ranging.response import respond
from chips.record import Record, Table, content, matching_record, read_record, record_key
from chips.registry import Chip, chip_names, load_chip
from chips.validity import outside_boxes
from chips.wavefront.axon_graph import AxonGraph, graph_of, grid_graph
from chips.wavefront.chip import ChipCells, Plan, Program, WavefrontChip

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Chips and their contract of time
    "chip_names",
    "load_chip",
    "Chip",
    "Part",
    "Output",
    "Cell",
    # Chips that are driven live
    "open_chip",
    "LiveChip",
    # Events
    "Bus",
    "Events",
    "send",
    "read_events",
    "write_events",
    # Noise of a chip's devices
    "SiliconNoise",
    # Models and records
    "model_names",
    "load_model",
    "Model",
    "characterise",
    "Record",
    "Table",
    "record_key",
    "content",
    "read_record",
    "matching_record",
    # Where models hold
    "outside_boxes",
    # Ranging chip
    "RangingChip",
    "respond",
    # Wavefront chip
    "WavefrontChip",
    "ChipCells",
    "Program",
    "Plan",
    "AxonGraph",
    "grid_graph",
    "graph_of",
    # Latency chip
    "LatencyChip",
    "PingResponse",
    "Design",
    "calibrated",
    # Teaching chip
    "CoachBench",
]
