"""What the closed-loop runner drives: any controller of a unicycle towards the origin."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike


class PoseController(Protocol):
    """Pose (x [m], y [m], heading [rad]) of base_link in the dock's frame and its speeds in, speeds out.

    The docking pose is the origin. Acceleration limits that a method does not know of are applied by the runner.
    """

    name: str
    period: float  # of control [s]

    def reset(self) -> None:
        """Forget everything, as before a new start."""

    def command(self, T_dock_base: ArrayLike, velocity: tuple[float, float]) -> tuple[float, float]:
        """(v [m/s], omega [rad/s]) for the coming period; `velocity` is what the chair has now."""
