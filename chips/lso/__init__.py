"""Level units and LSO neurons of two ears, whose spikes tell a direction."""
