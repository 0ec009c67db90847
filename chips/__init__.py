"""Blocks on a die, as behavioural models with a measured error."""
