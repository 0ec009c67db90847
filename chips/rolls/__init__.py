"""The ROLLS chip: 256 neurons, their synapses and plastic array, on a die."""
