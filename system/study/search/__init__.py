"""Searches over biases and dies, and where the variance of a metric comes from."""
