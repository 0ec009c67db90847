"""The centroid board: the range at which most of the array answers, as a voltage."""
