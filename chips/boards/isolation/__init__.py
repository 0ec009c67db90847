"""The first-target isolation board: after a call it lets only the first echo excite the ranging array."""
