"""What contradicts itself among the inputs: two nodes that send one of them, or a camera that becomes another one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sensor_msgs.msg import CameraInfo

from seater_common.inputs.senders import Senders, sender_of
from seater_nmpc.sequence.goal.results import ResultCode

ODOMETRY, OBSTACLES = "odom", "obstacles"
# What a second sender makes of a docking. A chair that does not know what is in the way waits, and then says so.
CODES = {
    ODOMETRY: ResultCode.ODOMETRY_WRONG,
    "detections": ResultCode.INCONSISTENT,
    "camera_info": ResultCode.INCONSISTENT,
}
_CONFIRMED = 2  # camera_info in a row that are others: one may be broken


class Inputs:
    """`heard` and `calibrated` from the threads of the subscribers; asked by the worker."""

    def __init__(self, names: dict[str, str], usable: Callable[[CameraInfo], bool]) -> None:
        """`names`: of the topics by what they are here, for people; `usable`: whether it is the calibration of a
        camera."""
        self._senders = {kind: Senders(name) for kind, name in names.items()}
        self._usable = usable
        self._before: CameraInfo | None = None  # the first of this goal
        self._others, self._changed = 0, ""  # how many in a row are not like it; what has changed, in words

    def heard(self, kind: str, message: Any) -> None:
        """A message came."""
        if kind in self._senders:
            self._senders[kind].heard(sender_of(message))

    def calibrated(self, message: CameraInfo) -> None:
        """A camera_info came. One that perception cannot use says nothing: it shows no dock."""
        self.heard("camera_info", message)
        before = self._before
        if before is None:
            self._before = message if self._usable(message) else None
        elif _lens(before) == _lens(message):
            self._others = 0
        elif self._usable(message):
            self._others += 1
            if self._others >= _CONFIRMED and not self._changed:
                self._changed = (
                    f"camera_info has changed during the goal ({_difference(before, message)}): one is wrong"
                )

    def begin(self) -> None:
        """A goal begins: its camera is the one that is heard from now on, and what is over is over."""
        for senders in self._senders.values():
            senders.forget()
        self._before, self._others, self._changed = None, 0, ""

    def contradiction(self, *, sees: bool) -> tuple[ResultCode, str] | None:
        """Why a goal has to end; `sees`: it goes by images, too."""
        for kind, code in CODES.items() if sees else [(ODOMETRY, CODES[ODOMETRY])]:
            trouble = self._senders[kind].trouble()
            if trouble:
                return code, trouble
        return (ResultCode.INCONSISTENT, self._changed) if sees and self._changed else None

    def unsure(self) -> str:
        """Why it is not known what is in the way, in words; empty: it is."""
        return self._senders[OBSTACLES].trouble()


def _lens(info: CameraInfo) -> tuple[Any, ...]:
    """What has to stay; as text, so that what is not a number equals itself."""
    numbers = (*info.K, *info.D, *info.R, *info.P)
    return info.header.frame_id, info.width, info.height, info.distortion_model, repr(numbers)


def _difference(before: CameraInfo, after: CameraInfo) -> str:
    shown = {
        "frame": (before.header.frame_id, after.header.frame_id),
        "size": (f"{before.width} x {before.height}", f"{after.width} x {after.height}"),
        "fx": (f"{before.K[0]:.1f}", f"{after.K[0]:.1f}"),
        "cx": (f"{before.K[2]:.1f}", f"{after.K[2]:.1f}"),
    }
    return ", ".join(f"{name} {a} to {b}" for name, (a, b) in shown.items() if a != b) or "distortion, R or P"
