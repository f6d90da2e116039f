"""The files that a campaign leaves: JSON, CSV, Parquet, page; and how shards of one campaign become one."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from seater_common.params import ParameterError
from seater_eval.campaign.plan import Plan
from seater_eval.campaign.report.summary import campaign_bars, summarize
from seater_eval.report.bars import Bar

COMMAND = "docking_campaign"


def campaign_data(plan: Plan, rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """What the JSON file holds beside the bars."""
    return {
        "name": plan.name,
        "told": plan.told,
        "images": plan.images,
        "seed": plan.seed,
        "runs": plan.runs,
        "shard": str(plan.shard),
        "key": plan.key(),
        "settings": asdict(plan.campaign.settings),
        "axes": plan.campaign.axes,
        "axes_varied": plan.axes,
        "summary": summarize(rows),
        "rows": list(rows),
    }


def bars_of(data: Mapping[str, Any]) -> list[Bar]:
    """Those of the campaign file."""
    return campaign_bars(data["summary"], data["settings"]["bars"])


def file_name(data: Mapping[str, Any]) -> str:
    """Without its ending; shards have names of their own, so that they can share a folder."""
    return COMMAND if data["shard"] == "1/1" else f"{COMMAND}_{data['shard'].replace('/', '_of_')}"


def merge(folders: Sequence[Path]) -> dict[str, Any]:
    """All shards that lie in the folders, as the data of one campaign.

    Raises:
        ParameterError: no shard, shards of different campaigns or code, cases twice or missing.
    """
    paths = [path for folder in folders for path in sorted(folder.glob(f"{COMMAND}_*_of_*.json"))]
    if not paths:
        raise ParameterError(f"merge: no {COMMAND}_I_of_N.json in {', '.join(map(str, folders))}")
    shards = [json.loads(path.read_text()) for path in paths]
    first = shards[0]
    for path, shard in zip(paths, shards, strict=True):
        different = [name for name in ("name", "told", "seed", "runs", "key") if shard[name] != first[name]]
        if different:
            raise ParameterError(f"merge: {path} is of another campaign than {paths[0]}: {', '.join(different)} differ")
    rows = sorted((row for shard in shards for row in shard["rows"]), key=lambda row: row["index"])
    _check_complete([row["index"] for row in rows], first["runs"])
    names = ("name", "told", "images", "seed", "runs", "key", "settings", "axes", "axes_varied")
    kept = {name: first[name] for name in names}
    return {**kept, "shard": "1/1", "summary": summarize(rows), "rows": rows}


def _check_complete(found: Sequence[int], runs: int) -> None:
    missing = sorted(set(range(runs)) - set(found))
    twice = sorted(index for index in set(found) if found.count(index) > 1)
    for word, indices in (("missing", missing), ("there twice", twice)):
        if indices:
            some = ", ".join(map(str, indices[:10])) + (", ..." if len(indices) > 10 else "")
            raise ParameterError(f"merge: {len(indices)} cases are {word}: {some}")
