"""Everything a person sets about joystick and emergency stop (config/joystick.yaml, config/emergency_stop.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param


@dataclass(frozen=True)
class AxisSettings:
    """One axis of the stick, in the raw numbers of the device; `negative` and `positive` may be either way round."""

    code: str = param("ABS_Y", "", "its name, as evtest says")
    negative: int = param(255, "", "at the end that drives back, or turns right", low=-(2**31), high=2**31 - 1)
    centre: int = param(128, "", "let go", low=-(2**31), high=2**31 - 1)
    positive: int = param(0, "", "at the other end", low=-(2**31), high=2**31 - 1)

    def __post_init__(self) -> None:
        if not min(self.negative, self.positive) < self.centre < max(self.negative, self.positive):
            raise ValueError(
                f"centre {self.centre} is not between negative {self.negative} and positive {self.positive}"
            )


@dataclass(frozen=True)
class JoystickSettings:
    """The whole of config/joystick.yaml."""

    device: str = param("", "", "/dev/input/by-id/...-event-joystick; empty: the first that has all of this")
    drive: AxisSettings = field(default_factory=AxisSettings)
    turn: AxisSettings = field(default_factory=lambda: AxisSettings(code="ABS_X"))
    dead_man: str = param("BTN_TRIGGER", "", "button without which the stick does nothing; empty: none")
    hold: str = param("BTN_THUMB", "", "button of hold-to-run, where the launch file asks for it")
    deadband: float = param(0.1, "", "share of the way from centre to end that is neutral", low=0.02, high=0.5)
    beyond: float = param(0.1, "", "share beyond an end that is taken for the end; more is a fault", low=0.0, high=0.5)
    silence: float = param(
        0.0, "s", "nothing heard for so long: let go; 0: it speaks of changes only", low=0.0, high=10.0
    )
    v_forward: float = param(0.4, "m/s", "at the end forward", low=0.03, high=3.0)
    v_backward: float = param(0.25, "m/s", "at the end back", low=0.03, high=3.0)
    omega: float = param(0.6, "rad/s", "at both ends of the turn", low=0.03, high=4.0)
    rate: int = param(20, "Hz", "messages per second", low=10, high=100)

    def __post_init__(self) -> None:
        names = [self.drive.code, self.turn.code, *filter(None, (self.dead_man, self.hold))]
        if len(set(names)) < len(names):
            raise ValueError(f"{', '.join(names)}: two of them are the same axis or button")


@dataclass(frozen=True)
class ContactSettings:
    """The whole of config/emergency_stop.yaml."""

    chip: str = param("gpiochip0", "", "as gpioinfo says")
    lines: tuple[int, ...] = param((17,), "", "one for each contact; one that is open stops", low=0, high=1000)
    closed: int = param(0, "", "what a closed contact reads: 0 to ground with pull-up, 1 to the supply", choices=(0, 1))
    release: float = param(0.1, "s", "closed for so long without a break: released", low=0.02, high=2.0)
    sampling: int = param(200, "Hz", "readings per second; open once is pressed", low=50, high=1000)
    rate: int = param(20, "Hz", "messages per second", low=10, high=100)

    def __post_init__(self) -> None:
        if not self.lines or len(set(self.lines)) < len(self.lines):
            raise ValueError("lines: name at least one, each once")
