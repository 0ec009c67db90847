"""Plastic synapses of ROLLS and the circuits by which they learn."""
