"""Circuits that choose the best of several currents."""
