import math

import numpy as np
import pytest
from conftest import NOISE, T_ODOM_DOCK, observation

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step, compose, inverse, wrap_angle
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.observe.measurement import Hypothesis, difference
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.buffer import OdometryBuffer
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ObserverParameters

CHAIR = Chair()
EXACT = (1e-4, 1e-4)


def standing(observer: DockObserver, pose, since: float, until: float) -> None:
    for stamp in np.arange(since, until + 1e-9, 0.01):
        observer.add_odometry(Odometry(round(stamp, 6), compose(T_ODOM_DOCK, pose), 0.0, 0.0))


def acquired(pose=(-2.0, 0.0, 0.0), parameters=None) -> DockObserver:
    observer = DockObserver(CHAIR.camera, parameters)
    standing(observer, pose, 0.0, 1.0)
    for k in range(5):
        observer.add_detections(0.5 + 0.1 * k, [observation(CHAIR, inverse(pose))])
    assert observer.estimate() is not None
    return observer


def drive(observer: DockObserver, pose, v, omega, since, seconds):
    """Odometry every 10 ms; returns stamps and true poses in the dock's frame."""
    track = {round(since, 6): np.array(pose)}
    for k in range(round(seconds * 100)):
        pose = arc_step(pose, v, omega, 0.01)
        stamp = round(since + 0.01 * (k + 1), 6)
        observer.add_odometry(Odometry(stamp, compose(T_ODOM_DOCK, pose), v, omega))
        track[stamp] = pose
    return track


def test_camera_to_dock_in_odom() -> None:
    observer = DockObserver(CHAIR.camera)
    pose = np.array([-2.0, 0.5, -0.3])
    standing(observer, pose, 0.0, 1.0)
    outcomes = [observer.add_detections(0.2 * k + 0.1, [observation(CHAIR, inverse(pose))]).outcome for k in range(5)]
    assert outcomes == [Outcome.ACQUIRING] * 4 + [Outcome.ACQUIRED]
    assert observer.estimate().pose == pytest.approx(T_ODOM_DOCK, abs=1e-9)


def test_no_first_estimate_while_moving_or_inconsistent() -> None:
    observer = DockObserver(CHAIR.camera)
    track = drive(observer, np.array([-2.0, 0.0, 0.0]), 0.3, 0.0, 0.0, 1.0)
    for stamp in list(track)[10:20]:
        assert observer.add_detections(stamp, [observation(CHAIR, inverse(track[stamp]))]).outcome is Outcome.ACQUIRING
    observer = DockObserver(CHAIR.camera)
    standing(observer, [-2.0, 0.0, 0.0], 0.0, 1.0)
    for k in range(10):
        shifted = inverse([-2.0, 0.1 * (k % 2), 0.0])
        assert observer.add_detections(0.05 * k + 0.1, [observation(CHAIR, shifted)]).outcome is Outcome.ACQUIRING


def test_a_late_image_of_a_moving_chair_is_fused_where_it_was_taken() -> None:
    """0.5 m/s and 0.5 rad/s, 150 ms late: fused at arrival it would be 75 mm off; at image time it is unbiased."""
    observer = acquired()
    track = drive(observer, np.array([-2.0, 0.0, 0.0]), 0.5, 0.5, 1.0, 1.2)
    for stamp in (s for s in list(track)[5:-15:3]):
        assert (
            observer.add_detections(stamp, [observation(CHAIR, inverse(track[stamp]), EXACT)]).outcome is Outcome.FUSED
        )
    assert observer.estimate().pose == pytest.approx(T_ODOM_DOCK, abs=1e-6)


def test_between_two_odometry_messages_it_interpolates() -> None:
    buffer = OdometryBuffer(2.0, 0.1)
    start = np.array([1.0, 2.0, 3.1])
    for k in range(5):
        buffer.add(Odometry(0.1 * k, arc_step(start, 0.5, 0.8, 0.1 * k), 0.5, 0.8))
    assert buffer.at(0.234).pose == pytest.approx(arc_step(start, 0.5, 0.8, 0.234), abs=6e-4)
    assert buffer.at(0.234).driven == pytest.approx(0.117, abs=1e-3)
    assert buffer.at(0.45).pose == pytest.approx(arc_step(start, 0.5, 0.8, 0.45), abs=1e-9)
    assert buffer.at(0.51) is None and buffer.at(-0.01) is None and buffer.at(math.nan) is None


def test_order_of_arrival_does_not_matter() -> None:
    rng = np.random.default_rng(3)
    results = []
    errors = rng.normal(size=(10, 3)) * [NOISE[0], NOISE[0], NOISE[1]]
    for order in (list(range(10)), [1, 0, 3, 2, 4, 7, 6, 5, 9, 8]):
        observer = acquired()
        track = drive(observer, np.array([-2.0, 0.0, 0.0]), 0.4, 0.2, 1.0, 1.0)
        stamps = list(track)[5::10][:10]
        for k in order:
            error = inverse(track[stamps[k]]) + errors[k]
            assert observer.add_detections(stamps[k], [observation(CHAIR, error)]).outcome is Outcome.FUSED
        results.append(observer.estimate())
    assert results[0].pose == pytest.approx(results[1].pose, abs=1e-12)
    assert results[0].covariance == pytest.approx(results[1].covariance, abs=1e-15)
    assert results[0].age == results[1].age


def test_an_outlier_changes_nothing_and_the_blind_distance_goes_on() -> None:
    observer = acquired()
    track = drive(observer, np.array([-2.0, 0.0, 0.0]), 0.5, 0.0, 1.0, 0.4)
    before = observer.estimate()
    wrong = inverse(list(track.values())[-1]) + [0.0, 0.15, 0.0]
    assert observer.add_detections(1.4, [observation(CHAIR, wrong)]).outcome is Outcome.GATE
    after = observer.estimate()
    assert np.array_equal(after.pose, before.pose)
    assert after.blind_distance == pytest.approx(0.2, abs=1e-6) and after.age == pytest.approx(0.5)


def test_a_dock_that_really_stands_elsewhere_is_found_again() -> None:
    observer = acquired()
    standing(observer, [-2.0, 0.0, 0.0], 1.01, 2.5)
    moved = inverse([-2.0, 0.3, 0.0])
    outcomes = [observer.add_detections(1.1 + 0.1 * k, [observation(CHAIR, moved)]).outcome for k in range(8)]
    assert outcomes == [Outcome.GATE] * 7 + [Outcome.REACQUIRED]
    assert observer.estimate().pose == pytest.approx(compose(T_ODOM_DOCK, [0.0, -0.3, 0.0]), abs=1e-6)


def test_of_two_hypotheses_the_one_that_passes_the_gate_is_taken() -> None:
    observer = acquired()
    right = observation(CHAIR, inverse([-2.0, 0.0, 0.0]), weight=0.2)
    flipped = observation(CHAIR, inverse([-2.0, 0.0, 0.0]) + [0.0, 0.4, 0.5], weight=0.8)
    assert observer.add_detections(1.0, [flipped, right]).outcome is Outcome.FUSED
    assert observer.estimate().pose == pytest.approx(T_ODOM_DOCK, abs=1e-9)


def test_what_cannot_be_a_dock_on_the_floor_is_a_flip_or_invalid() -> None:
    observer = acquired()
    good = observation(CHAIR, inverse([-2.0, 0.0, 0.0]))
    tilt = np.eye(4)
    tilt[:3, :3] = [[math.cos(0.6), 0, math.sin(0.6)], [0, 1, 0], [-math.sin(0.6), 0, math.cos(0.6)]]
    bad = [
        Hypothesis(good.T_optical_dock @ tilt, good.covariance),
        Hypothesis(good.T_optical_dock * math.nan, good.covariance),
        Hypothesis(good.T_optical_dock, np.zeros((6, 6))),
        Hypothesis(good.T_optical_dock, good.covariance, math.nan),
    ]
    outcomes = [observer.add_detections(1.0, [hypothesis]).outcome for hypothesis in bad]
    assert outcomes == [Outcome.FLIP] + [Outcome.INVALID] * 3
    assert observer.add_detections(1.0, [bad[0], good]).outcome is Outcome.FUSED
    assert observer.add_detections(1.0, []).outcome is Outcome.EMPTY
    assert observer.add_detections(7.0, [good]).outcome is Outcome.NO_ODOMETRY
    assert observer.add_detections(math.nan, [good]).outcome is Outcome.NO_ODOMETRY


def test_an_innovation_is_measured_minus_expected_with_its_covariance_and_gate() -> None:
    """After five images of variance R, standing, the expectation has R / 5; the sixth is 6 mm off in the dock's x."""
    p = ObserverParameters()
    observer = acquired()
    fusion = observer.add_detections(1.0, [observation(CHAIR, inverse([-2.0, 0.0, 0.0]) + [0.006, 0.0, 0.0])])
    innovation = fusion.innovation
    R, common = np.square([NOISE[0], NOISE[0], NOISE[1]]), p.calibration_position**2
    direction = np.array([math.cos(T_ODOM_DOCK[2]), math.sin(T_ODOM_DOCK[2]), 0.0])
    variance = 1.2 * R + [common, common, p.calibration_heading**2]
    assert innovation.value == pytest.approx(0.006 * direction, abs=1e-9)
    assert innovation.covariance == pytest.approx(np.diag(variance), rel=1e-3, abs=1e-9)
    assert innovation.sd == pytest.approx(np.sqrt(variance), rel=1e-3)
    assert innovation.nis == pytest.approx(0.006**2 / variance[0], rel=1e-3)
    assert innovation.gate_ratio == pytest.approx(innovation.nis / p.gate)
    assert fusion.outcome is Outcome.FUSED and fusion.outcome.accepted and innovation.gate_ratio < 1.0


def test_why_a_measurement_is_not_used_is_said() -> None:
    observer = acquired()
    pose = inverse([-2.0, 0.0, 0.0])
    far = observer.add_detections(1.0, [observation(CHAIR, pose + [0.0, 0.15, 0.0])])
    assert far.outcome is Outcome.GATE and not far.outcome.accepted and far.innovation.gate_ratio > 1.0
    assert np.hypot(*far.innovation.value[:2]) == pytest.approx(0.15, abs=1e-6)
    stale = observer.add_detections(0.1, [observation(CHAIR, pose)])
    assert stale.outcome is Outcome.STALE and stale.innovation is None and stale.outcome.text == "stale"
    assert DockObserver(CHAIR.camera).add_detections(1.0, []).outcome is Outcome.EMPTY


def test_covariance_grows_with_the_distance_driven_not_with_time() -> None:
    observer = acquired()
    before = observer.estimate()
    standing(observer, [-2.0, 0.0, 0.0], 1.01, 1.5)
    assert observer.estimate().covariance == pytest.approx(before.covariance)
    drive(observer, np.array([-2.0, 0.0, 0.0]), 0.5, 0.0, 1.5, 0.5)
    near = observer.estimate()
    drive(observer, np.array([-1.75, 0.0, 0.0]), 0.5, 0.0, 2.0, 0.5)
    far = observer.estimate()
    assert np.all(np.diag(near.covariance) > np.diag(before.covariance))
    assert np.all(np.diag(far.covariance) > np.diag(near.covariance))


def test_odometry_that_is_not_finite_or_not_newer_is_refused_and_counted() -> None:
    observer = acquired()
    pose = np.array([0.0, 0.0, 0.0])
    assert not observer.add_odometry(Odometry(1.1, pose * math.nan, 0.0, 0.0))
    assert not observer.add_odometry(Odometry(1.1, pose, math.inf, 0.0))
    assert not observer.add_odometry(Odometry(0.9, pose, 0.0, 0.0))
    assert observer.refused_odometry == 3


def test_a_prior_keeps_other_docks_out() -> None:
    observer = DockObserver(CHAIR.camera)
    observer.reset(prior=compose(T_ODOM_DOCK, [0.0, 3.0, 0.0]), prior_radius=1.0)
    standing(observer, [-2.0, 0.0, 0.0], 0.0, 1.0)
    for k in range(6):
        observer.add_detections(0.1 + 0.1 * k, [observation(CHAIR, inverse([-2.0, 0.0, 0.0]))])
    assert observer.estimate() is None


@pytest.mark.extensive  # seater_eval's test_observer_consistency asks the same of a plant of another make
def test_error_is_as_large_as_the_covariance_says() -> None:
    """NEES over 30 approaches with drifting odometry: the mean of 30 chi-square numbers (3 dof) within its 95 % band.
    More of this, with the simulator's odometry and camera: seater_eval/test/test_observer_consistency.py."""
    p, rng, values = (
        ObserverParameters(calibration_position=0.0, calibration_heading=0.0),
        np.random.default_rng(11),
        [],
    )
    for _ in range(30):
        observer, truth, odom = DockObserver(CHAIR.camera, p), np.array([-2.0, 0.2, -0.1]), np.zeros(3)
        e_s, e_t, e_d = rng.normal(size=3) * [p.scale_sd, p.heading_scale_sd, p.heading_drift_sd]
        for k in range(150):
            v, omega = (0.0, 0.0) if k < 30 else (0.4, 0.2 * math.sin(0.05 * k))
            truth = arc_step(truth, v, omega, 0.02)
            way, turn = v * 0.02, omega * 0.02
            truth = compose(truth, [0.0, rng.normal() * p.side_noise * math.sqrt(way), 0.0])
            n_s = rng.normal() * p.distance_noise * math.sqrt(way)
            n_t = rng.normal() * math.sqrt(p.heading_noise**2 * way + p.turn_noise**2 * abs(turn))
            odom = arc_step(odom, way * (1.0 + e_s) + n_s, turn * (1.0 + e_t) + way * e_d + n_t, 1.0)
            observer.add_odometry(Odometry(0.02 * (k + 1), odom, v, omega))
            error = rng.normal(size=3) * [0.004, 0.004, 0.006]
            if k % 2 == 0:
                observer.add_detections(0.02 * (k + 1), [observation(CHAIR, inverse(truth) + error, (0.004, 0.006))])
        estimate = observer.estimate()
        residual = difference(estimate.pose, compose(odom, inverse(truth)))
        values.append(residual @ np.linalg.solve(estimate.covariance, residual))
    assert 2.19 < np.mean(values) < 3.94
    assert wrap_angle(residual[2]) == residual[2]


def test_two_poses_that_both_agree_are_told_apart_by_all_weights_together() -> None:
    """A flip that stays put while the chair stands: 0.6 to 0.4 in each image, now and then the wrong one ahead."""
    observer = DockObserver(CHAIR.camera, ObserverParameters(acquire_odds=20.0))
    standing(observer, [-2.0, 0.0, 0.0], 0.0, 2.0)
    true, flip = inverse([-2.0, 0.0, 0.0]), inverse([-2.0, 0.0, 0.0]) + [0.0, 0.0, 0.4]
    outcomes = []
    for k in range(10):
        weight = 0.45 if k % 5 == 4 else 0.65
        offered = [observation(CHAIR, flip, weight=1.0 - weight), observation(CHAIR, true, weight=weight)]
        outcomes.append(observer.add_detections(0.1 + 0.1 * k, offered).outcome)
        if outcomes[-1] is Outcome.ACQUIRED:
            break
    assert outcomes[4] is Outcome.ACQUIRING and outcomes[-1] is Outcome.ACQUIRED
    assert observer.estimate().pose == pytest.approx(T_ODOM_DOCK, abs=1e-6)


def test_what_is_asked_again_is_answered_anew_when_something_came() -> None:
    """Estimates and instants are kept for those who ask again in the same cycle."""
    observer = acquired()
    ahead = observer.odometry.at(1.05)
    assert observer.odometry.at(1.05) is ahead
    first = observer.estimate(1.0)
    assert observer.estimate(1.0) is first
    observer.add_detections(1.0, [observation(CHAIR, inverse([-2.001, 0.0, 0.0]))])
    fused = observer.estimate(1.0)
    assert fused.age == 0.0 < first.age and fused.pose[0] > first.pose[0]
    drive(observer, np.array([-2.0, 0.0, 0.0]), 0.5, 0.0, 1.0, 0.05)
    assert observer.odometry.at(1.05).pose != pytest.approx(ahead.pose)
    assert observer.estimate(1.05).blind_distance == pytest.approx(0.025)


def test_true_speeds_are_those_of_the_odometry_less_its_errors() -> None:
    assert DockObserver(CHAIR.camera).true_speeds(0.2, 0.1) == (0.2, 0.1)
    scaled = acquired(parameters=ObserverParameters(odometry_scale=0.25, odometry_heading_scale=-0.2))
    assert scaled.true_speeds(0.25, 0.08) == pytest.approx((0.2, 0.1), abs=1e-6)


@pytest.mark.parametrize(("distance", "outcome"), [(3.5, Outcome.ACQUIRED), (1.0, Outcome.ELSEWHERE)])
def test_a_dock_acquired_as_its_mirror_image_is_acquired_anew_from_afar(distance: float, outcome: Outcome) -> None:
    """Seen 0.1 rad aside the markers face 0.2 rad otherwise; nearby, images that begin to say so are what is wrong."""
    pose = np.array([0.9 - distance, 0.1 * distance, 0.0])
    front, sight = Dock().front, math.atan2(0.1 * distance, -distance)
    mirrored = np.array([*front[:2], wrap_angle(2.0 * sight - front[2])])
    T_true_wrong = compose(mirrored, inverse(front))  # the dock whose markers are there, and face so
    observer = DockObserver(CHAIR.camera)
    standing(observer, pose, 0.0, 1.6)
    wrong, right = observation(CHAIR, compose(inverse(pose), T_true_wrong)), observation(CHAIR, inverse(pose))
    first = [observer.add_detections(0.1 + 0.1 * k, [wrong]).outcome for k in range(5)]
    assert first[-1] is Outcome.ACQUIRED
    observer.bound_reacquisition(True, front)
    outcomes = [observer.add_detections(0.7 + 0.1 * k, [right]).outcome for k in range(8)]
    assert outcomes[-1] is outcome and outcomes[0] is Outcome.GATE
    if outcome is Outcome.ACQUIRED:
        assert observer.estimate().pose == pytest.approx(T_ODOM_DOCK, abs=1e-6)
        assert observer.images.jump is None


@pytest.mark.parametrize(("noise", "outcome"), [((0.03, 0.02), Outcome.REACQUIRED), (NOISE, Outcome.ELSEWHERE)])
def test_a_dock_that_was_known_roughly_may_be_farther_off(noise, outcome: Outcome) -> None:
    """From afar: of rigid-body chairs one ended with INCONSISTENT, "158 mm from where it was"."""
    pose = np.array([-4.0, 0.0, 0.0])
    observer = DockObserver(CHAIR.camera)
    standing(observer, pose, 0.0, 1.6)
    for k in range(5):
        observer.add_detections(0.1 + 0.1 * k, [observation(CHAIR, inverse(pose) + [0.0, -0.24, 0.0], noise)])
    observer.bound_reacquisition(True, Dock().front)
    exact = [observation(CHAIR, inverse(pose), (0.01, 0.01))]
    outcomes = [observer.add_detections(0.7 + 0.1 * k, exact).outcome for k in range(8)]
    assert outcomes[-1] is outcome, outcomes
