"""The result directory of a replay as one HTML page that needs nothing but itself."""

from belt_ros.report.result_directory import ReportError
from belt_ros.report.writer import write_report

__all__ = ["ReportError", "write_report"]
