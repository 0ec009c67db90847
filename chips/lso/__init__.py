"""The sonar head's ears: level units and LSO neurons, whose spikes tell the direction of an echo."""
