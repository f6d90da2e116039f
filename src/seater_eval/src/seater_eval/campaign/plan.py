"""Which cases are to be run: a whole campaign or one shard of it."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from seater_common.geometry import Dock
from seater_common.params import ParameterError, load
from seater_eval.campaign.drive.job import CampaignJob
from seater_eval.campaign.setup.campaign_file import Campaign, load_campaign, only
from seater_eval.campaign.setup.cases import draw_case
from seater_eval.campaign.setup.configuration import Files
from seater_eval.campaign.setup.plants import check_plant
from seater_eval.campaign.setup.told import check_told
from seater_eval.run.parallel import job_seed
from seater_eval.run.partial import fingerprint


@dataclass(frozen=True)
class Shard:
    """Part `number` of `of`: the cases whose index leaves number - 1 when it is divided by `of`."""

    number: int = 1
    of: int = 1

    @classmethod
    def parse(cls, text: str) -> Shard:
        """Of "2/8". Raises ParameterError."""
        match = re.fullmatch(r"(\d+)/(\d+)", text)
        shard = cls(int(match[1]), int(match[2])) if match else cls(0, 0)
        if not 1 <= shard.number <= shard.of:
            raise ParameterError(f"--shard: is {text!r}, must be I/N with 1 <= I <= N")
        return shard

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"


@dataclass(frozen=True)
class Plan:
    """A campaign with everything that its results depend on."""

    name: str  # as it was asked for: a name in config/campaign, or a file
    campaign: Campaign
    files: Files
    told: str
    seed: int
    runs: int  # of the whole campaign
    shard: Shard
    axes: list[str]  # that are varied; empty: all
    bound: bool = False  # the shortest possible times are computed, too
    images: bool = True  # False: poses are drawn instead

    @classmethod
    def make(
        cls, config: Path, name: str, told: str, seed: int, runs: int, shard: Shard, axes: Sequence[str] = ()
    ) -> Plan:
        """`axes`: only these are varied, the others stay at their first variant; empty: all.

        Raises ParameterError: no such campaign or axis, wrong keys in it or in one of its variants.
        """
        check_told(told)
        path = Path(name) if name.endswith(".yaml") else config / "campaign" / f"{name}.yaml"
        campaign = load_campaign(path)
        if axes:
            campaign = only(campaign, axes)
        plan = cls(name, campaign, Files.read(config), told, seed, runs, shard, list(axes))
        plan.check(config)
        return plan

    def check(self, config: Path) -> None:
        """That every variant fits the configuration files, before the first run. Raises ParameterError."""
        for axis, variants in self.campaign.axes.items():
            for name in variants:
                alone = Campaign(self.campaign.settings, {axis: {name: variants[name]}})
                try:
                    if "plant" in variants[name]:
                        check_plant(config, str(variants[name]["plant"]))
                    draw_case(self.files, alone, self.seed, 0).configuration(self.files, alone)
                except ParameterError as error:
                    raise ParameterError(f"axes/{axis}/{name}: {error}") from error

    def jobs(self) -> list[CampaignJob]:
        """Of this shard, in the order of their index."""
        return [self.job(index) for index in range(self.shard.number - 1, self.runs, self.shard.of)]

    def job(self, index: int) -> CampaignJob:
        """Case `index`, whatever the shard."""
        return self.job_of_seed(job_seed(self.seed, index), index)

    def job_of_seed(self, seed: int, index: int = -1) -> CampaignJob:
        """The case that follows from its own seed."""
        return CampaignJob(self.files, self.campaign, self.told, seed, index, self.bound, self.images)

    def dock(self) -> Dock:
        """The default one, for figures of many runs."""
        return load(Dock, self.files.get("docks/default.yaml", "dock"), "dock")

    def key(self, files: Iterable[Path] = ()) -> str:
        """Equal for shards of one campaign: same code, configuration, seed. `files`: what else has to be equal."""
        inputs = [asdict(self.files), asdict(self.campaign), self.told, self.seed, self.bound, self.images]
        text = json.dumps(inputs, sort_keys=True, default=str)
        return hashlib.sha256((text + fingerprint(None, files)).encode()).hexdigest()
