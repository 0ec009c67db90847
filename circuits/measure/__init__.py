"""Measures: expressions over the waveforms of a run, parsed and never evaluated as Python."""
