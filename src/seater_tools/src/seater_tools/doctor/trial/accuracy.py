"""Faults against what the doctor says of them, and good installations against its alarms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from seater_tools.doctor.checks import run
from seater_tools.doctor.trial.faults import FAULTS, Fault
from seater_tools.doctor.trial.scene import draw_scene
from seater_tools.doctor.trial.watch import Watch
from seater_tools.doctor.verdict import Verdict


@dataclass(frozen=True)
class Outcome:
    """`crosses`: name and text of all that is wrong; `named`: rightly, or, of a good one, without a cross."""

    family: str
    name: str
    seed: int
    named: bool
    crosses: list[tuple[str, str]]


def fault_outcomes(config: Path, faults: Sequence[Fault], first_seed: int) -> Iterator[Outcome]:
    """One installation for each fault, each with a seed of its own."""
    for fault in faults:
        seed = first_seed + FAULTS.index(fault)
        crosses = [(v.name, v.what) for v in _crosses(config, seed, fault)]
        named = bool(crosses) and crosses[0][0] == fault.check and fault.word in crosses[0][1]
        yield Outcome(fault.family, fault.name, seed, named, crosses)


def good_outcomes(config: Path, count: int, first_seed: int) -> Iterator[Outcome]:
    """Good installations, with the drive."""
    for seed in range(first_seed, first_seed + count):
        crosses = [(v.name, v.what) for v in _crosses(config, seed, None)]
        yield Outcome("good", str(seed), seed, not crosses, crosses)


def _crosses(config: Path, seed: int, fault: Fault | None) -> list[Verdict]:
    scene = draw_scene(config, seed)
    scene.drive = fault is None or fault.drive
    if fault is not None:
        fault.edit(scene)
    return [verdict for verdict in run(Watch(scene).observe()) if verdict.ok is False]
