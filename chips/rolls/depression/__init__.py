"""Short-term depression of the synapses of ROLLS."""
