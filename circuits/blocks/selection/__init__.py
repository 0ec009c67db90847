"""Circuits that choose among currents."""
