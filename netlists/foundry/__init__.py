"""Circuits on the process of a foundry."""
