"""The networks of the Pushbot on ROLLS, their biases, calibration and power."""
