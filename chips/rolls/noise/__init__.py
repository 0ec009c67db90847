"""Noise of a ROLLS chip, from that of its devices."""
