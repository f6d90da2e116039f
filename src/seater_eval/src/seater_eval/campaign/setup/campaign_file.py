"""The campaign file: which axes there are, the variants of each, starts, and the bars that the whole has to meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from seater_common.params import ParameterError, load, param, read_yaml

# What a variant may change: a configuration file as a whole (by its name), or keys of it.
FILES = ("plant", "chair_file", "dock_file", "camera_file", "controller_file", "perception_file")
KEYS = ("chair", "dock", "controller", "perception", "safety", "start")
KEYS_OF_SIMULATION = ("simulator", "simulated_chair", "simulated_dock")
ALLOWED = FILES + KEYS + KEYS_OF_SIMULATION


@dataclass(frozen=True)
class Start:
    """Where the chair stands when the goal is given: base_link in the dock's frame, each uniformly distributed."""

    x: list[float] = param([-4.0, -1.0], "m", "lowest and highest", length=2, low=-10.0, high=10.0)
    y: list[float] = param([-1.5, 1.5], "m", "lowest and highest", length=2, low=-10.0, high=10.0)
    heading: list[float] = param([-60.0, 60.0], "deg", "lowest and highest", length=2, low=-360.0, high=360.0)
    mirror: bool = param(False, "", "y and heading change their signs in half of the cases")
    clearance: float = param(0.1, "m", "smallest distance from walls and obstacles", low=0.0, high=2.0)
    seen: bool = param(True, "", "perception finds the dock in an image from there (without noise of motion)")
    rough_pose: bool = param(False, "", "the goal carries a rough pose of the dock")
    rough_position_sd: float = param(0.2, "m", "its error along each axis, standard deviation", low=0.0, high=2.0)
    rough_heading_sd: float = param(5.0, "deg", "its error in heading, standard deviation", low=0.0, high=90.0)

    def __post_init__(self) -> None:
        for name in ("x", "y", "heading"):
            low, high = getattr(self, name)
            if low > high:
                raise ValueError(f"{name}: is {[low, high]!r}, the lowest must not be above the highest")


@dataclass(frozen=True)
class CampaignBars:
    """What the campaign has to reach; a command that misses one ends with exit code 1."""

    docked: float = param(0.98, "", "smallest share of docked runs", low=0.0, high=1.0)
    touched: float = param(0.0, "", "largest share of runs that touched a wall", low=0.0, high=1.0)
    position_p95: float = param(5.0, "mm", "95th percentile of the true final error", low=0.0)
    heading_p95: float = param(0.6, "deg", "the same for the heading", low=0.0)
    reversals_p95: float = param(1.0, "", "95th percentile of changes between forward and backward", low=0.0)
    realtime_factor: float = param(1.5, "", "smallest simulated time over computing time of one core", low=0.0)


@dataclass(frozen=True)
class CampaignSettings:
    """A campaign file without its axes."""

    name: str = param("default", "", "of the campaign, for reports")
    require_contact: bool = param(True, "", "success needs the charging contact")
    longest: float = param(180.0, "s", "simulated time after which a run is given up", low=1.0, high=3600.0)
    rest: float = param(3.0, "s", "simulated time after the result, in which the chair has to come to rest", low=0.1)
    start: Start = field(default_factory=Start)
    bars: CampaignBars = field(default_factory=CampaignBars)


@dataclass(frozen=True)
class Campaign:
    """A whole campaign file (docs/how-to/run_a_campaign.md)."""

    settings: CampaignSettings
    axes: dict[str, dict[str, dict[str, Any]]]  # axis -> variant -> what it changes


def load_campaign(path: Path) -> Campaign:
    """Strict: every key has to be there. Raises ParameterError, naming file and key."""
    values = read_yaml(path)
    return campaign_from(values, path.name)


def campaign_from(values: Any, prefix: str) -> Campaign:
    """Of the mapping that YAML gives. Raises ParameterError, naming every wrong key."""
    if not isinstance(values, Mapping):
        raise ParameterError(f"{prefix}: is {values!r}, must be a mapping with the keys of a campaign file")
    axes = _axes(values.get("axes"), prefix)
    settings = load(CampaignSettings, {key: value for key, value in values.items() if key != "axes"}, prefix)
    return Campaign(settings, axes)


def only(campaign: Campaign, axes: Sequence[str]) -> Campaign:
    """Only these axes are varied, the others stay at their first variant. Raises ParameterError."""
    unknown = [axis for axis in axes if axis not in campaign.axes]
    if unknown:
        raise ParameterError(f"--axes: {unknown[0]!r} is unknown; known are {', '.join(campaign.axes)}")
    kept = {}
    for axis, variants in campaign.axes.items():
        first = next(iter(variants))
        kept[axis] = variants if axis in axes else {first: variants[first]}
    return Campaign(campaign.settings, kept)


def _axes(values: Any, prefix: str) -> dict[str, dict[str, dict[str, Any]]]:
    problems: list[str] = []
    if not isinstance(values, Mapping) or not values:
        raise ParameterError(f"{prefix}/axes: is {values!r}, must name at least one axis")
    for axis, variants in values.items():
        if not isinstance(variants, Mapping) or not variants:
            problems.append(f"{prefix}/axes/{axis}: is {variants!r}, must name at least one variant")
            continue
        for name, changes in variants.items():
            key = f"{prefix}/axes/{axis}/{name}"
            if not isinstance(changes, Mapping):
                problems.append(f"{key}: is {changes!r}, must be a mapping; {{}} changes nothing")
                continue
            unknown = [entry for entry in changes if entry not in ALLOWED]
            problems += [f"{key}/{entry}: unknown; known are {', '.join(ALLOWED)}" for entry in unknown]
    if problems:
        raise ParameterError("wrong campaign file:\n  " + "\n  ".join(problems))
    return {str(a): {str(n): dict(c) for n, c in variants.items()} for a, variants in values.items()}
