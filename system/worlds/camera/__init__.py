"""The dynamic vision sensor."""
