"""Kernels worked out for one structure, as straight code for graphics processors."""
