"""The behavioural model of ROLLS' synapse and its filter."""
