"""Robots as environments of Gymnasium, an optional extra."""

from system.gym.environment import Environment
from system.gym.on_chip import OnChip

__all__ = [
    # Environments
    "Environment",
    "OnChip",
]
