"""The relay opens when it is told to, and by silence."""

import pytest

from seater_sim.loop.motor_enable import MotorEnable

SECOND = 1_000_000_000


@pytest.mark.parametrize("watch_silence", [False, True])
def test_what_was_said_last_counts(watch_silence: bool) -> None:
    relay = MotorEnable(watch_silence=watch_silence)
    assert relay.on(SECOND)
    relay.told(False, SECOND)
    assert not relay.on(SECOND + 1)
    relay.told(True, 2 * SECOND)
    assert relay.on(2 * SECOND + 1)


def test_silence_means_off_where_it_is_watched() -> None:
    watching, patient = MotorEnable(watch_silence=True), MotorEnable(watch_silence=False)
    for relay in (watching, patient):
        relay.told(True, SECOND)
        assert relay.on(SECOND + 300_000_000)
    assert not watching.on(SECOND + 300_000_001)
    assert patient.on(100 * SECOND)


def test_who_never_hears_of_it_has_power() -> None:
    assert MotorEnable(watch_silence=True).on(100 * SECOND)
