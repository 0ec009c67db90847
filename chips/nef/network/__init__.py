"""Networks of the Neural Engineering Framework: their description, decoders, and runs on ideal neurons."""
