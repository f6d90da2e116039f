"""Phases and result codes of the docking sequence; the numbers of seater_msgs/Dock.action."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from seater_nmpc.control.command import Command


class Phase(IntEnum):
    """Where the sequence is."""

    WAITING_FOR_DOCK = 0
    APPROACH = 1
    FINAL = 2
    STOPPING = 3
    VERIFY = 4
    RETRY = 5
    UNDOCKING = 6
    CORRECTING = 7
    SEARCHING = 8
    PAUSED = 9
    STAGING = 10
    HOLDING = 11
    CHECK_INSTALLATION = 12


class ResultCode(IntEnum):
    """How a goal ended."""

    SUCCESS = 0
    ALREADY_DOCKED = 1
    CANCELED = 2
    DOCK_NOT_IN_DB = 901
    DOCK_NOT_VALID = 902
    FAILED_TO_STAGE = 903
    FAILED_TO_DETECT_DOCK = 904
    FAILED_TO_CONTROL = 905
    FAILED_TO_CHARGE = 906
    TIMEOUT = 907
    MARKER_LOST = 908
    ODOMETRY_LOST = 909
    NOT_WITHIN_TOLERANCE = 910
    BUSY = 911
    STOPPED_BY_USER = 912
    EMERGENCY_STOP = 913
    GATE_LOST = 914
    INCONSISTENT = 915
    BLOCKED = 916
    NOT_DOCKED = 917
    RUNAWAY = 918
    WRONG_DIRECTION = 919
    ODOMETRY_WRONG = 920
    WHEELS_SLIP = 921
    CLIENT_LOST = 922
    CHARGING = 923
    DOCKED_ELSEWHERE = 924
    NOT_CERTAIN = 925
    UNKNOWN = 999


SUCCESSFUL = (ResultCode.SUCCESS, ResultCode.ALREADY_DOCKED)


class GoalEnd(Exception):  # noqa: N818 - not an error: how a phase hands its result up
    """The goal ends with this result."""

    def __init__(self, code: ResultCode, text: str) -> None:
        self.code, self.text = code, text


@dataclass(frozen=True, kw_only=True)
class Result:
    """The end of a goal. Errors: base_link in the dock's frame, as estimated; zero when the dock is unknown."""

    code: ResultCode
    text: str
    retries: int = 0
    duration: float = 0.0  # [s]
    contact: bool = False
    longitudinal_error: float = 0.0  # [m]
    lateral_error: float = 0.0  # [m]
    heading_error: float = 0.0  # [rad]
    position_sd: float = 0.0  # [m] of that error, in the direction in which it is largest; 0: not verified
    heading_sd: float = 0.0  # [rad]

    @property
    def success(self) -> bool:
        """Whether the chair is docked (or undocked, for that goal)."""
        return self.code in SUCCESSFUL


@dataclass(frozen=True, kw_only=True)
class Step:
    """What one update of the sequence asks for and reports."""

    command: Command  # v and omega to send; zero in the last step of every goal
    phase: Phase
    elapsed: float  # since the goal began [s]
    result: Result | None = None  # set in the last step of a goal
    # From base_link to the docking pose (undocking: still to go) [m]; -1 while the dock is unknown.
    distance: float = -1.0
    lateral_error: float = 0.0  # [m]
    heading_error: float = 0.0  # [rad]
    measurement_age: float = -1.0  # [s]; -1 when never seen
    retries: int = 0

    @property
    def done(self) -> bool:
        """Whether the goal has ended with this step."""
        return self.result is not None
