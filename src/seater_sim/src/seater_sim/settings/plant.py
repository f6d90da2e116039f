"""What moves: the kinds of plant, and the simple one."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param
from seater_sim.settings.wheelchair import WheelchairSettings

PLANTS = KINEMATIC, WHEELCHAIR = "kinematic", "wheelchair"


@dataclass(frozen=True)
class KinematicSettings:
    """The ideal chair: a unicycle behind ramp and lag; its acceleration limits are those of chair.yaml."""

    lag_v: float = param(0.10, "s", "time constant of the speed behind the ramped demand", low=0.0, high=2.0)
    lag_omega: float = param(0.10, "s", "time constant of the turning rate", low=0.0, high=2.0)
    command_delay: float = param(0.04, "s", "from a command's arrival to its effect", low=0.0, high=1.0)
    command_timeout: float = param(0.25, "s", "without a new command for so long, the demand goes to zero", low=0.01)


@dataclass(frozen=True)
class PlantSettings:
    """Which chair is driven: `kinematic` is the controller's own model, `wheelchair` a chair as it is."""

    kind: str = param(WHEELCHAIR, "", "of the two below, the one that is driven", choices=PLANTS)
    kinematic: KinematicSettings = field(default_factory=KinematicSettings)
    wheelchair: WheelchairSettings = field(default_factory=WheelchairSettings)

    @property
    def command_timeout(self) -> float:
        """Of the chair that is driven [s]."""
        return self.kinematic.command_timeout if self.kind == KINEMATIC else self.wheelchair.command.timeout
