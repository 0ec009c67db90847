"""Elements whose current is an unknown of its own, and sources of 0 V, which are wires."""
