"""Every parameter of controller, observer and sequence: meaning, unit, range, default (config/controller.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_nmpc.parameters.control import (
    ControlParameters,
    Fallback,
    FatropParameters,
    IpoptParameters,
    PaperWeights,
    Prediction,
    RtiParameters,
    Weights,
    weight_set,
)
from seater_nmpc.parameters.observer import (
    ObserverParameters,
)
from seater_nmpc.parameters.planner import (
    PlannerParameters,
)
from seater_nmpc.parameters.plausibility import (
    PlausibilityParameters,
)
from seater_nmpc.parameters.sequence import (
    SequenceParameters,
    Timeouts,
)

__all__ = [
    "ControlParameters",
    "Fallback",
    "FatropParameters",
    "IpoptParameters",
    "NmpcParameters",
    "ObserverParameters",
    "PaperWeights",
    "PlannerParameters",
    "PlausibilityParameters",
    "Prediction",
    "RtiParameters",
    "SequenceParameters",
    "Timeouts",
    "Weights",
    "weight_set",
]


@dataclass(frozen=True)
class NmpcParameters:
    """config/controller.yaml as a whole."""

    control: ControlParameters = field(default_factory=ControlParameters)
    planner: PlannerParameters = field(default_factory=PlannerParameters)
    observer: ObserverParameters = field(default_factory=ObserverParameters)
    sequence: SequenceParameters = field(default_factory=SequenceParameters)
    plausibility: PlausibilityParameters = field(default_factory=PlausibilityParameters)
