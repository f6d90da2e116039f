"""Parameters of the planner (`planner:` in config/controller.yaml)."""

from __future__ import annotations

from dataclasses import dataclass

from seater_common.params import param


@dataclass(frozen=True)
class PlannerParameters:
    """The search for a way to the bay (seater_nmpc.plan.planner)."""

    cell: float = param(0.1, "m", "side of a cell of the lattice", low=0.05, high=0.3)
    reach: float = param(5.5, "m", "how far ahead of the dock the lattice begins", low=2.0, high=12.0)
    half_width: float = param(3.0, "m", "how far to both sides it goes", low=1.0, high=8.0)
    extra_margin: float = param(
        0.03, "m", "distance from walls and obstacles on top of control/margin", low=0.0, high=0.3
    )
    blind_factor: float = param(10.0, "", "cost factor of a second without the markers in view", low=1.0, high=1000.0)
    lane: float = param(1.5, "m", "how far ahead of the bay the path may join the dock's axis", low=0.0, high=5.0)
    lookahead: float = param(1.5, "m", "how far ahead on the path the target is among obstacles", low=0.3, high=5.0)
    turn_length: float = param(0.4, "m/rad", "length that a turn counts as along the path", low=0.05, high=2.0)
    reached_position: float = param(
        0.12, "m", "distance at which a turning point counts as reached", low=0.02, high=0.5
    )
    reached_heading: float = param(0.25, "rad", "the same for the heading", low=0.02, high=1.0)
    replan_distance: float = param(
        0.5, "m", "distance from the path beyond which a new one is searched", low=0.1, high=2.0
    )
    obstacle_shift: float = param(
        0.05, "m", "shift of an obstacle beyond which the path is checked anew", low=0.001, high=0.5
    )
