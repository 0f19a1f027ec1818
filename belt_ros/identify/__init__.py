"""A belt's kf, friction, tension and radius ratio from a bag with loads, each with an interval."""

from belt_ros.identify.result import Identified, Interval
from belt_ros.identify.run import identify, identify_measurements
from belt_ros.identify.written import with_identified

__all__ = ["Identified", "Interval", "identify", "identify_measurements", "with_identified"]
