"""What Kim, Leamy and Ferri (2011), DOI 10.1115/1.4003796, print: the drive and its results."""

import math
from typing import NamedTuple

RADIUS = 0.08125  # R [m], of both pulleys
WRAP_ANGLE = math.pi  # [rad]
FRICTION_COEFFICIENT = 1.2  # mu [-]
DENSITY = 1036.0  # [kg/m3]
CROSS_SECTION = 1e-4  # A [m2]
YOUNGS_MODULUS = 800.68e6  # E [Pa]
AXIAL_STIFFNESS = YOUNGS_MODULUS * CROSS_SECTION  # EA [N]
MASS_PER_LENGTH = DENSITY * CROSS_SECTION  # m [kg/m]
FRICTION_STIFFNESS = 8.1e7  # kf [N/m2], of figures 5 to 10
DRIVER_SPEED = 120.0  # omega2 [rad/s]
BELT_SPEED = DRIVER_SPEED * RADIUS  # [m/s]
INERTIA_FORCE = MASS_PER_LENGTH * BELT_SPEED**2  # m v^2 [N]
TORQUE = 45.0  # M [N m], on the driven pulley
SPAN_LENGTH = 2.0 * math.pi * RADIUS  # l_o [m]
CONTACT_STIFFNESS = 150e3  # k, taken as that of a node [N/m]
SLACK_TENSION = 200.0  # T_L [N] of section 5
TIGHT_TENSIONS = (400.0, 4000.0)  # range of T_H [N] of figures 6 to 9


class Property(NamedTuple):
    """A row of Table 1 or of the left half of Table 2."""

    symbol: str
    name: str
    printed: str
    here: str


TABLE_1 = (
    Property("ρ", "density", "1036 kg/m2 (the unit as in the text at hand)", "1036 kg/m³"),
    Property("A", "cross-section", "0.0001 m²", "1e-4 m²"),
    Property("E", "Young's modulus", "800,680 kN/m²", "800.68 MPa, so EA = 80,068 N"),
    Property("ω₂", "driver speed", "120 rad/s", "120 rad/s"),
    Property("μ", "friction coefficient", "1.2", "1.2"),
    Property("R", "radius of both pulleys", "0.08125 m", "0.08125 m"),
    Property("k_f", "friction stiffness", "8.1e7 N/m²", "8.1e7 N/m²"),
    Property("M", "torque (Table 2)", "45 N m", "45 N m"),
    Property("l_o", "span length (Table 2)", "2πR = 0.5105 m", "2πR = 0.5105 m"),
    Property(
        "k",
        "contact stiffness (Table 2)",
        "150 kN/m2 (the unit as in the text at hand)",
        "EA/h = 31.4 MN/m a node; 150 kN/m a node for comparison",
    ),
)


class Column(NamedTuple):
    """Results for one friction stiffness, a column of Table 2."""

    friction_stiffness: float  # kf [N/m2]
    slack_tension: float  # T_L [N]
    tight_tension: float  # T_H [N]
    driven_speed: float  # omega1 [rad/s]
    driven_transition: float  # theta* [rad]
    driven_slip_arc: float  # [rad]
    driver_transition: float
    driver_slip_arc: float
    initial_tension: float  # T_o [N]
    inlet_gradient: float  # du/ds(0) on the driven pulley [-]


TABLE_2 = (
    Column(2.8e7, 156.2, 712.2, 119.1, 3.14, 0.0, 2.34, 0.80, 146.4, 1.2e-4),
    Column(2.0e8, 155.1, 716.7, 119.1, 2.16, 0.98, 2.08, 1.06, 155.1, 2.5e-7),
    Column(8.1e9, 158.3, 707.1, 119.1, 1.93, 1.21, 1.93, 1.21, 158.3, 0.0),
)

# T_H [N] at T_L = 200 N, read from the text on figure 10
DRIVEN_CREEP_LIMIT = 380.0  # up to which the driven belt does not slide anywhere
DRIVER_CREEP_LIMIT = 310.0
FULL_SLIP = 8674.0  # from which both slide everywhere
