"""Silicon: fabrication processes and temperature, dies, and the deviations of the devices on them."""
