"""Whether the sizes in a dock file follow from a measured bar."""

from __future__ import annotations

from seater_tools.correct.scale import reading_error
from seater_tools.correct.sizes import CORRECTED
from seater_tools.sheets.layout.paper import PAPERS


def bar_sd(text: str) -> float | None:
    """Standard deviation of a factor common to all sizes, by the first line that `seater sheets` writes with
    --measured-bar; None: no bar was measured."""
    first = text.partition("\n")[0]
    if not first.startswith(CORRECTED):
        return None
    return next((reading_error(paper) for paper in PAPERS.values() if f"mm on {paper.name}:" in first), None)
