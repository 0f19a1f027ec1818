"""A load that is seen to move some samples late: those samples are taken in again."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runs import scripted

from belt_ros.estimation import BeltFilter, Measurement
from belt_ros.estimation.load import Activity
from belt_ros.estimation.process import Process
from belt_ros.estimation.recent import RecentSteps, Step
from belt_ros.estimation.sensing import NO_LOADS, Sensed
from belt_ros.estimation.smoother import Members, Moved
from belt_ros.estimation.state import Index
from belt_ros.settings import DriveSettings

SEEDS = range(8)
LOG_STIFFNESS = math.log(8e6)
BEGIN, END = 2.0, 4.0  # of a ramp from rest to 10 N m, a sixth of what the belt carries [s]
NOTHING = np.zeros((1, 0))
PACE = st.sampled_from([0.001, 0.004, 0.02, 0.3, 1.0, 30.0])


def step(stamp_ns: int, activity: tuple[float, float]) -> Step:
    empty = Members(NOTHING, np.zeros(0, dtype=np.int64), NOTHING, NOTHING)
    process = Process(NOTHING, np.diag(NOTHING), NOTHING)
    sensed = Sensed(NOTHING, NOTHING, NOTHING, NOTHING, np.zeros(0, np.int64), NO_LOADS, NO_LOADS)
    return Step(
        stamp_ns,
        0.01,
        empty,
        sensed,
        (0.0, 0.0, 0.0),
        Activity(activity, activity),
        (process, process),
        Moved(NOTHING, NOTHING, NOTHING),
    )


def moving(driver: float, driven: float, unseen: float = math.inf) -> Activity:
    """Activity of both torques that may have been so for `unseen` [s] before it showed."""
    return Activity((driver, driven), (driver, driven), (unseen, unseen))


def stamps(steps: list[Step]) -> list[int]:
    return [kept.stamp_ns for kept in steps]


class Heard:
    """A recorder that notes what it hears."""

    def __init__(self) -> None:
        self.log: list[tuple[str, int]] = []

    def step(self, stamp_ns: int, *_) -> None:
        self.log.append(("step", stamp_ns))

    def switch(self, members: list, _: list) -> None:
        self.log.append(("switch", len(members)))


def recent(activities: list[tuple[float, float]], heard: Heard | None = None) -> RecentSteps:
    kept = RecentSteps()
    kept.recorder = heard
    for stamp_ns, activity in enumerate(activities):
        kept.append(step(stamp_ns, activity))
    return kept


def test_steps_are_taken_out_from_the_first_that_was_much_calmer() -> None:
    activities = [(0.9, 0.9), (0.001, 0.5), (0.8, 0.8), (0.001, 0.001)]
    kept = recent(activities)
    assert stamps(kept.taken_too_calm(moving(0.1, 0.1))) == [1, 2, 3]
    assert stamps(kept.taken_too_calm(moving(0.1, 0.1))) == []


def test_either_torque_makes_a_step_too_calm() -> None:
    for paces in ((0.1, 0.001), (0.001, 0.1)):
        assert stamps(recent([(0.01, 0.01)]).taken_too_calm(moving(*paces))) == [0]


def test_steps_that_were_about_as_lively_stay() -> None:
    assert recent([(0.03, 0.03)] * 5).taken_too_calm(moving(0.1, 0.1)) == []


@given(st.lists(st.tuples(st.tuples(PACE, PACE), st.booleans()), max_size=60))
def test_what_is_taken_out_is_what_a_look_at_every_step_finds(rows) -> None:
    kept, all_kept = RecentSteps(), []
    for stamp, (activity, asks) in enumerate(rows):
        kept.append(step(stamp, activity))
        all_kept = [*all_kept, (stamp, activity)][-20:]
        if asks:
            enough = [min(pace, 1.0) / 5.0 for pace in activity]
            calm = [k for k, (_, a) in enumerate(all_kept) if np.any(np.less(a, enough))]
            first = calm[0] if calm else len(all_kept)
            found = stamps(kept.taken_too_calm(moving(*activity)))
            assert found == [stamp for stamp, _ in all_kept[first:]]
            all_kept = all_kept[:first]


def test_only_steps_are_taken_out_in_which_the_load_can_have_moved_unseen() -> None:
    kept = recent([(0.001, 0.001)] * 10)
    assert stamps(kept.taken_too_calm(moving(1.0, 1.0, 3e-9))) == [6, 7, 8, 9]
    assert stamps(kept.taken_too_calm(moving(1.0, 1.0))) == [0, 1, 2, 3, 4, 5]
    at_once = recent([(0.001, 0.001)] * 10)
    assert stamps(at_once.taken_too_calm(moving(1.0, 1.0, 0.0))) == [9]


def test_a_torque_that_may_have_moved_unseen_takes_its_steps_whatever_the_other_shows() -> None:
    kept = recent([(0.001, 0.001)] * 5)
    activity = Activity((1.0, 1.0), (1.0, 1.0), (0.0, 2e-9))
    assert stamps(kept.taken_too_calm(activity)) == [2, 3, 4]


def test_slip_that_moves_while_torques_rest_takes_no_step_out() -> None:
    kept = recent([(0.001, 0.001)] * 5)
    assert kept.taken_too_calm(Activity((1.0, 1.0), (0.001, 0.001))) == []


def test_no_step_is_repeated_once_it_is_too_old() -> None:
    heard = Heard()
    kept = recent([(0.001, 0.001)] * 50, heard)
    again = stamps(kept.taken_too_calm(moving(1.0, 1.0)))
    assert again == list(range(30, 50))
    assert heard.log == [("step", stamp) for stamp in range(30)]


def test_a_recorder_hears_of_each_step_once_and_of_no_change_that_was_taken_back() -> None:
    heard = Heard()
    kept = recent([(0.9, 0.9), (0.001, 0.001)], heard)
    kept.switch([None] * 7, [False] * 7)
    for again in kept.taken_too_calm(moving(1.0, 1.0)):
        kept.append(again)
    kept.settle()
    assert heard.log == [("step", 0), ("step", 1)]


def test_a_recorder_hears_of_a_change_of_modes_after_its_step() -> None:
    heard = Heard()
    kept = recent([(0.9, 0.9), (0.9, 0.9)], heard)
    kept.switch([None] * 7, [False] * 7)
    kept.append(step(2, (0.9, 0.9)))
    kept.settle()
    assert heard.log == [("step", 0), ("step", 1), ("switch", 7), ("step", 2)]


class Rewound:
    """A filter after a slow ramp, and with what activities it has come there."""

    def __init__(self, settings: DriveSettings, measurements: list[Measurement]) -> None:
        self.filter = BeltFilter(settings.drive, settings.prior, settings.noise, settings.drift)
        self.activities: dict[int, Activity] = {}
        self.measurements = measurements

    def never(self) -> "Rewound":
        """Take no step again."""
        self.filter._recent.taken_too_calm = lambda _: []
        return self

    def told(self, activities: dict[int, Activity]) -> "Rewound":
        """Know the load's activity beforehand."""
        known = iter(activities[m.stamp_ns] for m in self.measurements[1:])
        self.filter._load.follow = lambda *_, **__: next(known)
        return self.never()

    def play(self) -> "Rewound":
        settle = self.filter._recent._settle

        def note(final: Step) -> None:
            self.activities[final.stamp_ns] = final.activity
            settle(final)

        self.filter._recent._settle = note
        self.filter.start(self.measurements[0])
        for measurement in self.measurements[1:]:
            self.filter.predict(measurement)
            self.filter.update()
        self.filter.finish()
        return self

    @property
    def error(self) -> float:
        return float(self.filter.x[Index.LOG_STIFFNESS]) - LOG_STIFFNESS

    @property
    def stddev(self) -> float:
        return math.sqrt(self.filter.covariance[Index.LOG_STIFFNESS, Index.LOG_STIFFNESS])


@pytest.fixture(scope="module")
def ramps(settings: DriveSettings) -> list[tuple[Rewound, Rewound, Rewound]]:
    """Filters that rewind, that do not, and that were told, at the end of the same ramps."""
    runs = []
    for seed in SEEDS:
        samples = scripted(
            settings,
            duration=END,
            sample_rate=50.0,
            seed=seed,
            speed=120.0,
            load=[[BEGIN, 0.0], [END, 10.0]],
            condition__tension=440.0,
            condition__friction_stiffness=math.exp(LOG_STIFFNESS),
        )
        measurements = [measurement for measurement, _ in samples]
        rewinding = Rewound(settings, measurements).play()
        runs.append(
            (
                rewinding,
                Rewound(settings, measurements).never().play(),
                Rewound(settings, measurements).told(rewinding.activities).play(),
            )
        )
    return runs


def test_the_ramp_is_recognised_late_and_taken_in_as_lively_from_near_its_begin(ramps) -> None:
    for rewinding, never, _ in ramps:
        assert rewinding.activities.keys() == never.activities.keys()
        livelier = [
            stamp * 1e-9
            for stamp, activity in rewinding.activities.items()
            if np.max(activity.taken) > 4.0 * np.max(never.activities[stamp].taken)
        ]
        during = [time for time in livelier if BEGIN < time < BEGIN + 1.0]
        assert len(during) >= 5
        assert min(during) < BEGIN + 0.25


def test_rewinding_equals_having_known_the_activity(ramps) -> None:
    places = [Index.PULL, Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION]
    for rewinding, _, told in ramps:
        deviation = np.sqrt(np.diag(told.filter.covariance))[places]
        apart = (rewinding.filter.x - told.filter.x)[places] / deviation
        np.testing.assert_allclose(apart, 0.0, atol=0.05)
        assert rewinding.stddev == pytest.approx(told.stddev, rel=0.02)


def test_a_slow_ramp_is_not_blamed_on_the_belt(ramps) -> None:
    def rms(which: int) -> float:
        return math.sqrt(np.mean([run[which].error ** 2 for run in ramps]))

    rewinding, never, told = rms(0), rms(1), rms(2)
    assert rewinding < 0.6 * never
    assert rewinding == pytest.approx(told, rel=0.1)


def test_taking_no_step_again_bends_kf_one_way(ramps) -> None:
    """It is an error of the method that rewinding takes away, not luck with the noise."""
    errors = np.array([never.error for _, never, _ in ramps])
    assert np.all(errors < 0.0)
    assert abs(np.mean([rewinding.error for rewinding, _, _ in ramps])) < 0.4 * -errors.mean()


def test_a_steady_load_leaves_nothing_to_rewind(settings: DriveSettings) -> None:
    samples = scripted(settings, duration=4.0, sample_rate=50.0, seed=3, speed=120.0, load=20.0)
    rewinding = Rewound(settings, [measurement for measurement, _ in samples])
    steps_again = []
    taken = rewinding.filter._recent.taken_too_calm

    def counted(activity: Activity) -> list[Step]:
        again = taken(activity)
        steps_again.append(len(again))
        return again

    rewinding.filter._recent.taken_too_calm = counted
    rewinding.play()
    assert sum(steps_again[50:]) < 0.2 * len(steps_again[50:])


def test_what_is_repeated_is_what_was_measured(settings: DriveSettings) -> None:
    """Also where a torque or a speed is missing in a step that is repeated."""

    def alter(measurement: Measurement) -> Measurement:
        seconds = measurement.stamp_ns * 1e-9
        if BEGIN < seconds < BEGIN + 0.1:
            return dataclasses.replace(measurement, driver_torque=math.nan)
        if BEGIN + 0.1 < seconds < BEGIN + 0.2:
            return dataclasses.replace(measurement, driven_speed=math.nan)
        return measurement

    samples = scripted(
        settings,
        duration=3.5,
        sample_rate=50.0,
        seed=1,
        speed=120.0,
        load=[[BEGIN, 0.0], [3.0, 15.0]],
        condition__friction_stiffness=8e6,
    )
    rewinding = Rewound(settings, [alter(measurement) for measurement, _ in samples]).play()
    assert np.all(np.isfinite(rewinding.filter.x))
    assert np.all(np.diag(rewinding.filter.covariance) >= 0.0)
    assert abs(rewinding.error) < 2.0 * rewinding.stddev
    assert len(rewinding.activities) == len(rewinding.measurements) - 1
