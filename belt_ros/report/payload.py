"""The numbers behind the pictures, as JSON that the page's script reads."""

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from belt_ros.report.alarm_history import AlarmHistory
from belt_ros.report.envelopes import Curves
from belt_ros.report.labels import LABELS, SEVERITIES, condition_name
from belt_ros.report.load_slip import COLUMNS, ROWS
from belt_ros.report.study import LoadPicture, ModelCurve, Study

_MOST_INTERVALS = 4_000

# Each chart: its quantities, and how its ordinate is drawn.
_CHARTS: tuple[dict[str, Any], ...] = (
    {
        "id": "slip",
        "title": "Slip",
        "names": ("slip", "predicted_creep"),
        "scale": "asinh",
        "linear": 1.0,
        "note": "Above 1 % the scale is logarithmic. Left out while the drive hardly moves.",
    },
    {
        "id": "tension",
        "title": "Span tensions",
        "names": ("tight_tension", "slack_tension", "mean_tension"),
        "floor": 0.0,
    },
    {
        "id": "stiffness",
        "title": "Friction stiffness kf",
        "names": ("friction_stiffness",),
        "scale": "log",
    },
    {
        "id": "margin",
        "title": "Margin to gross slip",
        "names": ("margin",),
        "floor": -20.0,
        "ceiling": 105.0,
        "limits": ("margin_warning", "margin_alarm"),
    },
    {
        "id": "torque",
        "title": "Load and capacity",
        "names": ("transmitted_torque", "capacity_torque"),
    },
)
_HIDDEN = ("mean_tension",)  # until asked for
_SHORT = {
    "slip": "slip",
    "predicted_creep": "predicted creep",
    "tight_tension": "tight",
    "slack_tension": "slack",
    "mean_tension": "mean",
    "friction_stiffness": "kf",
    "margin": "margin",
    "transmitted_torque": "torque",
    "capacity_torque": "capacity",
}


def payload(study: Study) -> str:
    """Return the numbers as JSON that may stand within an HTML script element."""
    sources = {"filtered": _curves(study.filtered)}
    if study.smoothed is not None:
        sources["smoothed"] = _curves(study.smoothed)
    values = {
        "end": study.summary.number("duration"),
        "charts": [_chart(chart, study) for chart in _CHARTS],
        "sources": sources,
        "alarms": _alarms(study.alarms),
        "load": _load(study.picture),
    }
    text = json.dumps(values, allow_nan=False, separators=(",", ":"))
    # Within a script element only these could end it, or begin a comment.
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _packed(values: NDArray[Any], kind: str) -> dict[str, str]:
    """Return numbers in little-endian bytes of a numpy type such as f4, as Base64."""
    data = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
    return {"type": kind, "bytes": base64.b64encode(data).decode("ascii")}


def _curves(curves: Curves) -> dict[str, Any]:
    found = {}
    for name, curve in curves.curves.items():
        factor = LABELS[name].factor
        parts = {"least": curve.least, "low": curve.low, "high": curve.high}
        if not curves.every_row:
            parts["greatest"] = curve.greatest
        found[name] = {part: _packed(values * factor, "f4") for part, values in parts.items()}
    return {"time": _packed(curves.time, "f8"), "every": curves.every_row, "curves": found}


def _chart(chart: dict[str, Any], study: Study) -> dict[str, Any]:
    names = chart["names"]
    told = {key: value for key, value in chart.items() if key not in {"names", "limits"}}
    limits: list[dict[str, float]] = []
    alarm = study.summary.group("config").group("alarm", optional=True)
    for name in chart.get("limits", ()):
        if name in alarm.raw():
            limits.append({"value": 100.0 * alarm.number(name), "severity": 1 + len(limits)})
    series = [{"name": name, "label": _SHORT[name], "shown": name not in _HIDDEN} for name in names]
    return told | {"unit": LABELS[names[0]].unit, "series": series, "limits": limits}


def _alarms(history: AlarmHistory) -> dict[str, Any]:
    lanes = history.conditions
    shown = [interval for interval in history.intervals if interval.condition in lanes]
    return {
        "lanes": [condition_name(condition) for condition in lanes],
        "severities": ["waits for acknowledgement", *SEVERITIES[1:]],
        "intervals": [
            {
                "lane": lanes.index(interval.condition),
                "severity": interval.severity,
                "start": interval.start,
                "end": interval.end,
                "message": interval.message,
            }
            for interval in shown[:_MOST_INTERVALS]
        ],
    }


def _load(picture: LoadPicture) -> dict[str, Any]:
    window, cells = picture.window, picture.cells
    return {
        "torque": [window.torque_low, window.torque_high],
        "slip": [100.0 * window.slip_low, 100.0 * window.slip_high],
        "columns": COLUMNS,
        "rows": ROWS,
        "column": _packed(cells.column, "u2"),
        "row": _packed(cells.row, "u2"),
        "count": _packed(cells.measurements, "u4"),
        "time": _packed(cells.time, "f8"),
        "curves": [_model_curve(curve) for curve in picture.curves],
    }


def _model_curve(found: ModelCurve) -> dict[str, Any]:
    curve, known = found.curve, found.known
    return {
        "when": found.when,
        "torque": _packed(curve.torque, "f4"),
        "slip": _packed(100.0 * curve.slip, "f4"),
        "low": _packed(100.0 * curve.low, "f4"),
        "high": _packed(100.0 * curve.high, "f4"),
        "capacity": known.capacity,
        "capacity_stddev": known.capacity_stddev,
        "capacity_interval": known.capacity_interval,
    }
