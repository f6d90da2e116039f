"""Parameters of the model predictive controller (`control:` in config/controller.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param


@dataclass(frozen=True)
class Weights:
    """Cost of the formulation `docking` (docs/explanation/controller.md). Stage terms count per second."""

    x: float = param(1.0, "1/m^2", "stage: along the target", low=0.0)
    y: float = param(15.0, "1/m^2", "stage: across the target", low=0.0)
    heading: float = param(0.3, "1/rad^2", "stage: heading", low=0.0)
    speed: float = param(0.1, "s^2/m^2, s^2/rad^2", "stage: v^2 + omega^2", low=0.0)
    reverse: float = param(0.5, "s^2/m^2", "stage: extra on backward speed squared", low=0.0)
    acceleration: float = param(0.05, "s^4/m^2, s^4/rad^2", "stage: acceleration squared", low=0.0)
    terminal: float = param(1.0, "1/m", "exact terminal penalty wN (|x| + |y| + 0.5 |heading|)", low=0.0)
    terminal_heading: float = param(0.5, "m/rad", "weight of the heading in the terminal penalty", low=0.0)
    view: float = param(30.0, "1/m", "penalty weight of the markers out of view, linear and squared", low=0.0)
    violation: float = param(
        500.0, "1/m", "penalty weight of a violated area or bay speed, linear and squared", low=1.0
    )


def weight_set(name: str) -> Weights:
    """`calm`: the defaults, quiet under noisy poses; `fast`: quicker and exact, several times louder under noise.

    With a perfect state `fast` is most exact with `fine_steps` about half of the horizon: the plan's first steps are
    then what the chair drives.
    """
    sets = {"calm": Weights(), "fast": Weights(speed=0.01, acceleration=0.001, reverse=0.0, terminal=10.0)}
    if name not in sets:
        raise ValueError(f"weight set: is {name!r}, must be one of {', '.join(sets)}")
    return sets[name]


@dataclass(frozen=True)
class PaperWeights:
    """Cost of the formulation `paper`: F1 = |p - p_doc|^2, F2 = pi - ||phi - phi_doc| - pi|."""

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

    iterations: int = param(1, "", "quadratic programmes per control cycle, as far as time allows", low=1, high=100)
    max_iterations: int = param(3, "", "the same at most, while a constraint is violated", low=1, high=100)
    feasibility: float = param(
        1e-3, "m, rad, m/s, rad/s", "another one is solved while a constraint is violated by more", low=1e-9, high=0.1
    )
    tolerance: float = param(1e-8, "", "tolerance of the quadratic programmes", low=1e-12, high=1e-2)
    proximal: float = param(0.1, "1/rad^2", "weight that keeps the angles of the separating lines calm", low=1e-8)


@dataclass(frozen=True)
class Prediction:
    """What the motors make of a command, and when. The defaults are those of a typical powered wheelchair."""

    command_delay: float = param(0.15, "s", "from sending a command to its effect", low=0.0, high=1.0)
    solve_latency: float = param(0.0, "s", "assumed time from odometry to the command being sent", low=0.0, high=0.5)
    motor_lag: float = param(0.2, "s", "first-order time constant of the motors", low=0.0, high=1.0)
    motor_lag_turning: float = param(0.0, "s", "the same for turning (0: as motor_lag)", low=0.0, high=1.0)
    gain_v: float = param(1.0, "", "steady speed per commanded speed", low=0.3, high=3.0)
    gain_omega: float = param(1.0, "", "the same for turning", low=0.3, high=3.0)
    deadband_v: float = param(0.0, "m/s", "commands up to this do not move the chair", low=0.0, high=0.2)
    deadband_omega: float = param(0.0, "rad/s", "the same for turning", low=0.0, high=0.4)
    adapt: bool = param(True, "", "learn gains, deadbands, delay, lags and curvature from how the chair responds")


@dataclass(frozen=True)
class Fallback:
    """What is done without a usable solution."""

    max_plan_age: float = param(0.3, "s", "how long the chair may follow the last plan", low=0.0, high=2.0)
    feasibility: float = param(
        1e-3,
        "m, rad, m/s, rad/s",
        "violation up to which an unconverged iterate counts as a plan",
        low=0.0,
        high=0.1,
    )
    max_consecutive: int = param(10, "", "cycles in a row without a solution that end the docking", low=1)


@dataclass(frozen=True)
class ControlParameters:
    """The model predictive controller."""

    formulation: str = param("docking", "", "optimal control problem", choices=("docking", "paper"))
    solver: str = param("rti", "", "solver", choices=("ipopt", "ipopt_default", "fatrop", "rti"))
    max_wall_time: float = param(
        0.045, "s", "wall time after which a solve is stopped; not used in lock-step", low=0.001, high=100.0
    )
    max_wall_time_cold: float = param(
        1.0, "s", "the same for each first solve of a goal (one or two), standing", low=0.001, high=100.0
    )
    integrator: str = param("arc", "", "prediction step; `paper` always takes euler", choices=("arc", "euler"))
    control_period: float = param(0.05, "s", "between two control cycles", low=0.01, high=0.5)
    horizon: int = param(30, "", "steps of the prediction (N)", low=5, high=200)
    step: float = param(0.1, "s", "length of a step (dt)", low=0.01, high=0.5)
    last_step: float = param(
        0.0,
        "s",
        "last step; lengths grow evenly towards it (0: all are `step`)",
        low=0.0,
        high=1.0,
    )
    fine_steps: int = param(0, "", "so many first steps are as long as the control period", low=0, high=200)
    walls: bool = param(True, "", "the bay's walls and speed limit are constraints (false: free space)")
    margin: float = param(0.05, "m", "distance that the footprint keeps from every wall", low=0.0, high=0.5)
    stop_margin: float = param(
        0.02, "m", "distance from an obstacle at which the chair must be able to stop", low=0.0, high=0.5
    )
    max_jerk: float = param(
        0.0,
        "m/s^3",
        "largest jerk (0: no limit); not with fatrop, not in `paper`",
        low=0.0,
        high=50.0,
    )
    max_angular_jerk: float = param(0.0, "rad/s^3", "the same for turning", low=0.0, high=100.0)
    max_obstacles: int = param(2, "", "nearest obstacles that each step of the plan keeps clear of", low=0, high=10)
    bay_deceleration: float = param(
        0.6, "", "fraction of a_max with which the speed falls to the bay's limit ahead of the bay", low=0.05, high=1.0
    )
    view_half_angle: float = param(
        0.0, "rad", "markers stay within this angle of the camera's axis (0: as far as it sees)", low=0.0, high=1.4
    )
    weights: Weights = field(default_factory=Weights)
    paper: PaperWeights = field(default_factory=PaperWeights)
    ipopt: IpoptParameters = field(default_factory=IpoptParameters)
    fatrop: FatropParameters = field(default_factory=FatropParameters)
    rti: RtiParameters = field(default_factory=RtiParameters)
    prediction: Prediction = field(default_factory=Prediction)
    fallback: Fallback = field(default_factory=Fallback)
