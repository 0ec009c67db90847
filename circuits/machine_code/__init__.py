"""Machine code of kernels: what numba makes of them, kept on disk."""
