"""All checks, in the order in which they are printed: what others rest on comes first."""

from __future__ import annotations

from collections.abc import Callable

from seater_tools.doctor import camera, files, inputs, markers, motion, obstacles, traffic
from seater_tools.doctor.observations import ROLES, Observations
from seater_tools.doctor.verdict import Verdict

Check = Callable[[Observations], Verdict | list[Verdict]]

STATIC: tuple[Check, ...] = (
    files.packages,
    files.disk,
    *map(files.file_of, ROLES),
    files.fit,
    files.calibration,
    files.dock_geometry,
    files.teaching,
)
RUNNING: tuple[Check, ...] = (
    files.processor,
    traffic.simulated_time,
    traffic.nodes,
    traffic.single_senders,
    *map(traffic.rate_of, traffic.NEEDED),
    camera.camera_info,
    *map(traffic.stamps_of, traffic.STREAM_AGES),
    traffic.told,
    inputs.base_frames,
    inputs.at_rest,
    camera.transform,
    camera.exposure,
    markers.in_view,
    markers.sizes,
    markers.places,
    markers.upright,
    inputs.emergency_stop,
    inputs.gate,
    inputs.joystick,
    inputs.contact,
    obstacles.sensor,
    inputs.complaints,
    motion.obeys,
    motion.odometry_sign,
    motion.mount_and_delay,
)


def run(observations: Observations) -> list[Verdict]:
    """Without a running system the checks of one are left out."""
    verdicts: list[Verdict] = []
    for check in (*STATIC, *(RUNNING if observations.live is not None else ())):
        said = check(observations)
        verdicts += said if isinstance(said, list) else [said]
    return verdicts
