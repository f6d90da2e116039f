"""The dockings that a set of weights is judged by: cases of a campaign, for this chair's files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from seater_common.files.installation import IDENTIFIED
from seater_common.params import ParameterError, read_yaml
from seater_eval.campaign.drive.job import process_died, run_case
from seater_eval.campaign.plan import Plan, Shard
from seater_eval.campaign.processes import over_processes
from seater_eval.campaign.setup.campaign_file import Campaign
from seater_eval.campaign.setup.configuration import Files
from seater_tools.tune.objective import Measures, measure
from seater_tools.tune.space import changes

HELD_OUT = 1_000_003  # between the seeds of the search and of the comparison
NEARLY = 0.1  # an identified chair is simulated with its values within this share
_LONGEST = 90.0  # [s] a docking that takes longer has failed: good ones take 10 to 30


@dataclass(frozen=True, kw_only=True)
class ChairFiles:
    """Of one chair; camera None: the campaign's own."""

    chair: Path
    dock: Path
    controller: Path
    camera: Path | None = None


class Dockings:
    """The same cases for each set of values: what differs is due to the values."""

    def __init__(
        self, config: Path, own: ChairFiles, *, campaign: str, seed: int, cases: int, images: bool, jobs: int
    ) -> None:
        """Raises ParameterError: a file, the campaign, or both together are wrong."""
        plan = Plan.make(config, campaign, "defaults", seed, cases, Shard())
        longest = min(plan.campaign.settings.longest, _LONGEST)
        axes = dict(plan.campaign.axes)
        if any(line.startswith(IDENTIFIED) for line in own.controller.read_text().splitlines()):
            axes["identified"] = {"chair": _as_identified(read_yaml(own.controller))}
        made = Campaign(replace(plan.campaign.settings, longest=longest), axes)
        self._plan = replace(plan, files=_files(plan.files, own), campaign=made, images=images)
        self._plan.check(config)
        self._jobs = jobs

    @property
    def key(self) -> str:
        """Equal where the results are."""
        return f"{self._plan.key()} {self._plan.runs}"

    @property
    def tolerance(self) -> tuple[float, float]:
        """Of the dock: [m], [deg]."""
        tolerance = self._plan.dock().tolerance
        return tolerance.position, math.degrees(tolerance.heading)

    def held_out(self, cases: int) -> Dockings:
        """Others of the same kind, that no search has seen."""
        other = object.__new__(Dockings)
        other._plan = replace(self._plan, seed=self._plan.seed + HELD_OUT, runs=cases)
        other._jobs = self._jobs
        return other

    def run(self, values: Mapping[str, float]) -> Measures:
        """All cases with these values in the place of those of controller.yaml."""
        tried = {"tuned": {"these": changes(values)}} if values else {}
        campaign = replace(self._plan.campaign, axes=self._plan.campaign.axes | tried)
        jobs = list(enumerate(replace(self._plan, campaign=campaign).jobs()))
        if self._jobs == 1:
            rows = {index: run_case(job) for index, job in jobs}
        else:
            rows = dict(over_processes(self._jobs, process_died)(run_case, jobs))
        ordered = [rows[index] for index, _ in jobs]
        refused = next((row["text"] for row in ordered if row.get("result") == "REFUSED"), None)
        if refused is not None:
            raise ParameterError(refused)
        return measure(ordered)


def _files(shipped: Files, own: ChairFiles) -> Files:
    contents = dict(shipped.contents)
    contents["chair.yaml"], contents["controller.yaml"] = read_yaml(own.chair), read_yaml(own.controller)
    contents["docks/default.yaml"] = read_yaml(own.dock)
    if own.camera is not None:
        contents["cameras/d455.yaml"] = read_yaml(own.camera)
    return Files(contents)


def _as_identified(controller: Any) -> dict[str, Any]:
    """A variant whose plant has nearly what was identified, and what cannot be identified as drawn before."""
    told = controller["control"]["prediction"]
    turning = told["motor_lag_turning"] or told["motor_lag"]
    command = {"delay": told["command_delay"]} | {
        key: told[key] for key in ("gain_v", "gain_omega", "deadband_v", "deadband_omega")
    }
    motor = {"lag_v": told["motor_lag"], "lag_omega": turning}
    parts = {
        part: {key: {"between": [(1.0 - NEARLY) * v, (1.0 + NEARLY) * v]} for key, v in values.items()}
        for part, values in (("command", command), ("motor", motor))
    }
    return {"simulator": {"plant": {"wheelchair": parts}}}
