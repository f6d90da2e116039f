"""A scripted series on the simulated firmware, in a time of its own: it finds the curve, and ends without power."""

import numpy as np
import pytest

from seater_base.deflection.fit import AXES, fit
from seater_base.deflection.inverse import Axis
from seater_base.deflection.series import Plan, Series, SeriesError
from seater_base.deflection.table import DeflectionTable
from seater_base.firmware import Firmware, JoystickInput
from seater_base.port import PortError
from seater_base.settings import BaseSettings

SETTINGS, TABLE = BaseSettings(), DeflectionTable()


class Bench:
    """The wire between series and firmware; time goes on while somebody reads."""

    def __init__(self, firmware: Firmware) -> None:
        self.firmware, self.now = firmware, 0.0
        self.plugged, self.silent, self.closed = True, False, False

    def read(self, timeout: float) -> bytes:
        if not self.plugged:
            raise PortError("the port is gone")
        self.now += min(timeout, 0.02)
        out = self.firmware.step(self.now)
        return b"" if self.silent else out

    def write(self, data: bytes) -> None:
        if not self.plugged:
            raise PortError("the port is gone")
        self.firmware.receive(data)

    def close(self) -> None:
        self.closed = True

    def series(self, plan: Plan, say=lambda text: None) -> Series:
        return Series(SETTINGS, plan, say, open_port=lambda path, baud: self, clock=lambda: self.now)


def test_a_series_of_steps_finds_the_chairs_own_curve() -> None:
    bench, told = Bench(Firmware(SETTINGS.wheels, joystick=JoystickInput(TABLE))), []
    pairs = bench.series(Plan(reach=1.1, levels=11), told.append).run()
    assert bench.closed and not bench.firmware.power
    assert len(told) == len(pairs) - len(AXES)  # all but those at neutral
    for axis, truth in zip(AXES, (TABLE.drive, TABLE.turn), strict=True):
        found = Axis(fit(axis, pairs, 2.5))
        for speed in np.linspace(-0.45, 0.45, 19):
            driven = np.interp(found.volts(speed), truth.volts, truth.speeds)
            assert driven == pytest.approx(speed, abs=0.02), (axis, speed)


def test_no_side_goes_on_outward_when_it_is_fast_enough() -> None:
    bench = Bench(Firmware(SETTINGS.wheels, joystick=JoystickInput(TABLE)))
    pairs = bench.series(Plan(reach=1.1, levels=11, fastest=(0.2, 0.3))).run()
    assert max(abs(speed) for axis, _, speed in pairs if axis == "drive") < 0.27  # the first beyond 0.2
    assert {axis for axis, _, _ in pairs} == set(AXES)


@pytest.mark.parametrize("trouble", ["button", "silent", "unplugged", "started anew"])
def test_whatever_goes_wrong_ends_it_and_the_chair_stands(trouble: str) -> None:
    bench = Bench(Firmware(SETTINGS.wheels, joystick=JoystickInput(TABLE)))

    def begin(_: str) -> None:
        if trouble == "button":
            bench.firmware.emergency_stop = True
        bench.silent, bench.plugged = trouble == "silent", trouble != "unplugged"
        if trouble == "started anew":
            bench.firmware = Firmware(SETTINGS.wheels, joystick=JoystickInput(TABLE))

    with pytest.raises(
        (SeriesError, PortError), match={"button": "emergency stop", "unplugged": "gone"}.get(trouble, trouble)
    ):
        bench.series(Plan(), begin).run()
    assert bench.closed
    for _ in range(100):
        bench.now += 0.02
        bench.firmware.step(bench.now)
    assert bench.firmware.speeds == [0.0, 0.0] and not bench.firmware.power


@pytest.mark.parametrize(("version", "words"), [(1, "voltages need protocol 2"), (None, "does not say who it is")])
def test_a_base_that_takes_no_voltages_is_told_none(version: int | None, words: str) -> None:
    bench = Bench(Firmware(SETTINGS.wheels, version=version or 2))
    bench.silent = version is None
    with pytest.raises(SeriesError, match=words):
        bench.series(Plan()).run()
    assert bench.closed and not bench.firmware.power
