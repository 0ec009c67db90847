"""A live chip as a server of address-events: other programs talk to it over TCP or UDP."""
