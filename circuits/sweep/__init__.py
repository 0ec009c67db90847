"""Sweeps of a testbench over sources, silicon and its own parameters, nested, as one labelled dataset."""
