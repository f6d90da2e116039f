"""Small campaigns for the tests."""

from pathlib import Path
from typing import Any

import yaml

from seater_eval.campaign.drive.job import CampaignJob
from seater_eval.campaign.setup.campaign_file import Campaign, campaign_from
from seater_eval.campaign.setup.cases import draw_case
from seater_eval.campaign.setup.configuration import Files

CONFIG = Path(__file__).resolve().parents[3] / "config"
FILES = Files.read(CONFIG)


def values(**axes: Any) -> dict[str, Any]:
    """The default campaign with other axes."""
    loaded = yaml.safe_load((CONFIG / "campaign" / "default.yaml").read_text())
    return {**loaded, "axes": axes or {"any": {"default": {}}}}


def campaign(**axes: Any) -> Campaign:
    return campaign_from(values(**axes), "test.yaml")


def job(made: Campaign, index: int = 0, seed: int = 1, told: str = "defaults") -> CampaignJob:
    return CampaignJob(FILES, made, told, draw_case(FILES, made, seed, index).seed, index)
