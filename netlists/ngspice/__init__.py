"""Runs in ngspice."""
