"""Text for other simulators, and running ngspice."""
