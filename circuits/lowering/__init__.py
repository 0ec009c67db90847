"""What a circuit is turned into: arrays for the solver, a graph, closed forms, or models on a die."""
