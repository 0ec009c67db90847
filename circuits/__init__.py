"""Physics and circuits: devices, blocks, their lowerings and solvers."""
