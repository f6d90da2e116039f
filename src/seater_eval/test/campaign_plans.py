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


# In front of the bay: every phase of a docking in few images.
NEAR = {"x": [-1.4, -1.1], "y": [-0.2, 0.2], "heading": [-8.0, 8.0]}

# Images are most of a run's computing time: an axis for what does not depend on their number.
RATE = 10.0  # [Hz]
FEW_IMAGES = {"few": {"simulator": {"camera": {"rate": RATE}}}}


def load(name: str) -> dict[str, Any]:
    """A campaign of config/campaign that starts near."""
    loaded = yaml.safe_load((CONFIG / "campaign" / f"{name}.yaml").read_text())
    return {**loaded, "start": {**loaded["start"], **NEAR}}


def values(**axes: Any) -> dict[str, Any]:
    """The default campaign, near and with other axes."""
    return {**load("default"), "axes": axes or {"any": {"default": {}}}}


def campaign(**axes: Any) -> Campaign:
    return campaign_from(values(**axes), "test.yaml")


def job(made: Campaign, index: int = 0, seed: int = 1, told: str = "defaults") -> CampaignJob:
    return CampaignJob(FILES, made, told, draw_case(FILES, made, seed, index).seed, index)
