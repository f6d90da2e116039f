"""A PDF in millimetres, y up."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import matplotlib
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont
from reportlab.pdfgen.canvas import Canvas

from seater_common.command.typed import as_typed
from seater_tools.sheets.layout.rect import Rect

FONTS = {"DejaVuSans": "DejaVuSans.ttf", "DejaVuSans-Bold": "DejaVuSans-Bold.ttf"}
SMALLEST = 4.0  # [pt] text that has to fit becomes no smaller


class Pen:
    """Draws pages. `grey`: 0 black, 1 white. The same calls give the same bytes."""

    def __init__(self, title: str) -> None:
        folder, known = Path(matplotlib.get_data_path()) / "fonts" / "ttf", pdfmetrics.getRegisteredFontNames()
        for name, file in FONTS.items():  # embedded: the PDF looks the same everywhere
            if name not in known:  # read once: it takes longer than to draw a page
                pdfmetrics.registerFont(TTFont(name, str(folder / file)))
        self.pages = 0
        self._buffer = io.BytesIO()
        self._canvas = Canvas(self._buffer, invariant=1)
        self._canvas.setTitle(title)
        self._canvas.setViewerPreference("PrintScaling", "None")  # viewers then offer "actual size" first

    def finish(self) -> bytes:
        """The PDF. Nothing can be drawn afterwards."""
        self._canvas.save()
        return self._buffer.getvalue()

    @contextmanager
    def page(self, width: float, height: float) -> Iterator[None]:
        self._canvas.setPageSize((width * mm, height * mm))
        yield
        self._canvas.showPage()
        self.pages += 1

    @contextmanager
    def shifted(self, x: float, y: float, clip: Rect | None = None) -> Iterator[None]:
        """Origin at (x, y); with `clip`, in the new coordinates, nothing is drawn outside of it."""
        self._canvas.saveState()
        self._canvas.translate(x * mm, y * mm)
        if clip is not None:
            path = self._canvas.beginPath()
            path.rect(clip.x0 * mm, clip.y0 * mm, clip.width * mm, clip.height * mm)
            self._canvas.clipPath(path, stroke=0, fill=0)
        yield
        self._canvas.restoreState()

    def fill(self, rects: Iterable[Rect], grey: float = 0.0) -> None:
        """As ONE path: rectangles that touch show no hairline between them, however they are smoothed."""
        path = self._canvas.beginPath()
        for r in rects:
            path.rect(r.x0 * mm, r.y0 * mm, r.width * mm, r.height * mm)
        self._canvas.setFillGray(grey)
        self._canvas.drawPath(path, stroke=0, fill=1)

    def polygon(self, points: Sequence[tuple[float, float]], grey: float = 0.0) -> None:
        path = self._canvas.beginPath()
        path.moveTo(points[0][0] * mm, points[0][1] * mm)
        for x, y in points[1:]:
            path.lineTo(x * mm, y * mm)
        path.close()
        self._canvas.setFillGray(grey)
        self._canvas.drawPath(path, stroke=0, fill=1)

    def line(
        self,
        start: tuple[float, float],
        end: tuple[float, float],
        width: float = 0.15,
        grey: float = 0.0,
        dash: Sequence[float] = (),
    ) -> None:
        self._canvas.setStrokeGray(grey)
        self._canvas.setLineWidth(width * mm)
        self._canvas.setDash([length * mm for length in dash])
        self._canvas.line(start[0] * mm, start[1] * mm, end[0] * mm, end[1] * mm)

    def frame(self, rect: Rect, width: float = 0.15, grey: float = 0.0) -> None:
        self._canvas.setStrokeGray(grey)
        self._canvas.setLineWidth(width * mm)
        self._canvas.setDash([])
        self._canvas.rect(rect.x0 * mm, rect.y0 * mm, rect.width * mm, rect.height * mm, stroke=1, fill=0)

    def circle(self, x: float, y: float, radius: float, width: float = 0.15) -> None:
        self._canvas.setStrokeGray(0.0)
        self._canvas.setLineWidth(width * mm)
        self._canvas.setDash([])
        self._canvas.circle(x * mm, y * mm, radius * mm, stroke=1, fill=0)

    def text(
        self,
        x: float,
        y: float,
        words: str,
        size: float = 8.0,
        align: str = "left",
        bold: bool = False,
        fit: float | None = None,
        turned: bool = False,
        clear: bool = False,
    ) -> None:
        """One line, its base line at y. `size` in points; `align`: left, middle, right; `fit`: [mm] becomes smaller to
        be no wider; `turned`: reads upwards; `clear`: on white, whatever was drawn there."""
        words = as_typed(words)
        font = "DejaVuSans-Bold" if bold else "DejaVuSans"
        if fit is not None:
            size = max(SMALLEST, min(size, size * fit / max(self.width(words, size, bold), 1e-6)))
        width, height = self.width(words, size, bold), 0.26 * size  # [mm] of capitals and figures
        back = {"left": 0.0, "middle": 0.5, "right": 1.0}[align] * width
        self._canvas.saveState()
        self._canvas.translate(x * mm, y * mm)
        if turned:
            self._canvas.rotate(90)
        if clear:
            self.fill([Rect(-back - 0.5, -0.4, width - back + 0.5, height + 0.4)], grey=1.0)
        self._canvas.setFillGray(0.0)
        self._canvas.setFont(font, size)
        self._canvas.drawString(-back * mm, 0.0, words)
        self._canvas.restoreState()

    @staticmethod
    def width(words: str, size: float, bold: bool = False) -> float:
        """Of a line of text [mm]."""
        return float(pdfmetrics.stringWidth(words, "DejaVuSans-Bold" if bold else "DejaVuSans", size)) / mm
