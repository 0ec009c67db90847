"""The ranging chip: rebound neurons, each of which answers echoes of one delay, as in a bat's brain."""
