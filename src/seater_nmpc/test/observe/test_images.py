"""What counts as shown by the images: not what one that was believed has shown to be wrong."""

import numpy as np
import pytest
from drives import Drive

from seater_nmpc.observe.bank import FilterBank
from seater_nmpc.observe.images import Images, Jump
from seater_nmpc.observe.innovation import Fusion, Outcome
from seater_nmpc.observe.measurement import Measurement
from seater_nmpc.observe.odometry.buffer import OdometryBuffer
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ObserverParameters, PlausibilityParameters
from seater_nmpc.plausibility.jump import sudden


def approaching() -> Drive:
    drive = Drive()
    drive.go(0.0, 0.0, 1.0)
    drive.go(0.2, 0.0, 2.0)
    return drive


def stamps_shown(drive: Drive) -> set[float]:
    return {round(chair.stamp, 3) for chair, _ in drive.observer.images.shown}


def test_what_an_image_shows_that_was_wrong_is_forgotten_with_the_next_that_is_right() -> None:
    drive = approaching()
    drive.image_period = 9.0  # none but these two
    drive.go(0.2, 0.0, 0.1)
    wrong = {drive.now}
    drive.look((-0.05, 0.03, 0.0))
    drive.go(0.2, 0.0, 0.1)
    wrong.add(drive.now)
    drive.look((-0.05, 0.03, 0.0))
    assert drive.outcomes[-2:] == ["GATE", "GATE"] and wrong <= stamps_shown(drive)
    drive.go(0.2, 0.0, 0.1)
    drive.look()
    assert drive.outcomes[-1] == "FUSED" and not wrong & stamps_shown(drive)


def test_images_that_a_filter_for_slip_comes_to_believe_were_right() -> None:
    drive = approaching()
    before = len(drive.fusions)
    drive.pull = lambda pose: 1.0  # one wheel spins
    drive.go(0.4, 0.0, 1.0)
    rejected = {round(3.1 + 0.1 * i, 3) for i, name in enumerate(drive.outcomes[before:]) if name == "GATE"}
    assert rejected and drive.outcomes[-1] == "FUSED" and rejected <= stamps_shown(drive)


def test_a_jump_is_what_images_agree_on_and_not_what_wrong_ones_showed_before() -> None:
    """Two that are flipped, then those of a wheel that spins: taken for slip, they say nothing of the first two."""
    drive = approaching()
    drive.image_period = 9.0
    for _ in range(2):
        drive.go(0.2, 0.0, 0.1)
        drive.look((0.4, 0.2, 0.6))
    assert drive.outcomes[-2:] == ["GATE", "GATE"]
    drive.pull, drive.image_period = lambda pose: 1.0, 0.1
    drive.go(0.4, 0.0, 1.0)
    jump = drive.observer.images.jump
    assert drive.outcomes[-1] == "FUSED" and jump is not None
    assert all(abs((m.pose - image.expected.pose)[2]) < 0.5 for image in jump.doubted for m in image.shown)


MIRRORED, RIGHT = np.array([2.0, 0.0, 0.15]), np.array([2.05, 0.06, -0.15])


def jump_to(after: list[np.ndarray], left_open: list[np.ndarray], weight: float = 0.5) -> Jump:
    """The dock is known as MIRRORED, by images that leave these other poses open, of this weight; then a chair at 0.2
    m/s is shown those of `after`, until they are taken up."""
    buffer, images = OdometryBuffer(10.0, 0.1), Images(10.0)
    bank = FilterBank(ObserverParameters(), 1e-6 * np.eye(3))
    for k in range(16):
        moving = k >= 6
        buffer.add(Odometry(0.1 * k, np.array([0.02 * max(k - 6, 0), 0.0, 0.0]), 0.2 * moving, 0.0))
        chair = buffer.newest
        assert chair is not None
        known = Measurement(MIRRORED, 2.5e-5 * np.eye(3), 1.0 - weight)
        if k == 0:
            bank.begin([(chair, known)])
            continue
        shown = [*(Measurement(pose, 2.5e-5 * np.eye(3), weight) for pose in left_open), known]
        if k > 7:
            shown = [Measurement(pose, 2.5e-5 * np.eye(3)) for pose in after]
        images.show(chair, shown)
        fusion = bank.take(chair, shown)
        assert (fusion.outcome is Outcome.FUSED) == (k <= 7)
        if k == 15:
            fusion = Fusion(outcome=Outcome.REACQUIRED, innovation=fusion.innovation, measurement=shown[0])
        images.note(chair.stamp, fusion, as_expected=True)
    assert images.jump is not None
    return images.jump


AWAY = MIRRORED + [0.1, -0.05, 0.25]  # the mirror image, once the chair has moved


@pytest.mark.parametrize(
    ("left_open", "weight", "jumps"), [([], 0.5, True), ([RIGHT], 0.5, False), ([RIGHT], 0.01, True)]
)
def test_from_one_to_the_other_of_two_poses_that_images_leave_open_the_dock_does_not_jump(
    left_open: list[np.ndarray], weight: float, jumps: bool
) -> None:
    """It ended INCONSISTENT, "on the way the dock jumped by 101 mm" (single_marker, seed 546325347)."""
    jump = jump_to([RIGHT, AWAY], left_open, weight)
    assert (sudden(jump, PlausibilityParameters()) is not None) == jumps


def test_a_pose_that_is_left_open_hides_no_jump() -> None:
    """A focal length that is another one from an image to the next: both poses are farther away."""
    farther = np.array([0.2, 0.0, 0.0])
    shift = sudden(jump_to([MIRRORED + farther, RIGHT + farther], [RIGHT]), PlausibilityParameters())
    assert shift is not None and shift.way == pytest.approx(0.2, abs=0.01) and "farther away" in shift.text


def test_how_far_the_dock_has_jumped_is_told_of_the_pose_that_is_taken_up() -> None:
    """Of two poses the one that an image names first is not the one that its distance from the known dock is of."""
    jump = jump_to([RIGHT, AWAY], [])
    assert [len(image.shown) for image in jump.doubted] == [1, 1, 1]
    assert all(image.shown[0].pose == pytest.approx(RIGHT) for image in jump.doubted)
    assert all(image.expected.pose == pytest.approx(MIRRORED, abs=0.01) for image in jump.doubted)
