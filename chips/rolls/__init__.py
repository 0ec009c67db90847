"""The ROLLS chip: 256 neurons, their programmable synapses and their plastic synapses, on a die."""
