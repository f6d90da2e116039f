"""One case again, with a figure of what happened."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt

from seater_eval.campaign.drive.job import CampaignJob, docking_row
from seater_eval.campaign.report.docking_figure import draw_docking
from seater_eval.campaign.report.page import embedded
from seater_nmpc.sequence.goal.results import Phase


def replay(job: CampaignJob) -> tuple[dict[str, Any], Any | None]:
    """The row of the table, and the figure; None where the docking did not begin."""
    row, started = docking_row(job)
    if started is None:
        return row, None
    c, run = started
    trace, phases = run.trace, [phase.name for phase in Phase]
    figure = draw_docking(row, trace.truth, trace.cycles, trace.images, phases, c.simulated_dock, c.simulated_chair)
    return row, figure


def replay_embedded(job: CampaignJob) -> tuple[dict[str, Any], str]:
    """The same with the figure as an image for a page, empty without one; for other processes."""
    row, figure = replay(job)
    return row, "" if figure is None else embedded(figure, "png")


def save_replay(job: CampaignJob, path: Path) -> tuple[dict[str, Any], Path | None]:
    """The same with the figure in a PNG file."""
    row, figure = replay(job)
    if figure is None:
        return row, None
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    plt.close(figure)
    return row, path
