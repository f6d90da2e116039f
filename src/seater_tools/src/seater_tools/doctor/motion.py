"""What the drive of `--move` shows: commands, odometry and images against each other, and where the camera sits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_tools.adjust.robust import NoMinimumError
from seater_tools.doctor.observations import NOT_RUNNING, Leg, Live, Move, Observations
from seater_tools.doctor.verdict import Verdict, good, unknown, wrong
from seater_tools.drive.drive import DriveError
from seater_tools.mount.prior import Lengths
from seater_tools.mount.result import Calibration, judge
from seater_tools.mount.solve import solve

Array = NDArray[np.float64]

NOT_MOVED = "needs a drive: --move"
AXES = ((0, "way", "m"), (2, "turn", "rad"))
STOOD = 0.25  # share of what was asked for, below which the chair has not obeyed
# Share by which odometry and images may differ. Tyres, track and slip of usual chairs explain 4 % (plants/), five
# centimetres seen to 1 mm 3 %.
SCALE_OFF = 0.12
CERTAIN = 4.0  # standard deviations
# [m], [rad] of the mount. A docking ends with INCONSISTENT at 20 mm and 0.02 rad (plausibility/final_*).
MOUNT_OFF = {"x": 0.015, "y": 0.015, "yaw": 0.0175}
LOOSE = {"x": 0.015, "y": 0.015, "yaw": 0.02}  # [m], [rad] standard deviations with which nothing can be said
MOST_IMAGES = 300  # of the adjustment: some seconds of work
LOOSE_DELAY = 0.01  # [s] standard deviation with which nothing can be said
LATE = 0.04  # [s] of the images' stamps against the odometry's


def obeys(observations: Observations) -> Verdict:
    """The chair does what is asked for, by its odometry or by the images."""
    name, move = "command path", _move(observations)
    if isinstance(move, str):
        return unknown(name, move)
    if move.refused:
        return wrong(name, f"the safety gate refuses: {move.refused}", "docs/safety.md#consent")
    for leg in move.legs:
        for axis, word, unit in AXES:
            asked = float(leg.asked[axis])
            if asked == 0.0:
                continue
            done = [float(pose[axis]) / asked for pose in (leg.odometry, leg.images) if pose is not None]
            if all(share < -STOOD for share in done):
                remedy = "swap the sign of cmd_vel in the base driver, or the motors' polarity; then check the encoders"
                text = f"asked for a {word} of {asked:+.2f} {unit}, went {done[0] * asked:+.2f}"
                return wrong(name, text, remedy)
    if move.stopped and (not move.legs or all(_stood(leg) for leg in move.legs)):
        return wrong(
            name, f"the drive ended: {move.stopped}", "motors' power, motor_enable, brakes, hold_to_run, deadband"
        )
    if move.stopped:
        return unknown(name, f"the drive ended: {move.stopped}")
    return good(name, "the chair obeys")


def odometry_sign(observations: Observations) -> Verdict:
    """Odometry and images agree on direction and size of each piece."""
    name, move = "odometry against images", _move(observations)
    if isinstance(move, str):
        return unknown(name, move)
    for axis, word, unit in AXES:
        odometry, images = _pairs(move, axis)
        if len(images) == 0:
            continue
        scale = float(odometry @ images) / float(images @ images)
        noise = float(np.sqrt(np.mean((odometry - scale * images) ** 2))) / float(np.linalg.norm(images))
        text = f"{word}: {odometry[0]:+.3f} {unit} by the odometry, {images[0]:+.3f} by the images"
        if scale < -0.3:
            return wrong(name, text, f"the odometry's {word} has the wrong sign: encoders swapped, or their polarity")
        if abs(scale) < 0.3:
            return wrong(name, text, "the odometry stands: look at encoders and driver")
        if abs(scale - 1.0) > SCALE_OFF + CERTAIN * noise:
            what = "diameter of the wheels" if axis == 0 else "distance between the wheels, or the gyro's scale"
            return wrong(
                name, f"{text} ({scale:.2f} times)", f"correct it in the chair's driver: {what}, ticks per turn"
            )
    if not any(leg.images is not None for leg in move.legs):
        return unknown(name, "the dock was not seen at the ends of the drive")
    return good(name, "same direction and size")


def mount_and_delay(observations: Observations) -> list[Verdict]:
    """x, y, yaw of the camera and the delay of its stamps, by the adjustment of `seater calibrate mount`."""
    found = _calibration(observations)
    if isinstance(found, str):
        return [unknown("camera mount", found), unknown("image delay", found)]
    return [_mount(found), _delay(found)]


def _mount(found: Calibration) -> Verdict:
    name, values = "camera mount", {value.name: value for value in found.mount if value.name in MOUNT_OFF}
    text = ", ".join(_words(n, v.value - v.file, v.sd) for n, v in values.items())
    said = {n: v for n, v in values.items() if v.sd <= LOOSE[n]}
    off = [n for n, v in said.items() if abs(v.value - v.file) > max(MOUNT_OFF[n], CERTAIN * v.sd)]
    if off:
        return wrong(name, f"{', '.join(off)} of chair.yaml off: {text}", "./seater calibrate mount")
    if not said:
        return unknown(name, f"the drive shows too little of it: {text}; turn nearer to the dock (1 to 1.5 m)")
    return good(name, f"off by {text}")


def _delay(found: Calibration) -> Verdict:
    name, delay = "image delay", next(value for value in found.odometry if value.name == "delay")
    text = f"images are taken {1000 * delay.value:+.0f} +- {1000 * delay.sd:.0f} ms after their stamps"
    if delay.sd > LOOSE_DELAY:
        return unknown(name, f"the drive shows too little of it: {text}")
    if abs(delay.value) > max(LATE, CERTAIN * delay.sd):
        return wrong(name, text, "the camera's driver must stamp when the image is exposed, not when it arrives")
    return good(name, text)


def _words(name: str, off: float, sd: float) -> str:
    if name == "yaw":
        return f"yaw {math.degrees(off):+.1f} +- {math.degrees(sd):.1f} deg"
    return f"{name} {1000 * off:+.0f} +- {1000 * sd:.0f} mm"


def _move(observations: Observations) -> Move | str:
    live: Live | None = observations.live
    if live is None:
        return NOT_RUNNING
    return NOT_MOVED if live.move is None else live.move


def _stood(leg: Leg) -> bool:
    """By the odometry, and by the images where they say something."""
    axis = 0 if leg.asked[0] else 2
    least = STOOD * abs(float(leg.asked[axis]))
    return all(abs(float(pose[axis])) < least for pose in (leg.odometry, leg.images) if pose is not None)


def _pairs(move: Move, axis: int) -> Array:
    """(2, n) odometry and images along the axis, of the pieces that moved by images that saw both of their ends."""
    rows = [
        (float(leg.odometry[axis]), float(leg.images[axis]))
        for leg in move.legs
        if leg.images is not None and abs(float(leg.images[axis])) > STOOD * abs(float(leg.asked[axis])) > 0.0
    ]
    return np.array(rows).reshape(-1, 2).T


def _calibration(observations: Observations) -> Calibration | str:
    """Or why there is none."""
    move = _move(observations)
    if isinstance(move, str):
        return move
    if odometry_sign(observations).ok is False or obeys(observations).ok is False:
        return "odometry and command path come first"
    live, setup = observations.live, observations.setup
    camera = (live.pictures.info if live is not None else None) or setup.camera
    if setup.chair is None or setup.dock is None or camera is None:
        return "a file is not in order"
    if move.drive is None:
        return "too few images showed a marker"
    try:
        solution = solve(move.drive, camera, setup.chair.camera, setup.dock, Lengths(), MOST_IMAGES)
    except (DriveError, NoMinimumError) as error:
        return str(error)
    return judge(solution, setup.dock, Lengths())
