"""Dimension lines of a drawing, in millimetres of paper; the numbers are millimetres of the dock."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from seater_tools.sheets.draw.pen import Pen

ARROW = 1.6  # [mm]
NUMBER = 7.5  # [pt]


def number(length: float) -> str:
    """[mm], to a tenth where there is one."""
    return f"{length:.1f}".removesuffix(".0")


def dimension_across(pen: Pen, x0: float, x1: float, y: float, length: float) -> None:
    """From x0 to x1 (x0 < x1) at height y."""
    pen.line((x0, y), (x1, y))
    _arrow(pen, x0, y, ARROW, 0.0)
    _arrow(pen, x1, y, -ARROW, 0.0)
    words, middle = number(length), 0.5 * (x0 + x1)
    if pen.width(words, NUMBER) + 2.0 < x1 - x0:
        pen.text(middle, y + 0.8, words, NUMBER, "middle", clear=True)
    else:
        pen.text(middle + 1.0, y + 1.0, words, NUMBER, turned=True)


def dimension_up(pen: Pen, x: float, y0: float, y1: float, length: float) -> None:
    """From y0 up to y1."""
    pen.line((x, y0), (x, y1))
    _arrow(pen, x, y0, 0.0, ARROW)
    _arrow(pen, x, y1, 0.0, -ARROW)
    pen.text(x - 0.8, 0.5 * (y0 + y1), number(length), NUMBER, "middle", turned=True, clear=True)


def chain_across(pen: Pen, stations: Sequence[tuple[float, float]], y: float) -> None:
    """From each station to the next: place on the paper, place at the dock, in rising order."""
    for (x0, at), (x1, then) in itertools.pairwise(stations):
        dimension_across(pen, x0, x1, y, then - at)


def _arrow(pen: Pen, x: float, y: float, dx: float, dy: float) -> None:
    """A head with its tip at (x, y), that comes from (x + dx, y + dy)."""
    pen.polygon([(x, y), (x + dx + 0.25 * dy, y + dy + 0.25 * dx), (x + dx - 0.25 * dy, y + dy - 0.25 * dx)])
