"""A network of populations: as pure data and files, put on a chip, and run on its dies."""

from system.mapping.chips import map_on
from system.mapping.dynamics import usual_rates
from system.mapping.network import Connection, Input, Network, Population, Probe
from system.mapping.network_file import read_network, write_network
from system.mapping.nir.read import read_nir
from system.mapping.nir.write import write_nir_network
from system.mapping.program_file import read_program_file, write_program
from system.mapping.rolls.calibrate import calibrated
from system.mapping.run import run_mapped

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # A network
    "Network",
    "Population",
    "Input",
    "Connection",
    "Probe",
    # Files of networks
    "read_network",
    "write_network",
    "read_nir",
    "write_nir_network",
    # On a chip
    "usual_rates",
    "map_on",
    "write_program",
    "read_program_file",
    "calibrated",
    "run_mapped",
]
