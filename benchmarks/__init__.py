"""Long measurements, run by hand with `make bench`; their results are committed."""
