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
    "rebound-neuron": "circuits.blocks.sonar.rebound_neuron:BLOCK",
    "centroid-board": "circuits.blocks.sonar.centroid_board:BLOCK",
    "vocalization-controller": "circuits.blocks.sonar.vocalization_controller:BLOCK",
    "envelope-detector": "circuits.blocks.sonar.envelope_detector:BLOCK",
    "onset-neuron": "circuits.blocks.sonar.onset_neuron:BLOCK",
    "high-threshold-neuron": "circuits.blocks.sonar.high_threshold_neuron:BLOCK",
    "bias-generator": "circuits.blocks.bias.generator:BLOCK",
    "bias-chain": "circuits.blocks.bias.chain:BLOCK",
    "first-target-isolation": "circuits.blocks.sonar.first_target_isolation:BLOCK",
    "dpi-synapse": "circuits.blocks.rolls.dpi_synapse:BLOCK",
    "depressing-synapse": "circuits.blocks.rolls.depressing_synapse:BLOCK",
    "plastic-synapse": "circuits.blocks.rolls.plastic_synapse:BLOCK",
    "calcium-gate": "circuits.blocks.rolls.calcium_gate:BLOCK",
    "rolls-neuron": "circuits.blocks.rolls.neuron:BLOCK",
    "axon-delay": "circuits.blocks.wavefront.axon_delay:BLOCK",
    "wavefront-cell": "circuits.blocks.wavefront.cell:BLOCK",
    "winner-take-all": "circuits.blocks.selection.winner_take_all:BLOCK",
    "latency-neuron": "circuits.blocks.latency.neuron:BLOCK",
    "coincidence-detector": "circuits.blocks.latency.coincidence:BLOCK",
    "race-cell": "circuits.blocks.latency.race:BLOCK",
    "race-layer": "circuits.blocks.latency.layer:BLOCK",
    "delay-tap": "circuits.blocks.latency.tap:BLOCK",
    "tonic-neuron": "circuits.blocks.latency.tonic:BLOCK",
    "latency-unit": "circuits.blocks.latency.unit:BLOCK",
    "conductance-neuron": "circuits.blocks.latency.conductance:BLOCK",
    "lso-neuron": "circuits.blocks.lso.lso_neuron:BLOCK",
    "nef-neuron": "circuits.blocks.nef.neuron:BLOCK",
    "nef-synapse": "circuits.blocks.nef.synapse:BLOCK",
    "nef-encoder": "circuits.blocks.nef.encoder:BLOCK",
}

METRICS: dict[str, str] = {
    "best_delay": "circuits.blocks.sonar.tuning_metrics:BEST_DELAY",
    "width": "circuits.blocks.sonar.tuning_metrics:WIDTH",
    "t_inh": "circuits.blocks.sonar.tuning_metrics:T_INH",
    "t_reb": "circuits.blocks.sonar.tuning_metrics:T_REB",
    "spikes_per_echo": "circuits.blocks.sonar.tuning_metrics:SPIKES_PER_ECHO",
    "class": "circuits.blocks.sonar.tuning_metrics:CLASS",
    "delay": "circuits.blocks.wavefront.axon_linearity:DELAY",
    "unit_delay": "circuits.blocks.wavefront.axon_linearity:UNIT_DELAY",
    "delay_offset": "circuits.blocks.wavefront.axon_linearity:DELAY_OFFSET",
    "inl": "circuits.blocks.wavefront.axon_linearity:INL",
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
