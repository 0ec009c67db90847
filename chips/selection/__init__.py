"""The selection of a direction by a winner-take-all circuit."""
