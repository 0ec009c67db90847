"""The synapse of ROLLS at behavioural level."""
