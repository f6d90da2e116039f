"""Who drives the chair while a bag is recorded: a person by the eye, or the scripted drive of the identification."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair
from seater_eval.campaign.drive.chain import Gate
from seater_identify.drive.driver import Driver, DriveState
from seater_identify.settings import IdentifySettings
from seater_tools.trial.drive import Script, commands_by_eye

Array = NDArray[np.float64]


class Pilot(Protocol):
    """Asked once for each trial.drive.PERIOD."""

    def odometry(self, stamp: float, pose: ArrayLike, now: float) -> None:
        """Pose (3,) of base_link in odom as it arrives; times in [s]."""

    def command(self, now: float, true_pose: Array) -> tuple[float, float] | None:
        """(v [m/s], omega [rad/s]) for the motors, `true_pose` (3,) in the true dock frame; None: the drive is over."""


class ByEye:
    """Somebody with a joystick, who sees the dock."""

    def __init__(self, script: Script) -> None:
        self._pose = np.zeros(3)
        self._commands: Iterator[tuple[float, float]] = commands_by_eye(script, lambda: self._pose)

    def odometry(self, stamp: float, pose: ArrayLike, now: float) -> None:
        """Nobody looks at it."""

    def command(self, now: float, true_pose: Array) -> tuple[float, float] | None:
        self._pose = true_pose
        return next(self._commands, None)


class Identification:
    """identify_node with the safety gate behind it. `text`: how the drive ended."""

    def __init__(self, settings: IdentifySettings, chair: Chair, safety: dict[str, float]) -> None:
        """Raises AreaError, ParameterError where the node would not start."""
        self._driver, self._gate = Driver(settings, chair), Gate(chair, safety)

    @property
    def text(self) -> str:
        return self._driver.text

    @property
    def done(self) -> bool:
        """The whole script was driven."""
        return self._driver.state is DriveState.DONE

    def odometry(self, stamp: float, pose: ArrayLike, now: float) -> None:
        self._driver.odometry(stamp, pose, now)

    def command(self, now: float, true_pose: Array) -> tuple[float, float] | None:
        if self._driver.state is DriveState.READY:
            self._driver.start(now)  # refused until odometry has arrived
        elif self._driver.state is not DriveState.DRIVING:
            return None
        return self._gate.pass_on(now, *self._driver.command(now))
