"""Everything a person tunes about the simulation (config/simulator.yaml), one dataclass per part."""

from seater_sim.settings.plant import KINEMATIC, PLANTS, WHEELCHAIR, KinematicSettings, PlantSettings
from seater_sim.settings.ranging import (
    DEPTH,
    NO_SENSOR,
    SCAN,
    DepthSettings,
    RangingSettings,
    ScanSettings,
    Walker,
)
from seater_sim.settings.simulator import (
    CameraSettings,
    ContactSettings,
    Obstacle,
    OdometrySettings,
    PlanarPose,
    SceneSettings,
    SimulatorSettings,
)
from seater_sim.settings.time import NANOSECONDS, to_ns
from seater_sim.settings.wheelchair import (
    CastorSettings,
    CommandSettings,
    FloorSettings,
    MotorSettings,
    WheelchairSettings,
    WheelOdometrySettings,
    WheelSettings,
    without_effects,
)

__all__ = [
    "DEPTH",
    "KINEMATIC",
    "NANOSECONDS",
    "NO_SENSOR",
    "PLANTS",
    "SCAN",
    "WHEELCHAIR",
    "CameraSettings",
    "CastorSettings",
    "CommandSettings",
    "ContactSettings",
    "DepthSettings",
    "FloorSettings",
    "KinematicSettings",
    "MotorSettings",
    "Obstacle",
    "OdometrySettings",
    "PlanarPose",
    "PlantSettings",
    "RangingSettings",
    "ScanSettings",
    "SceneSettings",
    "SimulatorSettings",
    "Walker",
    "WheelOdometrySettings",
    "WheelSettings",
    "WheelchairSettings",
    "to_ns",
    "without_effects",
]
