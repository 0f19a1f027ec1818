"""The paper's drive as a model of Exudyn (https://github.com/jgerstmayr/EXUDYN).

Cable2D elements (ANCF), ObjectContactFrictionCircleCable2D with a tangential spring: the same
spring-slider as EPP friction. The driver is the left pulley; clockwise, as they turn, is negative.
"""

import importlib
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from benchmarks.mechanics.drive_run import (
    BELT,
    INERTIA,
    INSTALLED,
    RADIUS,
    SPAN,
    SPEED,
    TORQUE,
    rise,
)

SEGMENTS = 2  # of contact on an element, as in Exudyn's own belt drive


@dataclass(frozen=True)
class Choices:
    """What Exudyn leaves to its user.

    Parameters
    ----------
    step : float
        Time step [s].
    contact_stiffness : float
        Of the normal penalty, per unit length of belt [N/m2].
    contact_damping, friction_damping : float
        Share of the square root of stiffness times mass of a contact segment [-].
    bending_stiffness : float
        EI [N m2]; small, since the paper's belt has none.
    axial_damping : float
        [N s].
    """

    step: float = 1e-4
    contact_stiffness: float = 1e9
    contact_damping: float = 1.0
    friction_damping: float = 0.3
    bending_stiffness: float = 1e-3
    axial_damping: float = 1.0


class Sensors(NamedTuple):
    """Numbers of the sensors."""

    forces: list[list[int]]  # of contacts, driver and driven
    points: list[int]  # middles of segments
    tensions: list[int]  # of elements
    speeds: list[int]  # of pulleys


class Model(NamedTuple):
    """A belt drive in Exudyn and the numbers of its items."""

    exu: Any
    system: Any
    container: Any  # keeps the system alive
    contacts: list[list[int]]  # driver, driven
    holds: list[int]  # constraints of the static solution
    drive: int  # constraint that imposes the driver's speed
    segment: float  # length of a contact segment [m]
    sensors: Sensors


def build_model(exu: Any, stiffness: float, elements: int, choices: Choices) -> Model:
    """Assemble the drive; the belt is to be put on yet, and friction to be set."""
    items = importlib.import_module("exudyn.itemInterface")
    beams = importlib.import_module("exudyn.beams")
    container = exu.SystemContainer()
    system = container.AddSystem()
    circles = [[[0.0, 0.0], RADIUS, "L"], [[SPAN, 0.0], RADIUS, "L"]]
    curve = beams.CreateReevingCurve(circles, closedCurve=True, numberOfANCFnodes=elements)
    template = items.Cable2D(
        massPerLength=BELT.mass_per_length,
        bendingStiffness=choices.bending_stiffness,
        axialStiffness=BELT.axial_stiffness,
        axialDamping=choices.axial_damping,
        referenceAxialStrain=-INSTALLED / BELT.axial_stiffness,
        useReducedOrderIntegration=2,
        strainIsRelativeToReference=False,
    )
    _, cables, _, _, holds = beams.PointsAndSlopes2ANCFCable2D(
        system,
        curve["ancfPointsSlopes"],
        curve["elementLengths"],
        template,
        fixedConstraintsNode0=[1, 0, 0, 0],
        firstNodeIsLastNode=True,
    )
    segment = curve["totalLength"] / elements / SEGMENTS
    ground = system.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=system.AddNode(items.NodePointGround()), coordinate=0)
    )
    contacts, rotors, drive = [], [], -1
    for index, circle in enumerate(circles):
        rotor, body = _add_pulley(system, items, circle[0])
        turn = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=rotor, coordinate=0))
        pair = [ground, turn]
        holds.append(system.AddObject(items.CoordinateConstraint(markerNumbers=pair)))
        if index == 0:
            drive = system.AddObject(
                items.CoordinateConstraint(
                    markerNumbers=pair, velocityLevel=True, offsetUserFunction_t=_driver_speed
                )
            )
        else:
            system.AddLoad(
                items.LoadCoordinate(markerNumber=turn, load=0.0, loadUserFunction=_load_torque)
            )
        centre = system.AddMarker(items.MarkerBodyRigid(bodyNumber=body))
        law = _contact_law(stiffness, segment, choices)
        contacts.append([_add_contact(system, items, centre, cable, law) for cable in cables])
        rotors.append(rotor)
    sensors = _add_sensors(exu, items, system, contacts, cables, rotors, segment)
    system.Assemble()
    return Model(exu, system, container, contacts, holds, drive, segment, sensors)


def _driver_speed(_system: Any, time: float, _item: int, _offset: float) -> float:
    """Belt and pulleys turn clockwise, which is negative."""
    return -SPEED * float(rise(time))


def _load_torque(_system: Any, time: float, _load: float) -> float:
    return TORQUE * float(rise(time))


def _add_pulley(system: Any, items: Any, centre: Any) -> tuple[int, int]:
    node = system.AddNode(items.Node1D(referenceCoordinates=[0.0]))
    body = system.AddObject(
        items.ObjectRotationalMass1D(
            inertia=INERTIA,
            nodeNumber=node,
            referencePosition=[*centre, 0.0],
            referenceRotation=np.eye(3),
        )
    )
    return node, body


def _contact_law(stiffness: float, segment: float, choices: Choices) -> dict[str, float]:
    mass = BELT.mass_per_length * segment
    normal, tangential = choices.contact_stiffness * segment, stiffness * segment
    return {
        "contactStiffness": normal,
        "contactDamping": choices.contact_damping * math.sqrt(normal * mass),
        "frictionVelocityPenalty": choices.friction_damping * math.sqrt(tangential * mass),
    }


def _add_contact(system: Any, items: Any, centre: int, cable: int, law: dict[str, float]) -> int:
    """Add one element's contact with one pulley, without friction as yet."""
    shape = system.AddMarker(
        items.MarkerBodyCable2DShape(bodyNumber=cable, numberOfSegments=SEGMENTS)
    )
    start = [0.1] * SEGMENTS + [-2.0] * SEGMENTS + [0.0] * SEGMENTS  # apart, undefined, nowhere
    data = system.AddNode(
        items.NodeGenericData(initialCoordinates=start, numberOfDataCoordinates=len(start))
    )
    return int(
        system.AddObject(
            items.ObjectContactFrictionCircleCable2D(
                markerNumbers=[centre, shape],
                nodeNumber=data,
                numberOfContactSegments=SEGMENTS,
                circleRadius=RADIUS,
                frictionCoefficient=0.0,
                frictionStiffness=1e-8,
                **law,
            )
        )
    )


def _add_sensors(
    exu: Any,
    items: Any,
    system: Any,
    contacts: list[list[int]],
    cables: list[int],
    rotors: list[int],
    segment: float,
) -> Sensors:
    kind = exu.OutputVariableType

    def on_cable(cable: int, place: float, output: Any) -> int:
        return int(
            system.AddSensor(
                items.SensorBody(
                    bodyNumber=cable,
                    localPosition=[place, 0.0, 0.0],
                    storeInternal=True,
                    outputVariableType=output,
                )
            )
        )

    forces = [
        [
            system.AddSensor(
                items.SensorObject(
                    objectNumber=contact, storeInternal=True, outputVariableType=kind.ForceLocal
                )
            )
            for contact in row
        ]
        for row in contacts
    ]
    points = [
        on_cable(cable, (k + 0.5) * segment, kind.Position)
        for cable in cables
        for k in range(SEGMENTS)
    ]
    middle = 0.5 * SEGMENTS * segment
    tensions = [on_cable(cable, middle, kind.ForceLocal) for cable in cables]
    speeds = [
        system.AddSensor(
            items.SensorNode(
                nodeNumber=rotor, storeInternal=True, outputVariableType=kind.Coordinates_t
            )
        )
        for rotor in rotors
    ]
    return Sensors(forces, points, tensions, speeds)
