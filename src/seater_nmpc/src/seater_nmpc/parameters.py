"""Every parameter of controller, observer and docking sequence: meaning, unit, range, default (config/controller.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param


@dataclass(frozen=True)
class Weights:
    """Cost of the formulation `docking`, in the target's frame (docs/controller.md). Stage terms count per second."""

    x: float = param(1.0, "1/m^2", "stage: along the target", low=0.0)
    y: float = param(10.0, "1/m^2", "stage: across the target", low=0.0)
    heading: float = param(0.1, "1/rad^2", "stage: heading", low=0.0)
    speed: float = param(0.1, "s^2/m^2, s^2/rad^2", "stage: v^2 + omega^2", low=0.0)
    reverse: float = param(0.5, "s^2/m^2", "stage: extra on backward speed squared", low=0.0)
    acceleration: float = param(0.05, "s^4/m^2, s^4/rad^2", "stage: acceleration squared", low=0.0)
    terminal: float = param(1.0, "1/m", "exact terminal penalty wN (|x| + |y| + 0.5 |heading|)", low=0.0)
    terminal_heading: float = param(0.5, "m/rad", "share of the heading in the terminal penalty", low=0.0)
    view: float = param(30.0, "1/m", "price of the markers out of view, linear and squared", low=0.0)
    violation: float = param(500.0, "1/m", "price of a violated area or bay speed, linear and squared", low=1.0)


def weight_set(name: str) -> Weights:
    """`calm`: the defaults, quiet under noisy poses; `fast`: quicker and exact, several times louder under noise.

    With a perfect state `fast` is most exact with `fine_steps` about half of the horizon: the plan's first steps are then
    what the chair drives.
    """
    sets = {"calm": Weights(), "fast": Weights(speed=0.01, acceleration=0.001, reverse=0.0, terminal=10.0)}
    if name not in sets:
        raise ValueError(f"weight set: is {name!r}, must be one of {', '.join(sets)}")
    return sets[name]


@dataclass(frozen=True)
class PaperWeights:
    """Cost of the formulation `paper`: F1 = |p - p_doc|^2, F2 = pi - ||phi - phi_doc| - pi| (design, section 5)."""

    Q_position: float = param(1.0, "1/m^2", "stage weight of F1", low=0.0)
    Q_heading: float = param(0.1, "1/rad", "stage weight of F2", low=0.0)
    R_v: float = param(0.1, "s^2/m^2", "stage weight of v^2", low=0.0)
    R_omega: float = param(0.1, "s^2/rad^2", "stage weight of omega^2", low=0.0)
    P_position: float = param(10.0, "1/m^2", "terminal weight of F1", low=0.0)
    P_heading: float = param(1.0, "1/rad", "terminal weight of F2", low=0.0)


@dataclass(frozen=True)
class IpoptParameters:
    """Settings of the solver `ipopt`."""

    tolerance: float = param(1e-6, "", "relative tolerance of convergence", low=1e-10, high=1e-2)
    warm_barrier: float = param(1e-5, "", "barrier parameter mu that a warm start begins with", low=1e-11, high=1.0)
    max_iterations: int = param(100, "", "iterations after which a solve is stopped", low=1, high=10000)


@dataclass(frozen=True)
class FatropParameters:
    """Settings of the solver `fatrop`."""

    tolerance: float = param(1e-4, "", "tolerance of convergence", low=1e-10, high=1e-2)
    barrier: float = param(1e-2, "", "barrier parameter mu that a solve begins with", low=1e-11, high=1e3)
    max_iterations: int = param(60, "", "iterations after which a solve is stopped", low=1, high=10000)


@dataclass(frozen=True)
class RtiParameters:
    """Settings of the solver `rti`."""

    iterations: int = param(
        1, "", "quadratic programmes in every control cycle, as far as time allows", low=1, high=100
    )
    max_iterations: int = param(3, "", "the same at most, while a constraint is open", low=1, high=100)
    feasibility: float = param(
        1e-3, "m, rad, m/s, rad/s", "another one is solved while a constraint is open by more", low=1e-9, high=0.1
    )
    tolerance: float = param(1e-8, "", "tolerance of the quadratic programmes", low=1e-12, high=1e-2)
    proximal: float = param(0.1, "1/rad^2", "weight that keeps the angles of the parting lines calm", low=1e-8)


@dataclass(frozen=True)
class Prediction:
    """What happens between a measurement and the time when the command computed from it acts."""

    command_delay: float = param(0.0, "s", "from sending a command to the motors acting on it", low=0.0, high=1.0)
    solve_latency: float = param(0.0, "s", "assumed time from odometry to the command being sent", low=0.0, high=0.5)
    motor_lag: float = param(0.0, "s", "time constant of the motors, first order", low=0.0, high=1.0)


@dataclass(frozen=True)
class Fallback:
    """What is done without a usable solution."""

    max_plan_age: float = param(0.3, "s", "how long the last plan may be followed further", low=0.0, high=2.0)
    feasibility: float = param(
        1e-3, "m, rad, m/s, rad/s", "gap up to which an unconverged iterate counts as a plan", low=0.0, high=0.1
    )
    max_consecutive: int = param(10, "", "cycles in a row without a solution after which docking fails", low=1)


@dataclass(frozen=True)
class ControlParameters:
    """The model predictive controller."""

    formulation: str = param("docking", "", "optimal control problem", choices=("docking", "paper"))
    solver: str = param("rti", "", "solver", choices=("ipopt", "ipopt_default", "fatrop", "rti"))
    max_wall_time: float = param(
        0.045, "s", "wall time after which a solve is stopped; not used in lock-step", low=0.001, high=100.0
    )
    max_wall_time_cold: float = param(
        1.0, "s", "the same for the first solve of a goal, made while standing", low=0.001, high=100.0
    )
    integrator: str = param("arc", "", "prediction step; `paper` always takes euler", choices=("arc", "euler"))
    control_period: float = param(0.05, "s", "between two control cycles", low=0.01, high=0.5)
    horizon: int = param(30, "", "steps of the prediction (N)", low=5, high=200)
    step: float = param(0.1, "s", "length of a step (dt)", low=0.01, high=0.5)
    last_step: float = param(
        0.0,
        "s",
        "length of the last step, the lengths growing evenly towards it (0: all are `step`)",
        low=0.0,
        high=1.0,
    )
    fine_steps: int = param(0, "", "the first so many steps are as long as the control period", low=0, high=200)
    walls: bool = param(True, "", "whether the bay's walls and speed limit are constraints (false: free space)")
    margin: float = param(0.05, "m", "distance that the footprint keeps from every wall", low=0.0, high=0.5)
    stop_margin: float = param(
        0.02, "m", "the chair brakes when it could not stop this far from an obstacle", low=0.0, high=0.5
    )
    max_jerk: float = param(
        0.0,
        "m/s^3",
        "largest change of acceleration (0: no limit); not with fatrop, not in `paper`",
        low=0.0,
        high=50.0,
    )
    max_angular_jerk: float = param(0.0, "rad/s^3", "the same for turning", low=0.0, high=100.0)
    max_obstacles: int = param(
        2, "", "obstacles at run time that each step of the plan keeps clear of, the nearest ones", low=0, high=10
    )
    bay_deceleration: float = param(
        0.6, "", "share of a_max with which the speed falls to the bay's limit ahead of the bay", low=0.05, high=1.0
    )
    view_half_angle: float = param(
        0.60, "rad", "half of the horizontal field of view in which the markers' middle is kept", low=0.1, high=1.4
    )
    weights: Weights = field(default_factory=Weights)
    paper: PaperWeights = field(default_factory=PaperWeights)
    ipopt: IpoptParameters = field(default_factory=IpoptParameters)
    fatrop: FatropParameters = field(default_factory=FatropParameters)
    rti: RtiParameters = field(default_factory=RtiParameters)
    prediction: Prediction = field(default_factory=Prediction)
    fallback: Fallback = field(default_factory=Fallback)


@dataclass(frozen=True)
class ObserverParameters:
    """The state observer: the dock in odom."""

    buffer_duration: float = param(2.0, "s", "how far back odometry and measurements are kept", low=0.2, high=20.0)
    max_extrapolation: float = param(0.1, "s", "how far ahead of the newest odometry a stamp may be", low=0.0, high=0.5)
    acquire_count: int = param(5, "", "consistent measurements that make the first estimate", low=1, high=100)
    acquire_speed: float = param(
        0.02, "m/s, rad/s", "speed below which the chair counts as standing", low=0.001, high=1.0
    )
    reacquire_count: int = param(
        8, "", "rejected measurements in a row, consistent among themselves, that replace the estimate", low=2, high=100
    )
    gate: float = param(16.3, "", "chi-square gate, 3 degrees of freedom (16.3: 99.9 %)", low=1.0, high=1000.0)
    acquire_odds: float = param(
        20.0, "", "odds for one of several poses that images leave open, before it is believed", low=1.0, high=1e6
    )
    calibration_position: float = param(
        0.001, "m", "what calibration leaves, the same in every image, standard deviation", low=0.0, high=0.1
    )
    calibration_heading: float = param(0.002, "rad", "the same for the heading", low=0.0, high=0.2)
    scale_sd: float = param(
        0.01, "", "constant relative error of the odometry's distances, standard deviation", low=0.0, high=0.2
    )
    heading_scale_sd: float = param(0.01, "", "the same for turns", low=0.0, high=0.2)
    heading_drift_sd: float = param(0.005, "rad/m", "constant turn per metre driven, the same", low=0.0, high=0.2)
    distance_noise: float = param(
        0.002, "m/sqrt(m)", "random error of distances, standard deviation after 1 m", low=0.0, high=1.0
    )
    heading_noise: float = param(0.002, "rad/sqrt(m)", "random turn after 1 m driven", low=0.0, high=1.0)
    turn_noise: float = param(0.004, "rad/sqrt(rad)", "random error of turns after 1 rad", low=0.0, high=1.0)
    speed_noise: float = param(0.02, "m/s", "odometry's speed, standard deviation of one message", low=1e-4, high=0.5)
    omega_noise: float = param(0.02, "rad/s", "the same for its turning rate", low=1e-4, high=1.0)
    speed_agility: float = param(
        0.15,
        "m/s^2",
        "how far the motors deviate from the lag that is assumed, standard deviation",
        low=0.001,
        high=5.0,
    )
    omega_agility: float = param(0.3, "rad/s^2", "the same for the turning rate", low=0.001, high=10.0)
    max_tilt: float = param(
        0.35,
        "rad",
        "angle between the dock's z axis and the vertical above which a hypothesis is a flip",
        low=0.01,
        high=1.6,
    )
    max_height: float = param(0.5, "m", "height of the dock's origin above the floor above which it is one", low=0.01)


@dataclass(frozen=True)
class PlannerParameters:
    """The search for a way to the bay (seater_nmpc.plan.planner)."""

    cell: float = param(0.1, "m", "side of a cell of the lattice", low=0.05, high=0.3)
    reach: float = param(5.5, "m", "how far ahead of the dock the lattice begins", low=2.0, high=12.0)
    half_width: float = param(3.0, "m", "how far to both sides it goes", low=1.0, high=8.0)
    extra_margin: float = param(
        0.03, "m", "distance from walls and obstacles beside the controller's", low=0.0, high=0.3
    )
    blind_factor: float = param(10.0, "", "price of a second without the markers in view", low=1.0, high=1000.0)
    lane: float = param(1.5, "m", "how far ahead of the bay the way may join the dock's axis", low=0.0, high=5.0)
    lookahead: float = param(
        1.5, "m", "how far along the way the point is that is driven to past obstacles", low=0.3, high=5.0
    )
    turn_length: float = param(0.4, "m/rad", "what a turn counts for along the way", low=0.05, high=2.0)
    reached_position: float = param(
        0.12, "m", "distance from a turning point at which it is reached", low=0.02, high=0.5
    )
    reached_heading: float = param(0.25, "rad", "the same for the heading", low=0.02, high=1.0)
    replan_distance: float = param(
        0.5, "m", "distance from the way beyond which a new one is searched", low=0.1, high=2.0
    )
    obstacle_shift: float = param(
        0.05, "m", "obstacles that moved by more count as moved: the way is checked anew", low=0.001, high=0.5
    )


@dataclass(frozen=True)
class Timeouts:
    """How long a phase may take [message time]."""

    detect: float = param(10.0, "s", "waiting for the dock", low=0.1, high=600.0)
    approach: float = param(40.0, "s", "approach", low=1.0, high=600.0)
    final: float = param(60.0, "s", "final straight", low=1.0, high=600.0)
    stopping: float = param(5.0, "s", "coming to rest", low=0.5, high=60.0)
    verify: float = param(5.0, "s", "verification", low=0.5, high=60.0)
    retry: float = param(40.0, "s", "backing out", low=1.0, high=600.0)
    dock: float = param(150.0, "s", "whole docking, when the goal does not say", low=1.0, high=3600.0)
    undock: float = param(40.0, "s", "whole undocking, when the goal does not say", low=1.0, high=3600.0)


@dataclass(frozen=True)
class SequenceParameters:
    """The docking sequence."""

    timeouts: Timeouts = field(default_factory=Timeouts)
    max_start_distance: float = param(6.0, "m", "dock farther than this at the start is not valid", low=0.5, high=50.0)
    max_retries: int = param(2, "", "times the chair backs out and tries again", low=0, high=20)
    gate_distance: float = param(
        0.10, "m", "how far before the bay the front is when the corridor decides on a retry", low=0.0, high=2.0
    )
    corridor_half_width: float = param(0.08, "m", "corridor at the gate: largest lateral error", low=0.005, high=1.0)
    corridor_heading: float = param(0.15, "rad", "corridor at the gate: largest heading error", low=0.01, high=1.0)
    corridor_slope: float = param(0.2, "", "how fast the corridor widens ahead of the gate", low=0.0, high=2.0)
    corridor_heading_slope: float = param(
        0.5, "rad/m", "how fast the allowed heading error grows there", low=0.0, high=3.0
    )
    hold_position: float = param(
        0.003, "m", "distance from the dock at which the chair is stopped", low=0.0001, high=0.1
    )
    hold_heading: float = param(0.005, "rad", "the same for the heading error", low=0.0001, high=0.2)
    release_position: float = param(
        0.008, "m", "distance beyond which the stopped chair drives on", low=0.0002, high=0.2
    )
    release_heading: float = param(0.014, "rad", "the same for the heading error", low=0.0002, high=0.4)
    settle_time: float = param(
        1.5, "s", "time within the release zone after which it is stopped as well", low=0.1, high=30.0
    )
    stall_time: float = param(4.0, "s", "standing for so long on the final straight means a retry", low=0.5, high=60.0)
    standing_speed: float = param(
        0.01, "m/s, rad/s", "measured speed below which the chair stands", low=0.0005, high=0.1
    )
    standing_time: float = param(0.3, "s", "how long it must stand before verification", low=0.0, high=5.0)
    verify_measurements: int = param(10, "", "fresh measurements averaged for verification", low=1, high=1000)
    max_blind_distance: float = param(0.3, "m", "way driven by odometry alone before stopping", low=0.01, high=3.0)
    max_blind_time: float = param(3.0, "s", "time driven by odometry alone before stopping", low=0.1, high=60.0)
    odometry_timeout: float = param(0.3, "s", "age of the odometry at which it counts as lost", low=0.02, high=5.0)
    obstacle_timeout: float = param(
        0.0, "s", "how long a message with obstacles holds without a newer one; 0: for ever", low=0.0, high=3600.0
    )
    predock_position: float = param(
        0.08, "m", "distance at which the predock point counts as reached", low=0.005, high=0.5
    )
    predock_heading: float = param(0.10, "rad", "the same for the heading error", low=0.005, high=0.5)
    contact_wait: float = param(1.0, "s", "waiting for the contact before nudging, and after it", low=0.0, high=30.0)
    nudge_distance: float = param(0.015, "m", "farthest nudge forward for the contact", low=0.0, high=0.1)
    nudge_speed: float = param(0.02, "m/s", "speed of the nudge", low=0.001, high=0.1)


@dataclass(frozen=True)
class NmpcParameters:
    """config/controller.yaml as a whole."""

    control: ControlParameters = field(default_factory=ControlParameters)
    planner: PlannerParameters = field(default_factory=PlannerParameters)
    observer: ObserverParameters = field(default_factory=ObserverParameters)
    sequence: SequenceParameters = field(default_factory=SequenceParameters)
