"""What each circuit of the teaching chip reads on its bench, for values of what is not known."""
