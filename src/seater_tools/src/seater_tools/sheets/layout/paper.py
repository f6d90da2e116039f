"""Sizes of paper, and what is the same on every sheet of one."""

from __future__ import annotations

from dataclasses import dataclass

UNPRINTABLE = 5.0  # [mm] at every edge; laser printers leave 4.2 mm free, most inkjets less
HEADER = 18.0  # [mm] from the upper edge: two lines of text
FOOTER = 28.0  # [mm] from the lower edge: the bar and two lines of text


@dataclass(frozen=True)
class Paper:
    """A sheet of paper, upright [mm]."""

    name: str
    width: float
    height: float

    @property
    def bar(self) -> float:
        """Length of the bar that checks the printer's scale [mm].

        As long as fits, because the error of reading a ruler divides by it. The same in both directions and on every
        page, so that one number says what was printed. An odd number of centimetres: both ends are black.
        """
        room = self.width - 4 * UNPRINTABLE
        return 10.0 * (room // 10 - (room // 10 + 1) % 2)


PAPERS = {paper.name: paper for paper in (Paper("a4", 210.0, 297.0), Paper("a3", 297.0, 420.0))}
