"""What the node makes of its parameters. No ROS."""

from dataclasses import dataclass
from pathlib import Path

from belt_ros.node_tables import InputKind
from belt_ros.settings import DriveSettings


@dataclass(frozen=True)
class NodeSettings:
    """What concerns the node rather than its drives."""

    autostart: bool
    input_reliability: str
    input_depth: int
    longest_pool: float
    diagnostics_period: float
    use_memory: bool
    memory_period: float


@dataclass(frozen=True)
class UnitSettings:
    """How one drive is connected. `memory_file` is absolute; None: no memory."""

    input: InputKind
    input_reorder_window: float
    input_disorder: float
    input_slop: float
    input_skew: float
    input_loads: bool
    state_period: float
    memory_file: Path | None


@dataclass(frozen=True)
class DriveDescription:
    """One drive: its settings, and how it is connected."""

    drive: DriveSettings
    unit: UnitSettings
