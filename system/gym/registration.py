"""The environments of Gymnasium by their ids, under the namespace `noctule`."""

from __future__ import annotations

from typing import Any

import gymnasium

NAMESPACE = "noctule"
IDS: dict[str, dict[str, Any]] = {
    "Pushbot": {"system": "pushbot"},
    "Approach": {"system": "approach", "level": "behavioural"},
    "Forest": {"system": "forest"},
    "Rover": {"system": "rover"},
    "Bug": {"system": "bug"},
    "Car": {"system": "car"},
    "Head": {"system": "head"},
    "System": {},
}  # options of each environment; `System` takes any system by its name
WHERE, TOGETHER = "system.gym.environment:Environment", "system.gym.vector:Workers"


def id_of(name: str) -> str:
    """Return the id of an environment, as `noctule/Forest-v0`."""
    return f"{NAMESPACE}/{name}-v0"


def register_all() -> None:
    """Register every environment with Gymnasium, once."""
    for name, options in IDS.items():
        if id_of(name) not in gymnasium.registry:
            gymnasium.register(id_of(name), entry_point=WHERE, vector_entry_point=TOGETHER, kwargs=options)
