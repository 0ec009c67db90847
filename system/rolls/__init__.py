"""ROLLS as a system: the rates of a die, all neurons driven alike."""
