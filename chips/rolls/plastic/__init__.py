"""ROLLS' plastic synapses, and the circuits by which they learn."""
