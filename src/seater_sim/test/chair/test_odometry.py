"""Odometry: its errors are those of its parameters, and its covariance says so."""

import dataclasses

import numpy as np
import pytest

from seater_common.se2 import arc_step, compose, relative, wrap_angle
from seater_sim.chair.interface import OdometrySample
from seater_sim.chair.odometry import Odometry
from seater_sim.settings import OdometrySettings, PlanarPose

PERIOD = 20_000_000
EXACT = OdometrySettings(0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, PlanarPose(3.0, -1.5, 0.6))
# An S-shaped way of 2.4 m with turns of 1 rad each way, some of it backwards.
PATH = [(0.030, 0.025)] * 40 + [(0.030, -0.025)] * 40 + [(-0.015, 0.010)] * 20


def drive(odometry: Odometry, path: list[tuple[float, float]] = PATH) -> OdometrySample:
    for k, (way, turn) in enumerate(path):
        sample = odometry.update(way, turn, PERIOD, k * PERIOD)
    return sample


def truth(origin: PlanarPose) -> np.ndarray:
    pose = origin.as_array()
    for way, turn in PATH:
        pose = arc_step(pose, way, turn, 1.0)
    return pose


def test_without_errors_it_is_the_true_motion_from_the_origin() -> None:
    sample = drive(Odometry(EXACT, 5))
    np.testing.assert_allclose(sample.pose, truth(EXACT.origin), atol=1e-12)
    assert (sample.v, sample.omega) == pytest.approx((-0.75, 0.5))


def test_origin_is_only_a_change_of_frame() -> None:
    one = drive(Odometry(OdometrySettings(), 5))
    other = drive(Odometry(dataclasses.replace(OdometrySettings(), origin=PlanarPose()), 5))
    np.testing.assert_allclose(one.pose, compose(OdometrySettings().origin.as_array(), other.pose), atol=1e-12)


def test_same_seed_same_errors() -> None:
    one, two, other = (drive(Odometry(OdometrySettings(), seed)) for seed in (7, 7, 8))
    assert one.pose.tolist() == two.pose.tolist()
    assert one.pose.tolist() != other.pose.tolist()


def test_a_standing_chair_does_not_drift() -> None:
    odometry = Odometry(OdometrySettings(), 3)
    before = drive(odometry)
    after = drive(odometry, [(0.0, 0.0)] * 500)
    assert after.pose.tolist() == before.pose.tolist()
    np.testing.assert_allclose(after.pose_covariance, before.pose_covariance, atol=1e-15)


def test_scale_errors_are_one_percent() -> None:
    scales = [Odometry(OdometrySettings(), seed).scale for seed in range(400)]
    assert np.std(scales) == pytest.approx(0.01, rel=0.15)  # 3.5 % is one standard deviation of this estimate


def test_covariance_is_that_of_many_runs() -> None:
    settings = OdometrySettings()
    runs = 400
    expected = truth(settings.origin)
    samples = [drive(Odometry(settings, seed)) for seed in range(runs)]
    errors = np.array([s.pose - expected for s in samples])
    errors[:, 2] = [wrap_angle(e) for e in errors[:, 2]]
    claimed = np.mean([s.pose_covariance for s in samples], axis=0)
    found = np.cov(errors.T)
    # The relative standard deviation of a variance from 400 runs is sqrt(2 / 400) = 7 %; four of them.
    assert np.diag(found) / np.diag(claimed) == pytest.approx(np.ones(3), abs=0.28)
    # Whitened by the claimed covariance the errors are white: correlations too are right.
    whitener = np.linalg.inv(np.linalg.cholesky(claimed))
    np.testing.assert_allclose(whitener @ found @ whitener.T, np.eye(3), atol=0.28)


def test_twist_covariance_is_that_of_many_runs() -> None:
    settings = OdometrySettings()
    samples = [Odometry(settings, seed).update(0.006, 0.008, PERIOD, 0) for seed in range(2000)]
    errors = np.array([(s.v - 0.3, s.omega - 0.4) for s in samples])
    claimed = np.mean([np.diag(s.twist_covariance) for s in samples], axis=0)
    assert errors.var(axis=0) / claimed == pytest.approx(np.ones(2), abs=0.13)  # four times sqrt(2 / 2000)


def test_covariances_are_regular_at_the_start() -> None:
    sample = Odometry(OdometrySettings(), 0).update(0.0, 0.0, PERIOD, 0)
    assert np.all(np.linalg.eigvalsh(sample.pose_covariance) > 0.0)
    assert np.all(np.linalg.eigvalsh(sample.twist_covariance) > 0.0)


def test_relative_motion_of_odometry_is_near_the_true_one() -> None:
    sample = drive(Odometry(OdometrySettings(), 11))
    origin = OdometrySettings().origin.as_array()
    difference = relative(relative(origin, truth(OdometrySettings().origin)), relative(origin, sample.pose))
    assert 1e-4 < np.hypot(difference[0], difference[1]) < 0.1
