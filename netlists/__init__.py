"""Netlists: circuits written as text for other simulators, netlists read back, and runs in ngspice."""
