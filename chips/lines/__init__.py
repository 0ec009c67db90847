"""Bias lines of a chip that move in a run: their noise, and the ripple of their supply."""
