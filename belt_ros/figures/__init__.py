"""The paper's figures 5 to 16 and its tables 1 and 2, drawn by this package beside what it prints.

Everything comes from `belt_ros.mechanics`; only `paper` holds numbers that the paper prints.
"""

from belt_ros.figures.main import NAMES, FigureError, draw_all

__all__ = ["NAMES", "FigureError", "draw_all"]
