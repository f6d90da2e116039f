"""Teaches a dock file from messages, live or of a bag; needs no running ROS."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from seater_common.files.whole import replace_kept
from seater_common.geometry import Chair, Dock, planar_pose
from seater_common.messages import matrix_of_pose
from seater_common.params import ParameterError, load_file
from seater_tools.teach.dock import remarks, taught_text
from seater_tools.teach.measure import Measurement, Standing, TeachError


@dataclass(frozen=True)
class Files:
    """`target`: where the taught dock file goes; it may be `dock` itself."""

    dock: Path
    chair: Path
    target: Path


@dataclass(frozen=True)
class Answer:
    """`text`: what was done, or why not."""

    success: bool
    text: str


class Teacher:
    """Messages as they come, `confirm` or `check` at any time. Raises ParameterError: a file is wrong."""

    def __init__(self, files: Files) -> None:
        self._files, self._standing = files, Standing()
        self.dock = load_file(Dock, files.dock)
        self._T_base_optical = load_file(Chair, files.chair).camera.T_base_optical()
        self._taught = False

    def odometry(self, message: Any) -> None:
        """A nav_msgs/Odometry."""
        self._standing.odometry(message.header.stamp.to_sec(), planar_pose(matrix_of_pose(message.pose.pose)))

    def detections(self, message: Any) -> None:
        """A seater_msgs/MarkerDetectionArray."""
        if not message.dock:
            return
        best = message.dock[0]
        R = self._T_base_optical[:3, :3]
        rotation = np.zeros((6, 6))
        rotation[:3, :3] = rotation[3:, 3:] = R
        covariance = rotation @ np.reshape(np.array(best.pose.covariance, dtype=float), (6, 6)) @ rotation.T
        pose = planar_pose(self._T_base_optical @ matrix_of_pose(best.pose.pose))
        planar = covariance[np.ix_([0, 1, 5], [0, 1, 5])]
        self._standing.dock(message.header.stamp.to_sec(), pose, planar, best.weight)

    def state(self) -> str:
        """One line for a person who drives the chair in."""
        try:
            return f"ready: {self._words(self._standing.measure())}"
        except TeachError as error:
            return str(error)

    def confirm(self) -> Answer:
        """Store where the chair stands."""
        try:
            if self._taught:
                raise TeachError("it is taught; restart this and perception with the new dock file to teach again")
            measured, now = self._standing.measure(), datetime.datetime.now(datetime.UTC)
            text = taught_text(self._files.dock.read_text(), str(self._files.dock), self.dock, measured, now)
            written = replace_kept(text, self._files.target, now)
        except (TeachError, ParameterError, OSError) as error:
            return Answer(False, str(error))
        self._taught = True
        kept = f"; the one before is kept as {written[1]}" if len(written) > 1 else ""
        lines = [f"{self._words(measured)}; taught in {written[0]}{kept}", *remarks(self.dock, measured)]
        return Answer(True, ". ".join(lines))

    def check(self) -> Answer:
        """Success: the chair stands docked, within the tolerance of the dock file."""
        try:
            measured = self._standing.measure()
        except TeachError as error:
            return Answer(False, str(error))
        x, y, heading = self.dock.docking_error(measured.pose)
        tolerance = self.dock.tolerance
        docked = float(np.hypot(x, y)) <= tolerance.position and abs(heading) <= tolerance.heading
        return Answer(docked, f"{self._words(measured)}: {'docked' if docked else 'not docked'}")

    def _words(self, measured: Measurement) -> str:
        x, y, heading = self.dock.docking_error(measured.pose)
        return (
            f"the chair stands {1000 * x:.1f} mm ahead, {1000 * y:.1f} mm left, {np.degrees(heading):.2f} deg off the "
            f"docked pose of the file ({measured.count} measurements)"
        )
