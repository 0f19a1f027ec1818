"""What can be wrong with a fleet as a whole."""


class FleetError(Exception):
    """A fleet that cannot be run; the message says why and what to do."""
