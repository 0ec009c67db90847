"""What a study measures: registered metrics, expressions, and the gradients of both."""
