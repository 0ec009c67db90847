"""Circuits run in ngspice, and the solver compared with it."""
