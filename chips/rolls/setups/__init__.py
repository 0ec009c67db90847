"""Experiments that show what a ROLLS chip does: learning, populations at set rates, and a neural field."""
