"""The chair as a unicycle, in CasADi: the paper's Euler step and an exact arc step.

Units: m, rad, s. A pose is (x, y, theta) of base_link in the frame of the problem (the target's). The augmented state
is z = (x, y, theta, v, omega), where v and omega are the speeds that the chair was last asked for, and the input is
u = (dv/dt, domega/dt), so that acceleration limits are plain bounds on u.
"""

from __future__ import annotations

import math

import casadi as ca

STATE_SIZE = 5
INPUT_SIZE = 2

# sin(a)/a = sum (-1)^n a^(2n) / (2n+1)!; ten terms leave 1e-17 at |a| = 1 and 3e-14 at |a| = pi/2.
_SINC_COEFFICIENTS = [(-1.0) ** n / math.factorial(2 * n + 1) for n in range(10)]
SINC_RANGE = 1.0  # [rad] half the turn of one step up to which the series is exact to machine precision


def sinc(a: ca.SX) -> ca.SX:
    """sin(a)/a, smooth at a = 0, exact to machine precision for |a| <= SINC_RANGE (power series, Horner's scheme)."""
    square = a * a
    result = ca.SX(_SINC_COEFFICIENTS[-1])
    for coefficient in reversed(_SINC_COEFFICIENTS[:-1]):
        result = result * square + coefficient
    return result


def euler_pose_step(pose: ca.SX, v: ca.SX, omega: ca.SX, step: float) -> ca.SX:
    """The paper's model (design, section 5): x_{k+1} = x_k + dt [v cos phi, v sin phi, omega]; shape (3,)."""
    return pose + step * ca.vertcat(v * ca.cos(pose[2]), v * ca.sin(pose[2]), omega)


def arc_pose_step(pose: ca.SX, v: ca.SX, omega: ca.SX, step: float) -> ca.SX:
    """Exact pose after constant v and omega: the chord of a circle; shape (3,)."""
    half = 0.5 * step * omega
    chord = step * v * sinc(half)
    direction = pose[2] + half
    return pose + ca.vertcat(chord * ca.cos(direction), chord * ca.sin(direction), 2.0 * half)


def augmented_step(z: ca.SX, u: ca.SX, step: float, integrator: str) -> ca.SX:
    """Next augmented state, shape (5,), under constant accelerations u.

    `arc` drives the arc of the mean speeds of the step, which is exact for constant speeds and of second order for
    changing ones; `euler` is the paper's step with the speeds at its beginning.
    """
    speeds = z[3:] + step * u
    if integrator == "euler":
        pose = euler_pose_step(z[:3], z[3], z[4], step)
    elif integrator == "arc":
        mean = z[3:] + 0.5 * step * u
        pose = arc_pose_step(z[:3], mean[0], mean[1], step)
    else:
        raise ValueError(f"integrator: is {integrator!r}, must be one of arc, euler")
    return ca.vertcat(pose, speeds)


def step_curvature(z: ca.SX, u: ca.SX, force: ca.SX, step: float, integrator: str) -> ca.SX:
    """Convex part of the second derivative of force . (x, y) of the next state with respect to (z, u), shape (7, 7).

    The next position is that of a chord of length h v in the direction phi (speeds and direction: linear in z and u, by
    integrator). Of the 2 x 2 second derivative in (phi, v) the negative eigenvalue is left out; how the chord shortens
    with the turning rate is neglected.
    """
    half = 0.0 if integrator == "euler" else 0.5 * step
    J = ca.DM(2, STATE_SIZE + INPUT_SIZE)
    J[0, 2], J[0, 4], J[0, 6] = 1.0, half, half**2
    J[1, 3], J[1, 5] = 1.0, half
    phi, v = ca.vertsplit(J @ ca.vertcat(z, u))
    a = -step * v * (force[0] * ca.cos(phi) + force[1] * ca.sin(phi))
    b = step * (force[1] * ca.cos(phi) - force[0] * ca.sin(phi))
    middle, radius = 0.5 * a, ca.sqrt(0.25 * a**2 + b**2 + 1e-16)
    high, low = ca.fmax(0.0, middle + radius), ca.fmax(0.0, middle - radius)
    ratio = 0.5 * (high - low) / radius
    mean = 0.5 * (high + low)
    convex = ca.vertcat(
        ca.horzcat(mean + ratio * (a - middle), ratio * b), ca.horzcat(ratio * b, mean - ratio * middle)
    )
    return ca.sparsify(J).T @ convex @ ca.sparsify(J)
