"""Rectangles on paper."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Rect:
    """Left, bottom, right, top [mm], y up."""

    x0: float
    y0: float
    x1: float
    y1: float

    @staticmethod
    def centred(width: float, height: float) -> Rect:
        return Rect(-0.5 * width, -0.5 * height, 0.5 * width, 0.5 * height)

    @property
    def width(self) -> float:
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        return self.y1 - self.y0

    @property
    def middle(self) -> tuple[float, float]:
        return 0.5 * (self.x0 + self.x1), 0.5 * (self.y0 + self.y1)

    def shifted(self, dx: float, dy: float) -> Rect:
        return Rect(self.x0 + dx, self.y0 + dy, self.x1 + dx, self.y1 + dy)

    def contains(self, x: float, y: float, tolerance: float = 1e-6) -> bool:
        return self.x0 - tolerance <= x <= self.x1 + tolerance and self.y0 - tolerance <= y <= self.y1 + tolerance
