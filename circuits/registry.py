"""Blocks and metrics by command-line name, loaded on use.

Users add theirs under the entry points `noctule.blocks` and `noctule.metrics`.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from circuits.errors import unknown_name

if TYPE_CHECKING:
    from circuits.blocks.block import Block
    from circuits.blocks.metric import Metric

BLOCKS: dict[str, str] = {
    "rebound-neuron": "circuits.blocks.rebound_neuron:BLOCK",
    "centroid-board": "circuits.blocks.centroid_board:BLOCK",
    "vocalization-controller": "circuits.blocks.vocalization_controller:BLOCK",
    "envelope-detector": "circuits.blocks.envelope_detector:BLOCK",
    "onset-neuron": "circuits.blocks.onset_neuron:BLOCK",
    "high-threshold-neuron": "circuits.blocks.high_threshold_neuron:BLOCK",
    "bias-generator": "circuits.blocks.bias_generator:BLOCK",
    "bias-chain": "circuits.blocks.bias_chain:BLOCK",
    "first-target-isolation": "circuits.blocks.first_target_isolation:BLOCK",
    "dpi-synapse": "circuits.blocks.dpi_synapse:BLOCK",
    "depressing-synapse": "circuits.blocks.depressing_synapse:BLOCK",
    "plastic-synapse": "circuits.blocks.plastic_synapse:BLOCK",
    "calcium-gate": "circuits.blocks.calcium_gate:BLOCK",
    "rolls-neuron": "circuits.blocks.rolls_neuron:BLOCK",
    "axon-delay": "circuits.blocks.axon_delay:BLOCK",
    "wavefront-cell": "circuits.blocks.wavefront_cell:BLOCK",
    "winner-take-all": "circuits.blocks.winner_take_all:BLOCK",
    "latency-neuron": "circuits.blocks.latency_neuron:BLOCK",
    "coincidence-detector": "circuits.blocks.latency_coincidence:BLOCK",
    "race-cell": "circuits.blocks.latency_race:BLOCK",
    "race-layer": "circuits.blocks.latency_layer:BLOCK",
    "delay-tap": "circuits.blocks.latency_tap:BLOCK",
    "tonic-neuron": "circuits.blocks.latency_tonic:BLOCK",
    "latency-unit": "circuits.blocks.latency_unit:BLOCK",
    "conductance-neuron": "circuits.blocks.latency_conductance:BLOCK",
    "lso-neuron": "circuits.blocks.lso_neuron:BLOCK",
    "nef-neuron": "circuits.blocks.nef_neuron:BLOCK",
    "nef-synapse": "circuits.blocks.nef_synapse:BLOCK",
    "nef-encoder": "circuits.blocks.nef_encoder:BLOCK",
}

METRICS: dict[str, str] = {
    "best_delay": "circuits.blocks.tuning_metrics:BEST_DELAY",
    "width": "circuits.blocks.tuning_metrics:WIDTH",
    "t_inh": "circuits.blocks.tuning_metrics:T_INH",
    "t_reb": "circuits.blocks.tuning_metrics:T_REB",
    "spikes_per_echo": "circuits.blocks.tuning_metrics:SPIKES_PER_ECHO",
    "class": "circuits.blocks.tuning_metrics:CLASS",
    "delay": "circuits.blocks.axon_linearity:DELAY",
    "unit_delay": "circuits.blocks.axon_linearity:UNIT_DELAY",
    "delay_offset": "circuits.blocks.axon_linearity:DELAY_OFFSET",
    "inl": "circuits.blocks.axon_linearity:INL",
}


def block_names() -> list[str]:
    """Names of all blocks, the users' own included, sorted."""
    return sorted({*BLOCKS, *(e.name for e in entry_points(group="noctule.blocks"))})


def load_block(name: str) -> Block:
    """Load a block by name; raises `UnknownNameError` for a name that nobody registered."""
    block: Block = _load("block", name, BLOCKS, "noctule.blocks")
    return block


def metric_names() -> list[str]:
    """Names of all metrics, the users' own included, in the table's order."""
    return [*METRICS, *sorted({e.name for e in entry_points(group="noctule.metrics")} - set(METRICS))]


def load_metric(name: str) -> Metric:
    """Load a metric by name; raises `UnknownNameError` for a name that nobody registered."""
    metric: Metric = _load("metric", name, METRICS, "noctule.metrics")
    return metric


def _load(kind: str, name: str, table: Mapping[str, str], group: str) -> Any:
    if name in table:
        module, attribute = table[name].split(":")
        return getattr(import_module(module), attribute)
    entries = {e.name: e for e in entry_points(group=group)}
    if name in entries:
        return entries[name].load()
    raise unknown_name(kind, name, [*table, *entries])
