"""Networks on ROLLS: what its neurons and filters are, the levels of its weights, and where all is placed."""
