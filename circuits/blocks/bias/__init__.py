"""Circuits that make bias currents and voltages."""
