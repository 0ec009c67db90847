"""Gradients of small signals."""
