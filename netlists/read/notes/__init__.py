"""Notes in netlists that were written here, and circuits made from them."""
