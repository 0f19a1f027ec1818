"""How often the intervals of `belt identify` hold the truth."""
