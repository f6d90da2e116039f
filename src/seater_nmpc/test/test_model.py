import math

import casadi as ca
import numpy as np
import pytest

from seater_common.se2 import arc_step
from seater_nmpc.ocp.model import SINC_RANGE, arc_pose_step, augmented_step, euler_pose_step, sinc


def evaluate(expression: ca.SX) -> np.ndarray:
    return ca.DM(ca.evalf(expression)).full().ravel()


def test_sinc_is_exact_to_machine_precision() -> None:
    a = ca.SX.sym("a")
    f = ca.Function("f", [a], [sinc(a), ca.jacobian(sinc(a), a)])
    for value in np.linspace(-SINC_RANGE, SINC_RANGE, 101):
        result, slope = (float(out) for out in f(value))
        assert result == pytest.approx(float(np.sinc(value / math.pi)), abs=3e-16)
        exact = 0.0 if value == 0.0 else (value * math.cos(value) - math.sin(value)) / value**2
        assert slope == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize(("v", "omega"), [(0.6, 0.8), (-0.3, -0.8), (0.5, 0.0), (0.0, 0.7), (0.4, 1e-9)])
def test_arc_step_is_the_closed_form(v: float, omega: float) -> None:
    pose = [0.3, -1.2, 0.7]
    assert evaluate(arc_pose_step(ca.SX(pose), v, omega, 0.1)) == pytest.approx(
        arc_step(pose, v, omega, 0.1), abs=1e-15
    )


def test_euler_step_is_the_papers() -> None:
    x, y, heading = evaluate(euler_pose_step(ca.SX([1.0, 2.0, math.pi / 6]), 0.5, 0.2, 0.1))
    assert (x, y) == pytest.approx((1.0 + 0.05 * math.sqrt(3) / 2, 2.025), abs=1e-15)
    assert heading == pytest.approx(math.pi / 6 + 0.02)


def test_augmented_step_integrates_acceleration() -> None:
    """Braking straight from 0.4 m/s with 0.5 m/s2 for 0.1 s: 0.0375 m, 0.35 m/s; and of second order on a curve."""
    result = evaluate(augmented_step(ca.SX([0, 0, 0, 0.4, 0.0]), ca.SX([-0.5, 0.0]), 0.1, "arc"))
    assert result == pytest.approx([0.0375, 0.0, 0.0, 0.35, 0.0], abs=1e-15)
    fine = np.array([0.0, 0.0, 0.0])
    for k in range(1000):
        time = (k + 0.5) * 1e-4
        fine = arc_step(fine, 0.4 - 0.5 * time, 0.2 + time, 1e-4)
    z, u = ca.SX([0, 0, 0, 0.4, 0.2]), ca.SX([-0.5, 1.0])
    once = evaluate(augmented_step(z, u, 0.1, "arc"))[:3]
    twice = evaluate(augmented_step(augmented_step(z, u, 0.05, "arc"), u, 0.05, "arc"))[:3]
    assert once == pytest.approx(fine, abs=1e-4)
    assert np.linalg.norm(twice - fine) < 0.3 * np.linalg.norm(once - fine)


def test_an_unknown_integrator_is_named() -> None:
    with pytest.raises(ValueError, match="rk4"):
        augmented_step(ca.SX.zeros(5), ca.SX.zeros(2), 0.1, "rk4")
