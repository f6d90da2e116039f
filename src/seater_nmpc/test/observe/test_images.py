"""What counts as shown by the images: not what one that was believed has shown to be wrong."""

from drives import Drive


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
    assert all(abs(off.value[2]) < 0.5 for _, _, off in jump.doubted)
