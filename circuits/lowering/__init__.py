"""From a circuit to a kernel, a graph or a closed form."""
