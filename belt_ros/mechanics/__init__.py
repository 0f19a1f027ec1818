"""What a belt drive does: elastic/perfectly-plastic (EPP) friction in equilibrium and in motion.

The source of every equation number in this package is Kim, Leamy and Ferri (2011),
DOI 10.1115/1.4003796. Nothing here knows of filters, of ROS or of a clock.
"""

from belt_ros.mechanics.arc import ArcSolution, Role, solve_arc
from belt_ros.mechanics.coulomb import coulomb_torque_from_slip, solve_coulomb
from belt_ros.mechanics.coulomb_arc import coulomb_profile
from belt_ros.mechanics.distribution import (
    Distribution,
    DriveDistribution,
    arc_distribution,
    drive_distribution,
)
from belt_ros.mechanics.drive import Belt, BeltDrive, DriveError, Kinematics, Pulley, Tensioning
from belt_ros.mechanics.equilibrium import (
    Equilibrium,
    margin,
    solve_equilibrium,
    torque_capacity,
    torque_from_slip,
)
from belt_ros.mechanics.layout import Disc, Layout, Side, crossed_drive, open_drive, trace
from belt_ros.mechanics.loop import (
    BeltLoop,
    FixedCentres,
    HeldSpan,
    HubLoad,
    LoopPulley,
    loop_pulleys,
)
from belt_ros.mechanics.loop_equilibrium import LoopEquilibrium, loop_margin, solve_loop
from belt_ros.mechanics.slip_onset import slip_onset_stiffness
from belt_ros.mechanics.stability import DriveModes, Modes, arc_modes, drive_modes

__all__ = [
    "ArcSolution",
    "Belt",
    "BeltDrive",
    "BeltLoop",
    "Disc",
    "Distribution",
    "DriveDistribution",
    "DriveError",
    "DriveModes",
    "Equilibrium",
    "FixedCentres",
    "HeldSpan",
    "HubLoad",
    "Kinematics",
    "Layout",
    "LoopEquilibrium",
    "LoopPulley",
    "Modes",
    "Pulley",
    "Role",
    "Side",
    "Tensioning",
    "arc_distribution",
    "arc_modes",
    "coulomb_profile",
    "coulomb_torque_from_slip",
    "crossed_drive",
    "drive_distribution",
    "drive_modes",
    "loop_margin",
    "loop_pulleys",
    "margin",
    "open_drive",
    "slip_onset_stiffness",
    "solve_arc",
    "solve_coulomb",
    "solve_equilibrium",
    "solve_loop",
    "torque_capacity",
    "torque_from_slip",
    "trace",
]
