"""The life of a drive in scripts: each is ordinary running, then one phase, then running again."""

from typing import NamedTuple

from benchmarks.estimation.cells import BELTS, NOISES, STIFFNESSES, Cell

DURATION = 10.0  # [s]
BEGIN = 5.0  # [s] of most phases; until then the drive is run up and loaded
_UP = ((0.2, 0.0), (1.0, 1.0))
_LOADED = ((1.2, 0.0), (1.4, 0.5), (2.6, 0.5), (2.8, 0.8), (4.0, 0.8), (4.2, 0.5))

Points = tuple[tuple[float, ...], ...]


class Script(NamedTuple):
    """One phase, for any drive.

    Points of `load` are (time [s], share of the capacity, and if there is a third, what is added to
    it: inertia of the driven pulley times full speed per that many seconds, [1/s]).
    """

    name: str
    about: str
    span: tuple[float, float]  # of the phase [s]
    speed: Points  # (time [s], share of full speed)
    load: Points
    tension_left: float = 1.0  # from `BEGIN` on
    missing: tuple[str, ...] = ()  # fields of a measurement that are missing during the phase
    silent: bool = False  # no data at all during the phase
    belts: tuple[str, ...] = tuple(BELTS)
    stiffnesses: tuple[float, ...] = STIFFNESSES

    def cell(self, seed: int) -> Cell:
        """Return what the drive of this seed is drawn from."""
        belt = self.belts[seed % len(self.belts)]
        stiffness = self.stiffnesses[seed % len(self.stiffnesses)]
        noise = tuple(NOISES)[seed // 2 % len(NOISES)]
        return Cell(belt, stiffness, 0.8, noise)


SCRIPTS = (
    Script("steady running", "nothing happens, for comparison", (5.0, 7.0), _UP, _LOADED),
    Script(
        "standstill",
        "taken off load, stops, stands for 2 s, starts again",
        (5.0, 7.0),
        (*_UP, (4.4, 1.0), (5.0, 0.0), (7.0, 0.0), (7.8, 1.0)),
        (*_LOADED, (4.4, 0.5), (4.6, 0.0), (7.8, 0.0), (8.0, 0.5)),
    ),
    Script(
        "start",
        "first start, from standstill against 30 % of capacity",
        (0.5, 1.5),
        ((0.5, 0.0), (1.5, 1.0)),
        ((0.0, 0.3), (2.5, 0.3), (2.7, 0.6)),
    ),
    Script(
        "acceleration",
        "half to full speed and back, each in half a second",
        (5.0, 6.5),
        ((0.2, 0.0), (1.0, 0.5), (5.0, 0.5), (5.5, 1.0), (6.0, 1.0), (6.5, 0.5)),
        _LOADED,
    ),
    Script(
        "load steps",
        "20, 90, 30, 70 % of capacity, each within 20 ms",
        (5.0, 7.0),
        _UP,
        (
            *_LOADED,
            *((5.0, 0.5), (5.02, 0.2), (5.5, 0.2), (5.52, 0.9)),
            *((6.1, 0.9), (6.12, 0.3), (6.6, 0.3), (6.62, 0.7)),
        ),
    ),
    Script(
        "regeneration",
        "the load drives with 60 % of capacity for 2 s",
        (5.0, 7.2),
        _UP,
        (*_LOADED, (5.0, 0.5), (5.2, -0.6), (7.0, -0.6), (7.2, 0.5)),
    ),
    Script(
        "reversal",
        "full speed forwards to full speed backwards in 1.2 s, and on",
        (5.0, 6.7),
        (*_UP, (5.0, 1.0), (6.2, -1.0)),
        _LOADED,
    ),
    Script(
        "gross slip",
        "overload for 0.4 s costs the driven pulley about 40 % of its speed; recovery",
        (5.0, 6.0),
        _UP,
        (*_LOADED, (5.0, 0.5, 0.0), (5.02, 1.0, 1.0), (5.4, 1.0, 1.0), (5.42, 0.5, 0.0)),
    ),
    Script(
        "coasting",
        "1.5 s without torque of the motor, a small drag halves the speed",
        (5.0, 6.5),
        (*_UP, (5.0, 1.0), (6.5, 0.5), (6.6, 0.5), (7.2, 1.0)),
        # Motor and load then share the deceleration of two like pulleys, 1/3 of full speed per s.
        (*_LOADED, (5.0, 0.5, 0.0), (5.02, 0.0, 0.667), (6.5, 0.0, 0.667), (6.6, 0.5, 0.0)),
    ),
    Script(
        "load torque missing",
        "for 2 s, with a step of the load",
        (5.0, 7.0),
        _UP,
        (*_LOADED, (6.0, 0.5), (6.02, 0.7)),
        missing=("driven_torque",),
    ),
    Script(
        "both torques missing",
        "for 2 s, with a step of the load",
        (5.0, 7.0),
        _UP,
        (*_LOADED, (6.0, 0.5), (6.02, 0.7)),
        missing=("driver_torque", "driven_torque"),
    ),
    Script(
        "a speed missing",
        "that of the driven pulley for 2 s, with a step of the load",
        (5.0, 7.0),
        _UP,
        (*_LOADED, (6.0, 0.5), (6.02, 0.7)),
        missing=("driven_speed",),
    ),
    Script(
        "tension loss",
        "40 % in 0.1 s at half load, on a belt softer in contact, where slip tells it",
        (5.0, 7.0),
        _UP,
        _LOADED,
        tension_left=0.6,
        belts=("compliant",),
        stiffnesses=(1e7,),
    ),
    Script(
        "gap",
        "2.5 s without data, in which the load has changed",
        (5.0, 7.5),
        _UP,
        (*_LOADED, (6.0, 0.5), (6.02, 0.7)),
        silent=True,
    ),
)
