"""The plant of the kind that the settings name, and its odometry."""

from __future__ import annotations

from numpy.typing import ArrayLike

from seater_common.geometry import Limits
from seater_sim.chair.encoders import EncoderOdometry
from seater_sim.chair.interface import Plant, WheelOdometry
from seater_sim.chair.odometry import Odometry
from seater_sim.chair.plant import KinematicPlant
from seater_sim.chair.wheelchair import WheelchairPlant
from seater_sim.settings import KINEMATIC, OdometrySettings, PlantSettings


def make_plant(
    settings: PlantSettings, odometry: OdometrySettings, limits: Limits, pose: ArrayLike, seed: int
) -> tuple[Plant, WheelOdometry]:
    """`pose`: (x [m], y [m], heading [rad]) of base_link in the dock frame. Raises ValueError when it is not finite."""
    if settings.kind == KINEMATIC:
        return KinematicPlant(settings.kinematic, limits, pose), Odometry(odometry, seed)
    chair = settings.wheelchair
    plant = WheelchairPlant(chair, limits, pose, seed)
    return plant, EncoderOdometry(odometry, chair.odometry, chair.wheels, plant.encoders, seed)
