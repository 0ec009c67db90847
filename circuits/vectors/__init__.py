"""Values of several runs side by side in the lanes of a vector, as kernels compute with them."""
