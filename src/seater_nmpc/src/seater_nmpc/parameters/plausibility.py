"""Parameters of the plausibility checks (`plausibility:` in config/controller.yaml)."""

from __future__ import annotations

from dataclasses import dataclass

from seater_common.params import param


@dataclass(frozen=True)
class PlausibilityParameters:
    """What must agree while the chair docks: commands, odometry, images, installation."""

    blocked_time: float = param(
        0.5, "s", "standing for so long though asked to drive ends the goal", low=0.1, high=10.0
    )
    blocked_speed: float = param(
        0.08, "m/s", "speed that surely moves a chair that is free, beyond its deadband", low=0.01, high=1.0
    )
    blocked_turning: float = param(0.25, "rad/s", "the same for turning on the spot", low=0.02, high=2.0)
    runaway_speed: float = param(
        0.06, "m/s", "speed beyond what is asked for (plus 30 %) that is a runaway", low=0.01, high=1.0
    )
    runaway_turning: float = param(0.25, "rad/s", "the same for turning", low=0.02, high=2.0)
    runaway_time: float = param(0.15, "s", "how long it has to last", low=0.0, high=2.0)
    image_speed: float = param(
        0.03, "m/s", "difference of the speeds by images and by odometry that is no contradiction", low=0.01, high=1.0
    )
    image_turning: float = param(0.15, "rad/s", "the same for turning", low=0.02, high=2.0)
    image_share: float = param(0.4, "", "share of the larger one that is none either (tyres slip)", low=0.05, high=1.0)
    marker_scale: float = param(
        0.03, "", "share by which distances between markers may contradict their sizes", low=0.001, high=1.0
    )
    marker_place: float = param(0.006, "m", "how far a marker may be off the line of the others", low=0.0005, high=1.0)
    mount_tilt: float = param(0.02, "rad", "tilt of the dock by which the mount may seem wrong", low=0.002, high=1.0)
    mount_height: float = param(0.04, "m", "the same for the height of the markers", low=0.002, high=1.0)
    final_position: float = param(
        0.02, "m", "final error by the installation that ends a docking, when it is certain", low=0.001, high=1.0
    )
    final_heading: float = param(0.02, "rad", "the same for the heading", low=0.001, high=1.0)
    final_certainty: float = param(
        5.0, "", "standard deviations from which on such an error is certain", low=1.0, high=100.0
    )
    # Of 25 chairs without a fault, 6 dockings each, the largest is 0.047; the first docking of each has 0.024 (median),
    # since it shows little of the mount (independent_chair --series 6, docs/results/wrong_installations.md).
    final_unsure: float = param(
        0.06, "m", "standard deviation of the final error beyond which only a contact is a success", low=0.005, high=1.0
    )
    # What `installation_doubt` and calibration leave, 12 and 9 mm (the same page, "Installation check").
    final_unsure_checked: float = param(
        0.015, "m", "the same where the sequence's `installation_check` is made", low=0.005, high=1.0
    )
