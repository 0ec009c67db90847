"""Training for silicon: weights that hold on dies never seen, found with drawn dies in the loop."""
