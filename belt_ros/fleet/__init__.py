"""Many bags of many drives: one result for each, and one table, page and trend over all."""

from belt_ros.fleet.records import Row
from belt_ros.fleet.run import FleetError, FleetResult, run_fleet
from belt_ros.fleet.trends import DriveTrend, Trend

__all__ = ["DriveTrend", "FleetError", "FleetResult", "Row", "Trend", "run_fleet"]
