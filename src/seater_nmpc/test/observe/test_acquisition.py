"""Which images make the first estimate."""

import numpy as np
import pytest

from seater_nmpc.observe.acquisition import Acquisition, Series
from seater_nmpc.observe.measurement import Measurement
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.observe.odometry.travel import NO_TRAVEL

COVARIANCE = np.diag([0.002, 0.002, 0.003]) ** 2
DOCK = np.array([2.0, 1.0, 0.5])
ELSEWHERE = (0.3, -0.2, 0.6)


def offer(acquisition: Acquisition, image: int, *poses: tuple[float, float, float], weights=None) -> Series | None:
    """The image of that number, every 0.1 s, which leaves these offsets from DOCK open."""
    rng = np.random.default_rng(image)
    noise = rng.normal(size=3) * np.sqrt(np.diag(COVARIANCE))
    chair = Instant(0.1 * image, np.zeros(3), 0.0, 0.0, NO_TRAVEL)
    offered = zip(poses, weights or [1.0] * len(poses), strict=True)
    agreed = acquisition.offer(
        chair, [Measurement(DOCK + pose + noise, COVARIANCE, weight) for pose, weight in offered]
    )
    return None if agreed is None else agreed.series


def acquisition(drift=lambda dock, before, now: np.zeros((3, 3))) -> Acquisition:
    return Acquisition(5, 16.3, 20.0, np.diag([0.001, 0.001, 0.002]) ** 2, drift)


RIGHT = (0.0, 0.0, 0.0)


def test_five_that_agree_are_enough_and_come_in_the_order_of_their_times() -> None:
    candidates = acquisition()
    results = [offer(candidates, image, RIGHT) for image in (0, 2, 1, 3, 4)]
    assert results[:4] == [None] * 4 and results[4] is not None
    assert [round(10.0 * chair.stamp) for chair, _ in results[4]] == [0, 1, 2, 3, 4]


def test_one_wrong_image_among_six_does_not_matter_wherever_it_comes() -> None:
    for wrong in range(5):
        candidates = acquisition()
        results = [offer(candidates, image, ELSEWHERE if image == wrong else RIGHT) for image in range(6)]
        assert results[:5] == [None] * 5 and results[5] is not None, wrong
        assert [round(10.0 * chair.stamp) for chair, _ in results[5]] == [i for i in range(6) if i != wrong]
        assert all(np.hypot(*(m.pose - DOCK)[:2]) < 0.01 for _, m in results[5])


def test_images_of_which_half_are_wrong_make_no_estimate() -> None:
    candidates = acquisition()
    apart = [(0.05 * image, 0.0, 0.0) if image % 2 else RIGHT for image in range(12)]
    assert [offer(candidates, image, pose) for image, pose in enumerate(apart)] == [None] * 12


def test_two_poses_that_both_agree_wait_for_the_odds_or_for_patience() -> None:
    def images_until(weights: list[float]) -> int:
        candidates = acquisition()
        for image in range(30):
            series = offer(candidates, image, ELSEWHERE, RIGHT, weights=weights)
            if series is not None:
                assert np.hypot(*(series[0][1].pose - DOCK)[:2]) < 0.01
                return image + 1
        return 99

    assert images_until([0.2, 0.8]) == 5  # 4^5 : 1
    assert images_until([0.4, 0.6]) == 8  # 1.5^8 > 20 : 1
    assert images_until([0.4999, 0.5001]) == 20


def test_what_odometry_may_have_moved_in_between_is_allowed_for() -> None:
    """The dock creeps by 1 cm an image: agreed upon only by who is told that odometry may drift so."""

    def results(candidates: Acquisition) -> list[bool]:
        return [offer(candidates, image, (0.01 * image, 0.0, 0.0)) is not None for image in range(7)]

    def drift(dock, before: Instant, now: Instant) -> np.ndarray:
        return np.diag([(0.1 * (now.stamp - before.stamp)) ** 2, 1e-12, 1e-12])

    assert not any(results(acquisition())) and results(acquisition(drift))[4]


def test_cleared_it_begins_anew() -> None:
    candidates = acquisition()
    for image in range(4):
        offer(candidates, image, RIGHT)
    candidates.clear()
    assert offer(candidates, 4, RIGHT) is None


def test_a_wrong_image_takes_no_pose_out_of_the_running() -> None:
    """Alone it agrees with the one of two that is uncertain, not with what all say; so both stay open."""

    def seen(off: float, sd: float, weight: float) -> Measurement:
        return Measurement(DOCK + off, sd**2 * np.eye(3), weight)

    both = [seen(-0.2, 0.04, 0.6), seen(0.0, 0.12, 0.4)]
    candidates = acquisition()
    for image in range(9):
        poses = both if image else [seen(0.31, 0.06, 0.6), seen(-0.6, 0.06, 0.4)]
        agreed = candidates.offer(Instant(0.1 * image, np.zeros(3), 0.0, 0.0, NO_TRAVEL), poses)
        assert (agreed is None) == (image < 8)  # 1.5^8 > 20 : 1
    assert {float(np.round(m.pose[0] - DOCK[0], 6)) for _, m in agreed.series} == {-0.2}
    assert {float(np.round(m.pose[0] - DOCK[0], 6)) for _, m in agreed.other} == {0.0}
    assert agreed.odds == pytest.approx(-8.0 * np.log(1.5))
