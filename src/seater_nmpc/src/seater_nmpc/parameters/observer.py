"""Parameters of the state observer (`observer:` in config/controller.yaml)."""

from __future__ import annotations

from dataclasses import dataclass

from seater_common.params import param


@dataclass(frozen=True)
class ObserverParameters:
    """The state observer: the dock in odom."""

    buffer_duration: float = param(2.0, "s", "how far back odometry and measurements are kept", low=0.2, high=20.0)
    max_extrapolation: float = param(0.1, "s", "how far ahead of the newest odometry a stamp may be", low=0.0, high=0.5)
    acquire_count: int = param(5, "", "consistent measurements that make the first estimate", low=1, high=100)
    acquire_speed: float = param(
        0.02, "m/s, rad/s", "speed below which the chair counts as standing", low=0.001, high=1.0
    )
    reacquire_count: int = param(
        8, "", "rejected measurements in a row that agree and replace the estimate", low=2, high=100
    )
    reacquire_distance: float = param(
        0.15, "m", "how far from where it was a goal goes on with a dock that it sees elsewhere", low=0.0, high=5.0
    )
    reacquire_turn: float = param(0.15, "rad", "the same for its heading", low=0.0, high=3.1416)
    max_sd: float = param(
        0.05,
        "m",
        "standard deviation of an image's dock position up to which it counts as seen, plus a tenth of its distance",
        low=0.001,
        high=1.0,
    )
    gate: float = param(16.3, "", "chi-square gate, 3 degrees of freedom (16.3: 99.9 %)", low=1.0, high=1000.0)
    acquire_odds: float = param(
        20.0, "", "likelihood ratio at which one of several poses is believed", low=1.0, high=1e6
    )
    calibration_position: float = param(
        0.001, "m", "calibration error, equal in all images, standard deviation", low=0.0, high=0.1
    )
    calibration_heading: float = param(0.002, "rad", "the same for the heading", low=0.0, high=0.2)
    odometry_scale: float = param(
        0.0,
        "",
        "relative error of odometry distances, as identified: it measures (1 + this) of the way",
        low=-0.5,
        high=1.0,
    )
    odometry_heading_scale: float = param(0.0, "", "the same for turns", low=-0.5, high=1.0)
    odometry_heading_drift: float = param(0.0, "rad/m", "turn that it measures per metre driven", low=-0.5, high=0.5)
    scale_sd: float = param(
        0.01, "", "constant relative error of odometry distances, standard deviation", low=0.0, high=0.2
    )
    heading_scale_sd: float = param(0.01, "", "the same for turns", low=0.0, high=0.2)
    heading_drift_sd: float = param(
        0.005, "rad/m", "constant turn per metre driven, standard deviation", low=0.0, high=0.2
    )
    distance_noise: float = param(
        0.002, "m/sqrt(m)", "random error of distances after 1 m, standard deviation", low=0.0, high=1.0
    )
    side_noise: float = param(
        0.0, "m/sqrt(m)", "random way across its wheels after 1 m driven, standard deviation", low=0.0, high=1.0
    )
    heading_noise: float = param(
        0.002, "rad/sqrt(m)", "random turn after 1 m driven, standard deviation", low=0.0, high=1.0
    )
    turn_noise: float = param(
        0.004, "rad/sqrt(rad)", "random turn after 1 rad turned, standard deviation", low=0.0, high=1.0
    )
    slip_distance_noise: float = param(
        0.02,
        "m/sqrt(m)",
        "random error of distances of wheels that slip, after 1 m, standard deviation",
        low=0.0,
        high=1.0,
    )
    slip_side_noise: float = param(
        0.02, "m/sqrt(m)", "random way across wheels that slip, after 1 m driven", low=0.0, high=1.0
    )
    slip_heading_noise: float = param(
        0.02, "rad/sqrt(m)", "random turn of wheels that slip, after 1 m driven", low=0.0, high=1.0
    )
    slip_turn_noise: float = param(
        0.02, "rad/sqrt(rad)", "random turn of wheels that slip, after 1 rad turned", low=0.0, high=1.0
    )
    slip_walk: float = param(
        0.1, "1/sqrt(m)", "change of the relative errors of wheels that slip, after 1 m or 1 rad", low=0.0, high=1.0
    )
    slip_walk_turn: float = param(
        0.8, "rad/m/sqrt(m)", "change of the turn per metre of wheels that slip, after 1 m", low=0.0, high=1.0
    )
    gyro_bias_sd: float = param(
        0.03, "rad/s", "constant turning rate that odometry may report of a chair at rest", low=0.0, high=0.5
    )
    speed_noise: float = param(0.02, "m/s", "error of one message's speed, standard deviation", low=1e-4, high=0.5)
    omega_noise: float = param(0.02, "rad/s", "the same for its turning rate", low=1e-4, high=1.0)
    speed_agility: float = param(
        0.15,
        "m/s^2",
        "deviation from the assumed motor lag, standard deviation",
        low=0.001,
        high=5.0,
    )
    omega_agility: float = param(0.3, "rad/s^2", "the same for the turning rate", low=0.001, high=10.0)
    max_tilt: float = param(
        0.35,
        "rad",
        "tilt of the dock's z axis above which a hypothesis is a flip",
        low=0.01,
        high=1.6,
    )
    max_height: float = param(0.5, "m", "height of the dock's origin above which it is a flip too", low=0.01)
