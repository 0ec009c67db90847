"""The notes in netlists that were written here, and the circuits that are made from them."""
