"""The law of a single transistor, for a lecture or a plot without any circuit."""

from circuits.devices.transistor import drain_current
from circuits.silicon.process import BOLTZMANN, thermal_voltage

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Law of a transistor
    "drain_current",
    "thermal_voltage",
    "BOLTZMANN",
]
