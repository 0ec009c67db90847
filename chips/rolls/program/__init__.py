"""What is written to a ROLLS chip: weights, addresses, biases, and networks of populations."""
