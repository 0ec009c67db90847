"""Networks of nengo, unmodified, on the NEF chip."""
