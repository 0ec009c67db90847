"""A network of values on the NEF chip: codes of neurons, stages and decoders, chosen on the nominal die."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.nef.build import Built, build, moved
from chips.nef.calibration import REFERENCE_C
from chips.nef.chip import NefChip
from chips.nef.network.curves import IdealCurves
from chips.nef.network.demand import check_demand
from chips.nef.place import Placed
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError, TopologyError
from circuits.silicon.silicon import Silicon
from system.mapping.dynamics import Usual
from system.mapping.nef.findings import check_synapses, findings_of
from system.mapping.nef.network import ValueNetwork
from system.mapping.report import Finding


@dataclass(frozen=True, slots=True, eq=False)
class MappedValues:
    """A network of values on the NEF chip.

    network : what was asked for; built : the same on the nominal die, with its codes; findings : what is
    exact and what is approximate.
    """

    network: ValueNetwork
    built: Built
    findings: tuple[Finding, ...]

    def on(self, silicon: Silicon, kind: BiasKind, *, solved: bool, area: float = 1.0) -> Built:
        """Return the network on a die whose biases are calibrated at its temperature.

        solved: whether neurons are measured on that die and decoders solved from it, as on a bench; the
        program's own codes stay otherwise. area: of all devices over the circuit's.
        """
        celsius = silicon.temperature_c
        chip = NefChip(silicon.die, kind, calibration_c=celsius, area=area, process=silicon.process)
        where = chip.at(silicon.temperature_c)
        if solved:
            return build(self.network.lowered(), where, self.network.seed)
        return moved(self.built, where)


def map_on_nef(network: ValueNetwork, usual: Usual | None = None) -> MappedValues:
    """Put a network of values on the NEF chip.

    Raises `ParameterError`, with the limit and what to do, for what cannot be there, and for `usual` rates.
    """
    if usual is not None:
        raise ParameterError("input: the chip's curves are measured at all values; leave it out")
    try:
        built = _nominal(network)
    except TopologyError as error:
        raise ParameterError(str(error)) from None
    check_synapses(built)
    ideal = build(built.network, IdealCurves(), network.seed)
    return MappedValues(network, built, tuple(findings_of(built, ideal)))


def ideal_of(network: ValueNetwork) -> Built:
    """Return the network on ideal neurons, leaky integrate-and-fire ones that are drawn alike."""
    return build(network.lowered(), IdealCurves(), network.seed)


def codes_of(mapped: MappedValues) -> dict[str, F64]:
    """Return all codes, by name: of biases, of stages, and decoding weights (value a Hz and step)."""
    placed = _placed(mapped.built)
    return {
        "bias": np.concatenate([*placed.bias]).astype(float),
        "stages": np.concatenate([s.ravel() for held in placed.stages for s in held]).astype(float),
        "decoders": placed.net.decoder,
    }


def mapped_with(network: ValueNetwork, codes: Mapping[str, F64], findings: Sequence[Finding]) -> MappedValues:
    """Return a network on the chip with codes as `codes_of` gives them.

    Raises `ParameterError` where they are not as many as it has.
    """
    built = _nominal(network)
    usual = codes_of(MappedValues(network, built, ()))
    for name, own in usual.items():
        if codes[name].shape != own.shape:
            raise ParameterError(
                f"codes.{name}: {codes[name].size}, must be {own.size}; map the network again"
            )
    placed = _placed(built)
    bias = tuple(
        np.rint(part).astype(np.int64) for part in _cut(codes["bias"], [b.size for b in placed.bias])
    )
    sizes = [s.size for held in placed.stages for s in held]
    rest = iter(_cut(codes["stages"], sizes))
    stages = tuple(
        tuple(np.rint(next(rest)).astype(np.int64).reshape(s.shape) for s in held) for held in placed.stages
    )
    net = placed.net._replace(decoder=np.ascontiguousarray(codes["decoders"]))
    written = replace(built, placed=replace(placed, bias=bias, stages=stages, net=net))
    return MappedValues(network, moved(written, placed.calibrated), tuple(findings))


def _nominal(network: ValueNetwork) -> Built:
    chip, lowered = NefChip(), network.lowered()
    check_demand(lowered, chip)  # before it is calibrated
    return build(lowered, chip.at(REFERENCE_C), network.seed)


def _placed(built: Built) -> Placed:
    if built.placed is None:
        raise ParameterError("network: on ideal neurons, which have no codes; build it on a chip")
    return built.placed


def _cut(values: F64, sizes: Sequence[int]) -> list[F64]:
    return np.split(values, np.cumsum(sizes)[:-1])
