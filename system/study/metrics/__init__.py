"""What a study measures: registered metrics, expressions, gradients, and success in words of the user."""
