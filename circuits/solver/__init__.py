"""Operating point, transient, and batches over dies."""
