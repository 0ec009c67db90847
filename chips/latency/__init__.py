"""The latency chip, which evaluates paths and chooses one by the time of its first spikes."""
