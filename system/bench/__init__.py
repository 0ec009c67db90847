"""Scripts for the teaching chip's bench: sweeps and records without code."""
