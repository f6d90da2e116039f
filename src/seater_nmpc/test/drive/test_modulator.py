"""Speeds inside the deadband by short moves."""

import numpy as np
import pytest

from seater_nmpc.drive.axis import AxisDrive
from seater_nmpc.drive.modulator import Modulator

PERIOD, SHORTEST = 0.05, 0.1  # [s]
KINDS = pytest.mark.parametrize("drive", [AxisDrive(0.9, 0.05, kind) for kind in (False, True)], ids=["jump", "offset"])


def driven(drive: AxisDrive, wanted, steady: bool = False, modulator: Modulator | None = None):
    """Commands for a series of wanted speeds, and the steady speeds that they bring about."""
    modulator, commands = modulator or Modulator(), []
    for speed in wanted:
        commands.append(modulator.command(speed, drive, PERIOD, steady=steady))
        modulator.sent(commands[-1], drive, PERIOD)
    return np.array(commands), np.array([drive.effective(command) for command in commands])


@KINDS
def test_the_way_is_the_wanted_one_to_within_a_short_move(drive) -> None:
    """At any time in a second, in which little is forgotten: a move too little before it, a cycle too much after it."""
    move, cycle = drive.smallest_speed * SHORTEST, drive.smallest_speed * PERIOD
    for part in np.linspace(0.0, 2.0, 21):
        wanted = np.full(20, part * drive.smallest_speed)
        forgotten = 0.25 * move if part < 1.0 else 0.0
        for sign in (1.0, -1.0):
            off = sign * np.cumsum(driven(drive, sign * wanted)[1] - sign * wanted) * PERIOD
            assert np.all(off >= -move - forgotten) and np.all(off <= cycle + 1e-9), part


@KINDS
def test_in_the_long_run_the_mean_speed_is_the_wanted_one(drive) -> None:
    """From a fifth of the smallest one on to within a tenth: what is wanted is forgotten meanwhile."""
    for part in (0.2, 0.35, 0.5, 0.8, 0.95):
        speeds = driven(drive, np.full(600, part * drive.smallest_speed))[1]
        assert 0.88 * part <= speeds.mean() / drive.smallest_speed <= part + 0.005
        assert speeds.min() == 0.0 and speeds.max() == pytest.approx(drive.smallest_speed)


@KINDS
def test_no_command_lies_inside_the_deadband(drive) -> None:
    wanted = 0.09 * np.sin(np.linspace(0.0, 40.0, 2000)) + 0.01 * np.random.default_rng(4).normal(size=2000)
    for steady in (False, True):
        commands = np.abs(driven(drive, wanted, steady)[0])
        assert np.all((commands == 0.0) | (commands >= 1.25 * drive.deadband - 1e-12))
        assert np.any(commands == 0.0) and np.any(commands > 0.09)


def test_steady_goes_on_rather_than_stop_and_go() -> None:
    drive = AxisDrive(1.0, 0.05)
    slow = np.full(100, 0.4 * drive.smallest_speed)
    assert np.count_nonzero(np.diff(driven(drive, slow)[0])) > 15
    commands, _ = driven(drive, slow, steady=True)
    assert np.count_nonzero(np.diff(commands)) == 1 and commands[-1] == pytest.approx(1.25 * 0.05)
    stopping = np.concatenate([slow, np.full(40, 0.01 * drive.smallest_speed)])
    assert driven(drive, stopping, steady=True)[0][-1] == 0.0


def test_noise_about_zero_and_what_is_long_past_move_nothing() -> None:
    drive = AxisDrive(1.0, 0.05)
    noise = 0.15 * drive.smallest_speed * np.random.default_rng(5).normal(size=2000)
    assert np.count_nonzero(driven(drive, noise)[0]) < 20
    assert not np.any(driven(drive, np.full(2000, 0.04 * drive.smallest_speed))[0])
    modulator = Modulator()
    driven(drive, [0.9 * drive.smallest_speed], modulator=modulator)  # owes nearly half of a move
    driven(drive, np.zeros(200), modulator=modulator)
    assert not np.any(driven(drive, [1.5 * drive.smallest_speed * PERIOD / SHORTEST], modulator=modulator)[0])


def test_after_a_reset_nothing_is_owed() -> None:
    drive, modulator = AxisDrive(1.0, 0.05), Modulator()
    driven(drive, [0.9 * drive.smallest_speed, 0.9 * drive.smallest_speed], modulator=modulator)
    modulator.reset()
    assert not np.any(driven(drive, [0.9 * drive.smallest_speed], modulator=modulator)[0])


def test_without_a_deadband_every_speed_passes() -> None:
    wanted = 0.01 * np.sin(np.linspace(0.0, 10.0, 50))
    assert driven(AxisDrive(0.8), wanted)[0] == pytest.approx(wanted / 0.8)
