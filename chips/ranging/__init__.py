"""The ranging chip: rebound neurons whose best delays span the echo delays of a bat."""
