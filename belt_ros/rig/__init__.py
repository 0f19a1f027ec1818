"""The virtual rig: a belt drive in motion that says what the sensors of a real one would say.

A scenario scripts speed, load and faults. It runs offline as fast as it can (`simulate`, or node by
node `simulate_finite_elements`), into a bag (`write_bag`), or in real time as a ROS 2 node. The
truth behind the sensors comes with it.
"""

from belt_ros.rig.finite_element_plant import simulate_finite_elements
from belt_ros.rig.scenario import Scenario, ScenarioError, load_scenario
from belt_ros.rig.sensors import JointSample
from belt_ros.rig.simulate import RigSample, measured, simulate
from belt_ros.rig.truth import Truth

__all__ = [
    "JointSample",
    "RigSample",
    "Scenario",
    "ScenarioError",
    "Truth",
    "load_scenario",
    "measured",
    "simulate",
    "simulate_finite_elements",
]
