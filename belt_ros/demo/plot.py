"""The picture of a run: slip, tensions, kf and margin with their bands, and the alarm."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from belt_ros.demo.verdict import stamp_ns

_Floats = NDArray[np.float64]
_BAND = 1.96
_STANDSTILL = 1  # BeltState.PHASE_STANDSTILL, in which slip has no meaning
_CREEP = 3.0  # [%] up to which slip is drawn to scale, and beyond on a logarithm
_SEVERITY_COLOURS = ("", "#f2c14e", "#e4572e", "#8f1d14")


def draw(path: Path, title: str, states: list[Any], truths: list[Any], alarms: list[Any]) -> None:
    """Draw estimates with their 95 % bands, and the truth where it is known, into a PNG."""
    mpl.use("Agg")
    from matplotlib import pyplot as plt  # noqa: PLC0415 - the backend comes first

    begin = stamp_ns(states[0])
    figure, axes = plt.subplots(4, 1, figsize=(11, 11), sharex=True, layout="constrained")
    figure.suptitle(title)
    moving = [state for state in states if state.phase != _STANDSTILL]
    turning = [truth for truth in truths if truth.phase != _STANDSTILL]
    _panel(axes[0], begin, moving, turning, "slip", "slip [%]", 100.0, "#2a6f97")
    _panel(axes[1], begin, states, truths, "tight_tension", "tension [N]", 1.0, "#2a6f97", "tight")
    _panel(axes[1], begin, states, truths, "slack_tension", "tension [N]", 1.0, "#6a994e", "slack")
    _stiffness(axes[2], begin, states, truths)
    _panel(axes[3], begin, states, truths, "margin", "margin to slip [%]", 100.0, "#2a6f97")
    _alarms(axes[3], begin, states, alarms)
    axes[0].set_yscale("symlog", linthresh=_CREEP)
    axes[0].set_ylim(-_CREEP, 100.0)
    axes[0].yaxis.set_major_formatter("{x:g}")
    tensions = [state.tight_tension for state in states]
    axes[1].set_ylim(0.0, 1.4 * float(np.quantile(tensions, 0.995)))
    axes[3].set_ylim(-10.0, 110.0)
    axes[3].set_xlabel("time [s]")
    for axis in axes:
        axis.grid(alpha=0.3)
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small", frameon=False)
    figure.savefig(path, dpi=100)
    plt.close(figure)


def _column(begin: int, states: list[Any], name: str, factor: float) -> tuple[_Floats, _Floats]:
    times = np.array([(stamp_ns(state) - begin) * 1e-9 for state in states])
    return times, factor * np.array([getattr(state, name) for state in states])


def _panel(
    axis: Axes,
    begin: int,
    states: list[Any],
    truths: list[Any],
    name: str,
    label: str,
    factor: float,
    colour: str,
    legend: str = "estimate",
) -> None:
    times, values = _column(begin, states, name, factor)
    _, deviations = _column(begin, states, f"{name}_stddev", factor)
    band = _BAND * deviations
    axis.fill_between(times, values - band, values + band, color=colour, alpha=0.25, lw=0)
    axis.plot(times, values, color=colour, lw=1.4, label=f"{legend}, 95 %")
    if truths:
        axis.plot(*_column(begin, truths, name, factor), "k--", lw=0.9, label=_once(axis))
    axis.set_ylabel(label)


def _once(axis: Axes) -> str:
    """Name the truth in the legend, but not twice."""
    return "_truth" if "truth" in axis.get_legend_handles_labels()[1] else "truth"


def _stiffness(axis: Axes, begin: int, states: list[Any], truths: list[Any]) -> None:
    times, values = _column(begin, states, "friction_stiffness", 1.0)
    _, spread = _column(begin, states, "friction_stiffness_log_stddev", 1.0)
    reach = np.exp(_BAND * np.minimum(spread, 20.0))
    axis.fill_between(times, values / reach, values * reach, color="#7d4f9e", alpha=0.25, lw=0)
    axis.plot(times, values, color="#7d4f9e", lw=1.4, label="estimate, 95 %")
    if truths:
        axis.plot(*_column(begin, truths, "friction_stiffness", 1.0), "k--", lw=0.9, label="truth")
    axis.set_yscale("log")
    axis.set_ylabel("friction stiffness kf [N/m2]")


def _alarms(axis: Axes, begin: int, states: list[Any], alarms: list[Any]) -> None:
    """Shade the times at which the alarm was active, as long as there were states."""
    end = (stamp_ns(states[-1]) - begin) * 1e-9
    starts = [(stamp_ns(alarm) - begin) * 1e-9 for alarm in alarms]
    named: set[str] = set()
    for alarm, start, stop in zip(alarms, starts, [*starts[1:], end], strict=True):
        if alarm.active and start < end:  # after the end it is silence that is told
            label = ("", "warning", "alarm", "trip")[alarm.severity]
            axis.axvspan(
                start,
                min(stop, end),
                color=_SEVERITY_COLOURS[alarm.severity],
                alpha=0.35,
                lw=0,
                label=f"_{label}" if label in named else label,
            )
            named.add(label)
