"""Blocks and metrics by the name that the command line knows them by; each is loaded when it is asked for.

Users add their own under the entry points `noctule.blocks` and `noctule.metrics`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from circuits.catalogue import Catalogue

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

_blocks: Catalogue[Block] = Catalogue("block", BLOCKS, "noctule.blocks", ("circuits.blocks.block:Block",))
_metrics: Catalogue[Metric] = Catalogue(
    "metric", METRICS, "noctule.metrics", ("circuits.blocks.metric:Metric",)
)

load_block = _blocks.load
metric_names, load_metric = _metrics.names, _metrics.load


def block_names() -> list[str]:
    """Names of all blocks, the users' own included, in alphabetical order."""
    return sorted(_blocks.names())
