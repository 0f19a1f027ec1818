"""What a number in another unit looks like."""


def meant_millimetres(length: float, low: float, high: float) -> str:
    """Return a hint for a length [m] above `high`, if it is between the limits as millimetres."""
    metres = 1e-3 * length
    return f"; {length:g} mm are {metres:g} m" if low <= metres <= high < length else ""
