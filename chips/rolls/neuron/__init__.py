"""The behavioural model of ROLLS' neuron."""
