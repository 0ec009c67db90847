"""The dynamic vision sensor: pixels, their events, and the bus that reads them out."""
