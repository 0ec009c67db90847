"""Short-term depression of ROLLS' synapses: weights that fall with every event and recover."""
