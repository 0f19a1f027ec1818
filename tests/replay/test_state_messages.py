"""States as bytes are those that rosbags writes, field by field."""

import dataclasses

import numpy as np
import pytest

from belt_ros.estimation import BeltEstimate, Health, Phase, Quantity, Rejection
from belt_ros.estimation.estimate import Consistency, Fit, Knowledge, LostTraction, Reserve
from belt_ros.message_fields import state_fields
from belt_ros.message_types import belt_typestore
from belt_ros.replay.tables import STATE_TYPE, state_kinds
from belt_ros.state_bytes import StateBytes

STAMP_NS = 1_700_000_000_123_456_789


def estimate(seed: int) -> BeltEstimate:
    """An estimate in which every field has a value of its own."""
    random = np.random.default_rng(seed)

    def number() -> float:
        return float(random.standard_normal())

    told = {
        field.name: Quantity(number(), abs(number()))
        for field in dataclasses.fields(BeltEstimate)
        if field.type is Quantity
    }
    counts = tuple(int(count) for count in random.integers(0, 2**40, len(Rejection)))
    health = Health(number(), 3, 2**50 + seed, 7, Rejection.GATED, counts)
    fit = Fit(Consistency.OVERCONFIDENT, 1.3, 0.3, float("nan"))
    return BeltEstimate(
        **told,
        friction_stiffness_log_stddev=0.4,
        gross_slip_probability=0.03,
        stamp_ns=STAMP_NS + seed,
        phase=Phase.REGENERATING,
        tension_knowledge=Knowledge.LEARNED,
        friction_stiffness_knowledge=Knowledge.AT_PRIOR,
        friction_coefficient_knowledge=Knowledge.UNKNOWN,
        health=dataclasses.replace(health, fit=fit),
        reserve=Reserve(Quantity(60.0, 4.0), 0.02),
        lost_traction=LostTraction(0.9, 0.7, 0.1),
    )


@pytest.mark.parametrize("name", ["", "a", "paper_drive", "conveyor 12", "Förderband"])
def test_bytes_are_those_of_rosbags(name: str) -> None:
    types = belt_typestore().types
    time = types["builtin_interfaces/msg/Time"]
    for seed in range(5):
        known = estimate(seed)
        fields = state_fields(name, known)
        fields["rejection_counts"] = np.array(fields["rejection_counts"], dtype=np.uint64)
        header = types["std_msgs/msg/Header"](time(*divmod(known.stamp_ns, 1_000_000_000)), "")
        message = types[STATE_TYPE](header=header, **fields)
        expected = bytes(belt_typestore().serialize_cdr(message, STATE_TYPE))
        assert StateBytes(name, state_kinds()).write(known) == expected
