"""Messages of every kind that nobody should send, a million of them, at random but by a seed."""
