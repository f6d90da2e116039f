"""Which faults there are, and reading a wish for one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

CLEAR = "clear"  # every component: whole again


@dataclass(frozen=True)
class Kind:
    """A kind of fault: what it does, and the numbers that it takes."""

    text: str
    values: tuple[str, ...] = ()
    optional: int = 0  # so many of the last values may be left out and are then zero

    def read(self, values: Sequence[float]) -> tuple[float, ...]:
        """The values, complete.

        Raises:
            ValueError: too few, too many, or one that is not finite.
        """
        least, most = len(self.values) - self.optional, len(self.values)
        if not least <= len(values) <= most:
            wanted = f"{least} to {most}" if self.optional else str(most)
            raise ValueError(f"takes {wanted} values ({', '.join(self.values) or 'none'}), got {len(values)}")
        if not all(map(math.isfinite, values)):
            raise ValueError("a value is not finite")
        return (*map(float, values), *[0.0] * (most - len(values)))


PLANT = {
    "runaway": Kind("moves by itself, whatever is asked", ("V [m/s]", "OMEGA [rad/s]"), 1),
    "stuck": Kind("the motors do not turn"),
    "left_motor_dead": Kind("only the right motor turns"),
    "right_motor_dead": Kind("only the left motor turns"),
    "reversed": Kind("drives backward when asked to drive forward"),
    "deaf": Kind("goes on with the last command, without a time-out"),
}
ODOMETRY = {
    "frozen": Kind("the same pose and no speed, with fresh stamps"),
    "off": Kind("no message"),
    "zero_stamps": Kind("stamps are 0"),
    "late": Kind("stamps are in the past", ("SECONDS",)),
    "nan": Kind("pose and twist are not numbers"),
    "scale": Kind("ways are so many times what they are", ("FACTOR",)),
    "jump": Kind("the pose jumps once", ("X [m]", "Y [m]", "HEADING [deg]"), 2),
    "zero_twist": Kind("the twist is zero, the pose goes on"),
    "slow": Kind("a message now and then", ("PERIOD [s]",)),
    "other_frame": Kind("of a point ahead of base_link, which child_frame_id says", ("X [m]",)),
}
CAMERA = {
    "frozen": Kind("the same picture again and again, with fresh stamps"),
    "off": Kind("no image"),
    "black": Kind("the lens is covered"),
    "nan": Kind("images of encoding 32FC1, full of NaN"),
    "nan_camera_info": Kind("good images, a camera matrix full of NaN"),
    "cover": Kind("the markers are hidden by a sheet of cardboard"),
    "late": Kind("images arrive later", ("SECONDS",)),
    "slow": Kind("an image now and then", ("PERIOD [s]",)),
    "resized": Kind("camera_info of so many times the image's size", ("FACTOR",)),
    "nan_distortion": Kind("good images, the distortion's first coefficient is NaN"),
    "dock_moved": Kind("somebody moves the markers, all alike", ("X [m]", "Y [m]", "HEADING [deg]"), 2),
    "knocked": Kind("the camera is turned on its mount", ("YAW [deg]", "PITCH [deg]"), 1),
    "shifted": Kind("the picture is shifted", ("RIGHT [px]", "DOWN [px]"), 1),
    "zoomed": Kind("the true focal length is so many times that of camera_info", ("FACTOR",)),
    "focal": Kind("camera_info's focal length is so many times the true one", ("FACTOR",)),
}
COMPONENTS = {"plant": PLANT, "odometry": ODOMETRY, "camera": CAMERA}


def read(component: str, kind: str, values: Sequence[float]) -> tuple[float, ...]:
    """The values of a fault, complete; none for `clear`.

    Raises:
        ValueError: naming what is not known, or the values that the kind takes.
    """
    if component not in COMPONENTS:
        raise ValueError(f"no component {component!r}; there are {', '.join(COMPONENTS)}")
    kinds = COMPONENTS[component] | {CLEAR: Kind("whole again")}
    if kind not in kinds:
        raise ValueError(f"{component} has no fault {kind!r}; it has {', '.join(kinds)}")
    try:
        return kinds[kind].read(values)
    except ValueError as error:
        raise ValueError(f"{component} {kind}: {error}") from None
