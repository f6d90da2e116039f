"""Faults that begin on the way: of the chair, its odometry, or its images. From then on they last."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seater_common.geometry import Marker, pose_matrix
from seater_eval.judge.plant.chair import IndependentChair
from seater_nmpc.observe.measurement import Hypothesis
from seater_nmpc.observe.odometry.message import Odometry

KINDS = {
    "frozen_images": "the last image again and again, under new stamps",
    "frozen_odometry": "the last pose again and again, under new stamps",
    "spinning": "the wheels turn, the chair stands",
    "stuck": "wheels and chair stand",
    "runaway": "goes on as it drove, at least at 0.15 m/s, until the goal has ended (then the power is cut)",
    "reversed": "drives and turns the other way than asked for",
    "shifted": "images agree on a dock that is VALUE [m] to the side",
    "refocused": "the focal length is told too long by the share VALUE",
    "uncertain": "images are off by VALUE [m], with covariances of 1e6",
}
_RUNS_AWAY = 0.15  # [m/s] at least


@dataclass(frozen=True)
class Fault:
    """`kind` of KINDS; begins when base_link is at `x` [m] of the dock's frame."""

    kind: str
    value: float = 0.3
    x: float = -1.0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"fault: is {self.kind!r}, must be one of {', '.join(KINDS)}")


class Injector:
    """Between the chair, its sensors and the driver."""

    def __init__(self, fault: Fault | None, markers: Sequence[Marker] = ()) -> None:
        """`markers`: of the dock, for what is wrong with the images of them."""
        self._fault = fault
        self._middle = np.mean([marker.position for marker in markers], axis=0) if markers else np.zeros(3)
        self.began: float | None = None  # [s]
        self._over = False
        self._pose: tuple[float, float, float] | None = None
        self._odometry: Odometry | None = None
        self._image: list[Hypothesis] = []
        self._speeds = (0.0, 0.0)

    def _acts(self, *kinds: str) -> bool:
        return self.began is not None and not self._over and self._fault is not None and self._fault.kind in kinds

    def time(self, now: float, chair: IndependentChair, ended: bool) -> None:
        """Another step; `ended`: the driver has its result."""
        if self._fault is not None and self.began is None and not ended and chair.x >= self._fault.x:
            self.began = now
            self._speeds = max(chair.v, _RUNS_AWAY), chair.omega
        self._over = self._over or (ended and self._acts("runaway"))

    def command(self, v: float, omega: float) -> tuple[float, float]:
        """What reaches the motors."""
        if self._acts("runaway"):
            return self._speeds
        return (-v, -omega) if self._acts("reversed") else (v, omega)

    def step(self, now: float, chair: IndependentChair) -> None:
        """The chair's own step, unless it cannot move."""
        before, rolled = (chair.x, chair.y, chair.heading), list(chair.rolled)
        if self._acts("runaway"):
            chair.command(now, *self._speeds)
        chair.step(now)
        if self._acts("spinning", "stuck"):
            chair.x, chair.y, chair.heading = before
            chair.v = chair.omega = 0.0
        if self._acts("stuck"):
            chair.rolled = rolled

    def odometry(self, message: Odometry) -> Odometry:
        """What the driver gets."""
        if self._acts("frozen_odometry") and self._odometry is not None:
            return dataclasses.replace(self._odometry, stamp=message.stamp, v=0.0, omega=0.0)
        self._odometry = message
        return message

    def image(self, hypotheses: list[Hypothesis]) -> list[Hypothesis]:
        """What perception makes of an image."""
        if self._acts("frozen_images"):
            return self._image
        if self._fault is not None and self._acts("shifted", "uncertain"):
            aside = pose_matrix(np.array([0.0, self._fault.value, 0.0]))
            hypotheses = [dataclasses.replace(h, T_optical_dock=h.T_optical_dock @ aside) for h in hypotheses]
            if self._acts("uncertain"):
                hypotheses = [dataclasses.replace(h, covariance=1e6 * np.eye(6)) for h in hypotheses]
        if self._fault is not None and self._acts("refocused"):
            hypotheses = [self._refocused(h, self._fault.value) for h in hypotheses]
        self._image = hypotheses or self._image
        return hypotheses

    def _refocused(self, hypothesis: Hypothesis, share: float) -> Hypothesis:
        """The markers' middle seems farther away by this share, at the same place in the image."""
        T = hypothesis.T_optical_dock.copy()
        T[2, 3] += share * float(T[2, :3] @ self._middle + T[2, 3])
        return dataclasses.replace(hypothesis, T_optical_dock=T)


def parse(text: str) -> Fault:
    """KIND[:VALUE][@X]. Raises ValueError, naming what is allowed."""
    rest, _, x = text.partition("@")
    kind, _, value = rest.partition(":")
    try:
        fault = Fault(kind, *(float(number) for number in [value or 0.3, x or -1.0]))
    except ValueError as error:
        if kind not in KINDS:
            raise
        raise ValueError(f"fault: is {text!r}, must be KIND[:VALUE][@X] with numbers") from error
    if not (math.isfinite(fault.value) and math.isfinite(fault.x)):
        raise ValueError(f"fault: is {text!r}, must be finite")
    return fault
