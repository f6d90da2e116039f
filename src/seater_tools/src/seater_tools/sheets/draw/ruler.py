"""The bar that checks the printer's scale."""

from __future__ import annotations

from seater_tools.sheets.draw.pen import Pen
from seater_tools.sheets.layout.paper import UNPRINTABLE, Paper
from seater_tools.sheets.layout.rect import Rect

THICK = 4.0  # [mm]
RAIL = 0.3  # [mm] lines along the bar


def draw_bar(pen: Pen, x: float, y: float, length: float, upright: bool = False) -> None:
    """Black and white centimetres from (x, y), to the right or upwards; outer edges are `length` apart."""
    blocks = [(10.0 * i, 10.0 * i + 10.0, 0.0, THICK) for i in range(0, round(length / 10), 2)]
    blocks += [(0.0, length, 0.0, RAIL), (0.0, length, THICK - RAIL, THICK)]
    pen.fill(_placed(x, y, block, upright) for block in blocks)
    for at in (0.0, 100.0, length):
        words = f"{at:.0f}" + (" mm" if at == length else "")
        if upright:
            pen.text(x - 1.0, y + at, words, 7.0, "middle", turned=True)
        else:
            pen.text(x + at, y + THICK + 1.0, words, 7.0, "middle")


def _placed(x: float, y: float, block: tuple[float, float, float, float], upright: bool) -> Rect:
    a, b, low, high = block
    return Rect(x + low, y + a, x + high, y + b) if upright else Rect(x + a, y + low, x + b, y + high)


def draw_footer(pen: Pen, width: float, paper: Paper, source: str) -> None:
    """Bar and what to do with it, at the lower edge of a page of this width. `source`: option that names the dock."""
    left = 0.5 * (width - paper.bar)
    draw_bar(pen, left, UNPRINTABLE + 1.0, paper.bar)
    first = f"Measure this bar from end to end: {paper.bar:.0f} mm? If not, print again at 100 % (actual size), or"
    second = f"./seater sheets {source} --paper {paper.name} --measured-bar MILLIMETRES"
    pen.text(left, UNPRINTABLE + 15.5, first, 7.5, fit=paper.bar)
    pen.text(left, UNPRINTABLE + 11.5, second, 7.5, fit=paper.bar)
