"""The networks of the Pushbot on ROLLS, their biases and calibration."""
