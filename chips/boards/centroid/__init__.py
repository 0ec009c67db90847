"""The centroid board, whose output voltage is the range at which most of the ranging array answers."""
