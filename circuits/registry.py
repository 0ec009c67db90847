"""Blocks and metrics by the name that the command line knows them by; each is loaded when it is asked for.

Users add their own under the entry points `noctule.blocks` and `noctule.metrics`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from circuits.blocks.summary import SUMMARIES
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
    "test-nfet": "circuits.blocks.bench.transistor:NFET",
    "test-pfet": "circuits.blocks.bench.transistor:PFET",
    "differential-pair": "circuits.blocks.bench.differential_pair:BLOCK",
    "wide-range-transamp": "circuits.blocks.bench.wide_range_transamp:BLOCK",
    "follower-integrator": "circuits.blocks.bench.follower_integrator:BLOCK",
    "bump-antibump": "circuits.blocks.bench.bump_antibump:BLOCK",
    "transamp-n": "circuits.blocks.bench.transamp:N",
    "transamp-p": "circuits.blocks.bench.transamp:P",
    "winner-take-all-ring": "circuits.blocks.bench.winner_take_all_ring:BLOCK",
    "pulse-extender": "circuits.blocks.bench.pulse_extender:BLOCK",
    "dpi-synapse-bench": "circuits.blocks.bench.dpi_synapse:BLOCK",
    "axon-hillock": "circuits.blocks.bench.axon_hillock:BLOCK",
    "adaptive-neuron": "circuits.blocks.bench.adaptive_neuron:BLOCK",
    "ddi-synapse": "circuits.blocks.bench.ddi_synapse:BLOCK",
    "photoreceptor": "circuits.blocks.bench.photoreceptor:BLOCK",
    "dvs-pixel": "circuits.blocks.bench.dvs_pixel:BLOCK",
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

# What each is, as its own summary says: `noctule list` and a shell's completion load none of them.
METRIC_LINES: dict[str, str] = {
    "best_delay": "midpoint of the facilitating interval",
    "width": "length of the facilitating interval",
    "t_inh": "from the call to the release of the inhibition",
    "t_reb": "from the release to the peak of v_mem",
    "spikes_per_echo": "spikes after a call and an echo at the best delay",
    "class": "what the neuron does: works, call-alone, ...",
    "delay": "axonal delay at code 16",
    "unit_delay": "axonal delay a unit of the code, by the best line",
    "delay_offset": "axonal delay at code 0, by the best line",
    "inl": "integral non-linearity of the axonal delay, a share of full scale",
}

# The circuits that each is of, as it says itself: of one block's metrics the others are not loaded.
METRIC_CIRCUITS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(
        ("best_delay", "width", "t_inh", "t_reb", "spikes_per_echo", "class"), ("rebound_neuron",)
    ),
    **dict.fromkeys(("delay", "unit_delay", "delay_offset", "inl"), ("axon_delay",)),
}

_blocks: Catalogue[Block] = Catalogue(
    "block", BLOCKS, "noctule.blocks", ("circuits.blocks.block:Block",), SUMMARIES
)
_metrics: Catalogue[Metric] = Catalogue(
    "metric", METRICS, "noctule.metrics", ("circuits.blocks.metric:Metric",), METRIC_LINES
)

load_block, block_line = _blocks.load, _blocks.line
metric_names, load_metric, metric_line = _metrics.names, _metrics.load, _metrics.line


def metrics_of_circuit(name: str) -> list[Metric]:
    """Metrics of the circuits of a name, the users' own included."""
    possible = [each for each in metric_names() if name in METRIC_CIRCUITS.get(each, (name,))]
    return [metric for metric in map(load_metric, possible) if name in metric.circuits]


def block_names() -> list[str]:
    """Names of all blocks, the users' own included, in alphabetical order."""
    return sorted(_blocks.names())
