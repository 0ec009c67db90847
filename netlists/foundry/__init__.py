"""Circuits put on the process of a foundry."""
