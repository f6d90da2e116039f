"""Driver and firmware over a pseudo-terminal, in true time: what the person's safety rests on."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from seater_base.deflection.inverse import Deflections
from seater_base.deflection.table import DeflectionTable
from seater_base.driver import Driver
from seater_base.firmware import FASTER, Firmware, JoystickInput, SimulatedBase
from seater_base.odometry import Driven
from seater_base.protocol import Command, Deflection, Flags, encode
from seater_base.settings import BaseSettings
from seater_common.params import load, read_yaml

SETTINGS = BaseSettings()
TABLE = DeflectionTable()
FILE = Path(__file__).resolve().parents[3] / "config" / "base.yaml"


def wait(condition: Callable[[], bool], seconds: float = 10.0) -> float:
    """How long it took [s]."""
    begin = time.monotonic()
    while not condition():
        assert time.monotonic() - begin < seconds, "waited in vain"
        time.sleep(0.002)
    return time.monotonic() - begin


class Pair:
    """A simulated base and the driver of it."""

    def __init__(self, firmware: Firmware | None = None, table: DeflectionTable | None = None) -> None:
        self.base = SimulatedBase(firmware or Firmware(SETTINGS.wheels))
        self.driven: list[Driven] = []
        self.driver = Driver(
            replace(SETTINGS, port=self.base.path),
            self.driven.append,
            deflections=None if table is None else Deflections(table),
        )
        self.driver.start()

    def tell(
        self,
        seconds: float,
        *,
        v: float = 0.3,
        power: bool = True,
        velocity: bool = True,
        until: Callable[[], bool] = lambda: False,
    ) -> None:
        """As the gate does, 50 times per second."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and not until():
            if power:
                self.driver.power(True)
            if velocity:
                self.driver.velocity(v, 0.0, "gate")
            time.sleep(0.02)

    def drive(self) -> None:
        """From zero until it has the speed that it is told."""
        self.tell(10.0, until=lambda: not self.driver.request.why, v=0.0)
        self.tell(10.0, until=lambda: self.speed > 0.299)
        assert self.speed == pytest.approx(0.3, abs=1e-3)

    @property
    def speed(self) -> float:
        return max(abs(speed) for speed in self.base.firmware.speeds)


@pytest.fixture
def pair() -> Iterator[Pair]:
    made = Pair()
    wait(lambda: made.driver.trouble == "")
    yield made
    made.driver.stop()


def test_the_shipped_file_holds_the_defaults() -> None:
    assert load(BaseSettings, read_yaml(FILE), "base") == BaseSettings()


def test_drives_and_tells_where_it_is(pair: Pair) -> None:
    pair.drive()
    pair.tell(10.0, until=lambda: abs(pair.driven[-1].v - 0.3) < 0.01)
    assert pair.driver.identity is not None and pair.driver.identity.name == "simulated"
    now, last = time.monotonic(), pair.driven[-1]
    assert abs(last.v - 0.3) < 0.01
    assert last.pose[0] == pytest.approx(0.3 * 0.3 / (2.0 * FASTER) + 0.1, abs=0.2)  # the way to this speed, and some
    assert 0.0 <= now - last.time < 0.5
    assert pair.driver.damaged == 0


def test_silence_of_cmd_vel_stops(pair: Pair) -> None:
    pair.drive()
    pair.tell(0.8, velocity=False)  # 0.3 s of silence, 0.2 s of braking, and a loaded machine
    assert pair.speed == 0.0 and pair.base.firmware.power


def test_silence_of_motor_enable_takes_the_power(pair: Pair) -> None:
    pair.drive()
    pair.tell(0.8, power=False)
    assert pair.speed == 0.0 and not pair.base.firmware.power


def test_a_cable_that_breaks_stops_the_base_by_itself(pair: Pair) -> None:
    pair.drive()
    pair.base.deaf = True
    pair.tell(0.8)
    assert pair.speed == 0.0 and not pair.base.firmware.power


def test_the_end_of_the_driver_takes_the_power() -> None:
    made = Pair()
    wait(lambda: made.driver.trouble == "")
    made.drive()
    made.driver.stop()
    assert wait(lambda: not made.base.firmware.power) < 0.25, "told, not by silence"
    made.base.close()


def test_unplugged_is_said_and_no_way_is_made_up(pair: Pair) -> None:
    pair.tell(0.5)
    known = len(pair.driven)
    pair.base.close()
    wait(lambda: "plugged in" in pair.driver.trouble)
    pair.tell(0.3)
    assert len(pair.driven) <= known + 5
    pair.base = SimulatedBase(Firmware(SETTINGS.wheels))  # for the fixture's end
    pair.base.close()


def test_a_base_that_starts_anew_does_not_drive_on(pair: Pair) -> None:
    pair.drive()
    pair.base.firmware = Firmware(SETTINGS.wheels)
    pair.tell(1.0)
    assert pair.speed == 0.0 and "since the base was started" in pair.driver.request.why
    pair.drive()


def test_a_base_of_another_protocol_is_not_driven() -> None:
    made = Pair(Firmware(SETTINGS.wheels, version=9))
    wait(lambda: "protocol 9, not 2" in made.driver.trouble)
    made.tell(0.5)
    assert not made.base.firmware.power and made.driven == []
    made.driver.stop()
    made.base.close()


def test_a_base_of_the_first_protocol_drives_and_tells_nothing_of_a_charger() -> None:
    made = Pair(Firmware(SETTINGS.wheels, version=1))
    wait(lambda: made.driver.trouble == "")
    made.drive()
    assert not made.driver.tells_charging
    made.driver.stop()
    made.base.close()


def test_a_joysticks_voltages_go_to_no_base_of_the_first_protocol() -> None:
    made = Pair(Firmware(SETTINGS.wheels, version=1, joystick=JoystickInput(TABLE)), TABLE)
    wait(lambda: "need protocol 2" in made.driver.trouble)
    made.tell(0.3)
    assert not made.base.firmware.power
    made.driver.stop()
    made.base.close()


def test_a_chair_with_a_joysticks_input_drives_what_is_asked_and_goes_to_neutral_in_silence() -> None:
    joystick = JoystickInput(TABLE)
    made = Pair(Firmware(SETTINGS.wheels, joystick=joystick), TABLE)
    wait(lambda: made.driver.trouble == "")
    made.drive()
    assert joystick.volts == (3.2, 2.5)
    made.tell(0.8, velocity=False)  # the driver brakes by its own clock
    assert made.speed == 0.0 and joystick.volts == joystick.neutral and made.base.firmware.power
    made.drive()
    made.base.deaf = True  # and the firmware by its own
    made.tell(0.8)
    assert made.speed == 0.0 and joystick.volts == joystick.neutral and not made.base.firmware.power
    made.base.deaf = False
    made.drive()
    made.base.firmware.emergency_stop = True
    made.tell(0.5)
    assert made.speed == 0.0 and joystick.volts == joystick.neutral
    made.driver.stop()
    made.base.close()


def test_a_contact_that_closes_and_a_current_that_flows_are_told(pair: Pair) -> None:
    assert pair.driver.tells_charging and not pair.driver.flags & (Flags.CONTACT | Flags.CHARGING)
    pair.base.firmware.contact = True
    wait(lambda: bool(pair.driver.flags & Flags.CONTACT) and not pair.driver.flags & Flags.CHARGING)
    pair.base.firmware.charging = True
    wait(lambda: bool(pair.driver.flags & Flags.CHARGING))
    pair.base.firmware.contact = pair.base.firmware.charging = False
    wait(lambda: not pair.driver.flags & (Flags.CONTACT | Flags.CHARGING))


def test_the_button_of_the_base_stops_and_letting_it_go_drives_nothing(pair: Pair) -> None:
    pair.drive()
    pair.base.firmware.emergency_stop = True
    pair.tell(5.0, until=lambda: pair.speed == 0.0)
    assert pair.speed == 0.0 and not pair.base.firmware.power
    assert Flags.EMERGENCY_STOP in pair.driver.flags and "pressed" in pair.driver.request.why
    pair.base.firmware.emergency_stop = False
    pair.tell(0.5)
    assert pair.speed == 0.0
    pair.drive()


def test_no_port_says_what_to_do() -> None:
    driver = Driver(replace(SETTINGS, port="/dev/no_such_port"), lambda driven: None)
    driver.start()
    wait(lambda: "no such port" in driver.trouble)
    driver.stop()


def test_the_firmware_takes_no_command_twice_and_none_with_the_power() -> None:
    firmware = Firmware(SETTINGS.wheels)
    line = encode(Command(1, 0.5, 0.0, True).text())
    firmware.receive(encode(Command(0, 0.0, 0.0, False).text()))
    for k in range(50):  # the same line again and again, as a buffer that is stuck
        firmware.receive(line)
        firmware.step(0.02 * k)
    assert firmware.speeds == [0.0, 0.0] and not firmware.power
    firmware.receive(encode(Command(2, 0.5, 0.0, True).text()))
    firmware.step(1.02)
    assert firmware.speeds == [0.0, 0.0], "what comes with the power drives nothing"
    firmware.receive(encode(Command(3, 0.5, 0.0, True).text()))
    firmware.step(1.04)
    assert firmware.speeds[0] > 0.0


def test_the_firmware_does_not_drive_on_when_its_button_is_let_go() -> None:
    firmware, now = Firmware(SETTINGS.wheels), 0.0

    def command(v: float, times: int = 10) -> float:
        nonlocal now
        for _ in range(times):
            now += 0.02
            firmware.receive(encode(Command(round(now / 0.02), v, 0.0, True).text()))
            firmware.step(now)
        return firmware.speeds[0]

    assert command(0.2) == 0.0, "nor when it has just been started"
    assert command(0.0, 2) == 0.0
    assert command(0.2, 30) > 0.1
    firmware.emergency_stop = True
    assert command(0.2) == 0.0
    firmware.emergency_stop = False
    assert command(0.2) == 0.0
    assert command(0.0, 2) == 0.0
    assert command(0.2) > 0.0


def test_the_firmware_takes_no_voltage_beyond_its_limits_and_none_with_the_power() -> None:
    joystick = JoystickInput(TABLE)
    firmware = Firmware(SETTINGS.wheels, joystick=joystick)

    def tell(sequence: int, drive: float, turn: float = 2.5) -> tuple[float, float]:
        firmware.receive(encode(Deflection(sequence, drive, turn, True).text()))
        firmware.step(0.02 * sequence)
        return joystick.volts

    assert tell(1, 3.2) == (2.5, 2.5), "it comes with the power"
    assert tell(2, 3.2) == (2.5, 2.5), "neutral has not come yet"
    assert tell(3, 2.5) == (2.5, 2.5)
    assert tell(4, 3.2, 2.0) == (3.2, 2.0)
    assert tell(5, 3.9) == tell(6, 3.2, 0.0) == (2.5, 2.5)
    firmware.receive(encode(Command(7, 0.5, 0.0, True).text()))  # not the language of this base
    assert firmware.step(0.5) and joystick.volts == (2.5, 2.5) and firmware.speeds[0] < 0.1
