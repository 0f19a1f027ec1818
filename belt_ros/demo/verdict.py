"""The verdict: estimates against the rig's truth, in a few lines of numbers."""

import math
from typing import Any, NamedTuple

_SECONDS = 1e-9
_SETTLED = 3.0  # [s] after the start
_JUDGED = ("slip", "tight_tension", "slack_tension", "margin")
_LEAST_COVERAGE = 0.8
_TRIP = 3


class Finding(NamedTuple):
    """One line of a verdict. `passed` None: told, not judged."""

    passed: bool | None
    text: str

    def __str__(self) -> str:
        """Return it as a line."""
        return f"{ {True: 'ok  ', False: 'FAIL', None: '    '}[self.passed] }  {self.text}".strip()


class Verdict(NamedTuple):
    """All findings of one run."""

    findings: tuple[Finding, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing that was judged has failed."""
        return all(finding.passed is not False for finding in self.findings)


def stamp_ns(message: Any) -> int:
    """Header stamp [ns]."""
    return int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec)


def has_nan(state: Any) -> bool:
    """Whether any number of a state is not finite."""
    return any(
        isinstance(value := getattr(state, name), float) and not math.isfinite(value)
        for name in state.get_fields_and_field_types()
    )


def judge(states: list[Any], truths: list[Any], alarms: list[Any], sent: int) -> Verdict:
    """Compare what was heard in one run of the rig.

    Parameters
    ----------
    states, truths : list of BeltState
    alarms : list of SlipAlarm
    sent : int
        Number of joint states that were published.
    """
    findings = _soundness(states, sent)
    true = {stamp_ns(truth): truth for truth in truths}
    pairs = [(state, true[stamp_ns(state)]) for state in states if stamp_ns(state) in true]
    if not pairs:
        return Verdict((*findings, Finding(passed=False, text="the rig's truth was not heard")))
    begin = stamp_ns(pairs[0][0]) + round(_SETTLED / _SECONDS)
    settled = [(state, truth) for state, truth in pairs if stamp_ns(state) >= begin]
    coverages = [_coverage(name, settled) for name in _JUDGED]
    return Verdict((*findings, *coverages, _warning(pairs, alarms)))


def judge_bag(states: list[Any], alarms: list[Any], sent: int) -> Verdict:
    """Say what a bag showed, where no truth is known."""
    findings = _soundness(states, sent)
    if not states:
        return Verdict(findings)
    last = states[-1]
    worst = min(states, key=lambda state: float(state.margin))
    told = (
        f"at the end: slip {last.slip:.3%} +/- {last.slip_stddev:.3%}, tensions "
        f"{last.tight_tension:.0f} / {last.slack_tension:.0f} "
        f"+/- {last.tight_tension_stddev:.0f} N",
        f"least margin {worst.margin:.0%} +/- {worst.margin_stddev:.0%}; "
        f"alarm raised {max((alarm.count for alarm in alarms), default=0)} times",
    )
    return Verdict((*findings, *(Finding(None, text) for text in told)))


def _soundness(states: list[Any], sent: int) -> tuple[Finding, Finding]:
    return (
        Finding(len(states) == sent > 0, f"{len(states)} states for {sent} joint states"),
        Finding(not any(map(has_nan, states)), "no NaN in any state"),
    )


def _coverage(name: str, pairs: list[tuple[Any, Any]]) -> Finding:
    errors = [getattr(state, name) - getattr(truth, name) for state, truth in pairs]
    inside = [
        abs(error) <= 1.96 * getattr(state, f"{name}_stddev")
        for error, (state, _) in zip(errors, pairs, strict=True)
    ]
    share = sum(inside) / max(len(inside), 1)
    rms = math.sqrt(sum(error * error for error in errors) / max(len(errors), 1))
    unit = " N" if name.endswith("tension") else ""
    label = name.replace("_", " ")
    return Finding(
        share >= _LEAST_COVERAGE,
        f"{label}: rms error {rms:.3g}{unit}, "
        f"its 95 % interval holds the truth {share:.0%} of the time",
    )


def _warning(pairs: list[tuple[Any, Any]], alarms: list[Any]) -> Finding:
    """Whether a warning came while the margin was low, and the trip when the belt slipped."""
    begin = stamp_ns(pairs[0][0])
    raised = [(stamp_ns(alarm) - begin) * _SECONDS for alarm in alarms if alarm.active]
    tripped = any(alarm.severity == _TRIP for alarm in alarms)
    if not raised:
        return Finding(passed=False, text="no alarm was raised")
    first = raised[0]
    margin = min(pairs, key=lambda pair: abs((stamp_ns(pair[1]) - begin) * _SECONDS - first))[1]
    return Finding(
        tripped,
        f"first warned at {first:.1f} s with {margin.margin:.0%} of true margin left; "
        f"gross slip {'tripped' if tripped else 'did not trip'} the alarm",
    )
