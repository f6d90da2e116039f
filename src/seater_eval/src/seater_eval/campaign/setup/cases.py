"""The cases of a campaign: one variant of each axis, the numbers left open, all drawn from the case's own seed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from seater_common.params import as_mapping
from seater_eval.campaign.setup.campaign_file import Campaign
from seater_eval.campaign.setup.changes import drawn
from seater_eval.campaign.setup.configuration import Configuration, Files, configuration
from seater_eval.campaign.setup.plants import drawn_plant, with_plant
from seater_eval.run.parallel import job_seed

# What is drawn from a case's seed has a stream of its own, so that a longer list here changes nothing there.
STREAM_VARIANTS, STREAM_NUMBERS, STREAM_START = 11, 12, 13


@dataclass(frozen=True)
class Case:
    """What is to be docked with what. The pose at the start follows from the seed, once there is a camera."""

    index: int
    seed: int
    variants: dict[str, str]  # axis -> variant, and choices that a plant leaves
    changes: list[dict[str, Any]]  # one for each axis, without anything left open
    numbers: dict[str, float]  # what was drawn, by its full key

    def configuration(self, files: Files, campaign: Campaign) -> Configuration:
        """Raises ParameterError, naming every key that is wrong for this combination."""
        return configuration(files, as_mapping(campaign.settings.start), self.changes)


def draw_case(files: Files, campaign: Campaign, seed: int, index: int) -> Case:
    """Case `index` of the campaign with this seed, whatever the number of cases. Raises ParameterError."""
    return case_of_seed(files, campaign, job_seed(seed, index), index)


def case_of_seed(files: Files, campaign: Campaign, seed: int, index: int) -> Case:
    """The case that follows from its own seed."""
    chooser, numbers = (np.random.default_rng([seed, stream]) for stream in (STREAM_VARIANTS, STREAM_NUMBERS))
    variants: dict[str, str] = {}
    changes: list[dict[str, Any]] = []
    found: dict[str, float] = {}
    for axis, choices in campaign.axes.items():
        variants[axis] = list(choices)[int(chooser.integers(len(choices)))]
        own = np.random.default_rng(numbers.integers(2**32, size=4))  # as many draws from `numbers` for every variant
        fixed, values = drawn(choices[variants[axis]], own, "")
        values = {key.lstrip("/"): value for key, value in values.items()}
        if "plant" in fixed:
            simulator, varied = drawn_plant(files, str(fixed["plant"]), own)
            fixed = with_plant(fixed, simulator)
            variants |= {key: value for key, value in varied.items() if isinstance(value, str)}
            values |= {key: float(value) for key, value in varied.items() if not isinstance(value, str)}
        changes.append(fixed)
        found |= values
    return Case(index, seed, variants, changes, found)
