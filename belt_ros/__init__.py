"""Know the state of a belt drive while it runs."""

__version__ = "0.1.0"
