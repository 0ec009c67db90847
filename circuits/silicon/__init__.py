"""Silicon: process and temperature, dies and their draws."""
