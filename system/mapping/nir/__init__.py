"""Networks as graphs of NIR, the neuromorphic intermediate representation, read and written."""
