"""What each kind of area brings along: its geometry, and the soft constraint that it puts on every stage."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
A = TypeVar("A")


class Slack(IntEnum):
    """The slack variable of a stage that makes a constraint soft; its value is its row among the stage's slacks."""

    weight: str  # the field of parameters.Weights that penalises it
    is_violation: bool  # reported as a violation of the plan; what is not is a wish

    AREA = "violation", True  # [m] by which the footprint is inside a prohibited area
    SPEED = "violation", True  # [m/s] beyond the allowed speed
    VIEW = "view", False  # [m] across the line of sight

    def __new__(cls, weight: str, is_violation: bool) -> Slack:
        row = len(cls.__members__)
        kind = int.__new__(cls, row)
        kind._value_, kind.weight, kind.is_violation = row, weight, is_violation
        return kind


@dataclass(frozen=True)
class Stage:
    """The chair at the end of one step of the prediction, in the target's frame."""

    index: int  # 0: after the first step
    pose: ca.SX  # (3,) x, y, heading
    v: ca.SX  # [m/s]
    footprint: ca.SX  # (4, 2) its corners


class Area(Protocol):
    """The geometry of one kind of area; it knows the constraint that it becomes."""

    def transformed(self, change: Array) -> Area:
        """The same area in another frame, in which the present frame has the pose `change` (x, y, heading)."""

    def constraint(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme) -> AreaConstraint[Any]:
        """A constraint for areas with as many parts as this one has, its parameters added to the programme."""


class AreaConstraint(ABC, Generic[A]):
    """margin + slack >= 0 at every stage, for one kind of area.

    Where the area lies comes with each instance, in parameters of the programme and in bounds of own variables; so a
    constraint is built once. Most kinds need no own variables.
    """

    slack: ClassVar[Slack]

    def __init__(self) -> None:
        self.symbols: list[ca.SX] = []  # own variables of each stage
        self.places: list[slice] = []  # and where they stand in x

    def add_variables(self, programme: StageProgramme) -> None:
        """Add the own variables of the next stage."""

    @abstractmethod
    def margins(self, stage: Stage) -> list[ca.SX]:
        """How far the stage is from violating the area, column vectors [m or m/s]; negative: violated."""

    @abstractmethod
    def set_instance(self, area: A, p: Array, lower: Array, upper: Array) -> None:
        """Write where the area lies into the parameters and into the bounds of own variables."""

    def guess(self, area: A, states: Array, x: Array) -> None:
        """Write an initial guess of own variables into x, for the trajectory `states` (N + 1, >= 3)."""

    def best(self, stage: Stage, lower: ca.SX, upper: ca.SX) -> ca.SX:
        """The stage's own variables with the largest margin at its pose, within the bounds (of all variables)."""
        raise NotImplementedError


def columns(places: list[slice]) -> Indices:
    """Indices of slices of one length, (n, length)."""
    return np.array([np.arange(where.start, where.stop) for where in places], dtype=np.intp)
