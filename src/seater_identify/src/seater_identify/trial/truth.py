"""What the estimates should be, of a simulated chair."""

from __future__ import annotations

import math

from seater_common.geometry import Limits
from seater_sim.settings import KINEMATIC, FloorSettings, SimulatorSettings
from seater_sim.settings.wheelchair import GYRO


def true_values(simulator: SimulatorSettings, limits: Limits) -> dict[str, float]:
    """Name to true value, where the chair's settings give it directly; odometry from the wheels' steady slip."""
    if simulator.plant.kind == KINEMATIC:
        plant = simulator.plant.kinematic
        return {"delay": plant.command_delay + 0.5 * simulator.step, "lag_v": plant.lag_v, "lag_omega": plant.lag_omega,
                "gain_v": 1.0, "gain_omega": 1.0, "deadband_v": 0.0, "deadband_omega": 0.0,
                "ramp_v": limits.a_max, "ramp_omega": limits.alpha_max}  # fmt: skip
    chair = simulator.plant.wheelchair
    command, motor, floor, wheels = chair.command, chair.motor, chair.floor, chair.wheels
    # A circumference of nominal radius rolls so far over the floor:
    left = (1.0 + wheels.radius_error_left) * (1.0 - _mean_slip(floor, floor.slip_left))
    right = (1.0 + wheels.radius_error_right) * (1.0 - _mean_slip(floor, floor.slip_right))
    rolls, track = 0.5 * (left + right), 1.0 + wheels.track_error
    strong_left, strong_right = 1.0 - motor.weak_left, 1.0 - motor.weak_right
    # Straight: odometry measures the mean of the circumferences' ways; turn: their difference over the nominal track.
    values = {
        "delay": command.delay + 0.5 * command.delay_jitter + 0.5 * simulator.step,
        "lag_v": motor.lag_v,
        "lag_omega": motor.lag_omega,
        "gain_v": command.gain_v * 0.5 * (strong_left * left + strong_right * right),
        "gain_omega": command.gain_omega * 0.5 * (strong_left * left + strong_right * right) / track,
        "deadband_v": command.deadband_v,
        "deadband_omega": command.deadband_omega,
        "odometry_scale": 1.0 / rolls - 1.0,
        "odometry_heading_scale": track / rolls - 1.0,
        "odometry_heading_drift": -(right - left) / (wheels.track * rolls),
    }
    if chair.odometry.yaw == GYRO:
        values |= {"odometry_heading_scale": chair.odometry.gyro_scale, "odometry_heading_drift": 0.0}
    ramps = {"ramp_v": motor.acceleration or math.inf, "ramp_omega": motor.turn_acceleration or math.inf}
    return values | ramps


def _mean_slip(floor: FloorSettings, steady: float) -> float:
    """With the share of the way on slippery patches; a patch slips by 0.5 to 1 of patch_slip, on one side or both."""
    share = floor.patch_length / (floor.patch_length + floor.patch_gap) * (1.0 - 0.5 * floor.patch_one_sided)
    return steady + share * max(0.75 * floor.patch_slip - steady, 0.0)
