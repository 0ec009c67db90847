"""The neuron of ROLLS at behavioural level."""
