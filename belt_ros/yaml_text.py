"""Numbers as a ROS 2 parameter file wants them: a point in each, a sign in each exponent."""


def yaml_number(value: float, digits: int = 4) -> str:
    """Return `value` as YAML text that ROS 2 and YAML 1.1 both take for a floating-point number."""
    text = f"{value:.{digits}g}"
    mantissa, exponent, power = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}e{int(power):+d}" if exponent else mantissa
