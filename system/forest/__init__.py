"""Forest: flights through a dense forest by narrow pings."""
