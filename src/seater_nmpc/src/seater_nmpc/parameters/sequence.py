"""Parameters of the docking sequence (`sequence:` in config/controller.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param

CHECKS = ("never", "on_the_way", "when_unknown", "always")


@dataclass(frozen=True)
class Timeouts:
    """How long a phase may take [message time]."""

    detect: float = param(10.0, "s", "waiting for the dock", low=0.1, high=600.0)
    search: float = param(90.0, "s", "turning and driving to where the dock can be seen", low=1.0, high=600.0)
    approach: float = param(70.0, "s", "approach", low=1.0, high=600.0)
    final: float = param(60.0, "s", "final straight", low=1.0, high=600.0)
    stopping: float = param(5.0, "s", "coming to rest", low=0.5, high=60.0)
    correcting: float = param(20.0, "s", "small moves on the spot", low=0.5, high=120.0)
    verify: float = param(5.0, "s", "verification", low=0.5, high=60.0)
    retry: float = param(40.0, "s", "backing out", low=1.0, high=600.0)
    dock: float = param(150.0, "s", "whole docking, when the goal does not say", low=1.0, high=3600.0)
    undock: float = param(40.0, "s", "whole undocking, when the goal does not say", low=1.0, high=3600.0)


@dataclass(frozen=True)
class SequenceParameters:
    """The docking sequence."""

    timeouts: Timeouts = field(default_factory=Timeouts)
    search_after: float = param(
        2.0,
        "s",
        "standing without the dock in view, before the chair looks for it where the goal says",
        low=0.0,
        high=60.0,
    )
    max_start_distance: float = param(6.0, "m", "largest distance of the dock at the start", low=0.5, high=50.0)
    max_retries: int = param(2, "", "times the chair backs out and tries again", low=0, high=20)
    failed_end: str = param(
        "stay",
        "",
        "where a chair that sees the dock and could not dock ends: where it is, or backed out to the predock point",
        choices=("stay", "predock"),
    )
    installation_check: str = param(
        "never",
        "",
        "turns in front of the bay that show where the camera sits; when_unknown: until dockings have shown it; "
        "on_the_way: so, where it need not back out for them",
        choices=CHECKS,
    )
    installation_doubt: float = param(
        0.012,
        "m",
        "final error, as far as seen and as far as unknown, beyond which the installation is not known",
        low=0.001,
        high=1.0,
    )
    installation_turns: int = param(4, "", "places at which it turns then, at most", low=1, high=10)
    installation_way: float = param(
        1.6, "m", "how far ahead of the predock point the farther place is; it may back out to there", low=0.3, high=5.0
    )
    retry_distance: float = param(
        1.0, "m", "how far it backs out then, if it stands nearly right (at most to predock_x)", low=0.1, high=5.0
    )
    back_out_speed: float = param(
        0.15, "m/s", "backing out of the bay or off from a place, where as a rule no sensor looks", low=0.02, high=1.0
    )
    back_out_wait: float = param(
        20.0, "s", "how long it waits there for something in the way, getting nowhere", low=0.0, high=600.0
    )
    pause_time: float = param(
        0.0,
        "s",
        "how long a goal that a person has stopped waits for `docking_resume`; 0: it ends at once",
        low=0.0,
        high=3600.0,
    )
    client_timeout: float = param(
        0.0, "s", "how long the node that gave the goal may be gone until it ends; 0: for ever", low=0.0, high=60.0
    )
    gate_distance: float = param(
        0.10, "m", "distance before the bay at which the corridor decides on a retry", low=0.0, high=2.0
    )
    corridor_half_width: float = param(0.08, "m", "corridor at the gate: largest lateral error", low=0.005, high=1.0)
    corridor_heading: float = param(0.15, "rad", "corridor at the gate: largest heading error", low=0.01, high=1.0)
    corridor_slope: float = param(0.2, "", "how fast the corridor widens ahead of the gate", low=0.0, high=2.0)
    corridor_heading_slope: float = param(
        0.5, "rad/m", "how fast the allowed heading error grows there", low=0.0, high=3.0
    )
    arrival_way: float = param(
        0.035, "m", "most that is driven near the dock while images and motors react", low=0.005, high=10.0
    )
    hold_position: float = param(
        0.003, "m", "error along the dock's axis up to which the standing chair stays", low=0.0001, high=0.1
    )
    hold_heading: float = param(0.009, "rad", "the same for the heading error", low=0.0001, high=0.2)
    release_position: float = param(
        0.008, "m", "distance beyond which small moves do not help any more", low=0.0002, high=0.2
    )
    release_heading: float = param(
        0.014, "rad", "heading error beyond which the chair does not stay", low=0.0002, high=0.4
    )
    max_moves: int = param(10, "", "small moves on the spot before the chair stays or tries again", low=0, high=20)
    move_measurements: int = param(3, "", "fresh measurements averaged before a small move", low=1, high=100)
    settle_time: float = param(
        1.5, "s", "time within the release zone that stops the chair as well", low=0.1, high=30.0
    )
    stall_time: float = param(4.0, "s", "standing for so long on the final straight starts a retry", low=0.5, high=60.0)
    standing_speed: float = param(
        0.003, "m/s, rad/s", "speed over `standing_time` below which the chair stands", low=0.0005, high=0.1
    )
    standing_time: float = param(0.3, "s", "how long it must stand before verification", low=0.0, high=5.0)
    verify_measurements: int = param(10, "", "fresh measurements averaged for verification", low=1, high=1000)
    max_blind_distance: float = param(0.3, "m", "distance driven by odometry alone before stopping", low=0.01, high=3.0)
    max_blind_time: float = param(3.0, "s", "time driven by odometry alone before stopping", low=0.1, high=60.0)
    max_blind_wait: float = param(
        6.0, "s", "time that the chair then stands and waits to see the dock again", low=0.0, high=120.0
    )
    odometry_timeout: float = param(0.3, "s", "age of the odometry at which it counts as lost", low=0.02, high=5.0)
    obstacle_timeout: float = param(
        0.0, "s", "a message on `obstacles` that is older stops the chair; 0: none does", low=0.0, high=3600.0
    )
    obstacle_wait: float = param(
        10.0, "s", "how long it stands while it is not known what is in the way", low=0.0, high=600.0
    )
    predock_position: float = param(
        0.08, "m", "distance at which the predock point counts as reached", low=0.005, high=0.5
    )
    predock_heading: float = param(0.10, "rad", "the same for the heading error", low=0.005, high=0.5)
    charge_watch: float = param(
        0.0,
        "s",
        "how long a docked chair's goal goes on and docks again when the contact opens; 0: it ends at once",
        low=0.0,
        high=60.0,
    )
    contact_wait: float = param(1.0, "s", "waiting for the contact before nudging, and after it", low=0.0, high=30.0)
    nudge_distance: float = param(0.015, "m", "farthest nudge forward for the contact", low=0.0, high=0.1)
    nudge_speed: float = param(0.02, "m/s", "speed of the nudge", low=0.001, high=0.1)
