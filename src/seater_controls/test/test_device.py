"""The joystick's device: a recorded stream through the driver's own class, uinput where the machine has it, or a real
one (`--hardware joystick:/dev/input/event3`)."""

import errno
import os
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import evdev
import pytest
from evdev import ecodes

from seater_controls.joystick.device import Device, DeviceError, Lost
from seater_controls.joystick.reader import Reader
from seater_controls.settings import JoystickSettings

SETTINGS = JoystickSettings(device="/dev/input/recorded")
EVENT = struct.Struct("llHHi")  # struct input_event of Linux, 64 bits
# type, code, value, as evtest prints them: pressed, forward, a repetition, hold-to-run, half to the left, all let go.
RECORDED = [
    (ecodes.EV_KEY, ecodes.BTN_TRIGGER, 1),
    (ecodes.EV_SYN, ecodes.SYN_REPORT, 0),
    (ecodes.EV_ABS, ecodes.ABS_Y, 0),
    (ecodes.EV_KEY, ecodes.BTN_TRIGGER, 2),
    (ecodes.EV_KEY, ecodes.BTN_THUMB, 1),
    (ecodes.EV_ABS, ecodes.ABS_HAT0X, -1),
    (ecodes.EV_ABS, ecodes.ABS_X, 64),
    (ecodes.EV_SYN, ecodes.SYN_REPORT, 0),
]


class Recorded:
    """In the place of evdev.InputDevice: its events come through a pipe in the kernel's own format."""

    name, path = "recorded", "/dev/input/recorded"

    def __init__(self, path: str) -> None:
        if path not in machine.plugged:
            raise FileNotFoundError(errno.ENOENT, "No such file or directory", path)
        self.fd, self._writer = os.pipe()
        os.set_blocking(self.fd, False)
        machine.open = self

    def capabilities(self, absinfo: bool) -> dict[int, list[int]]:
        return machine.capabilities

    def absinfo(self, code: int) -> SimpleNamespace:
        return SimpleNamespace(value=machine.axes[code])

    def active_keys(self) -> list[int]:
        return machine.keys

    def read(self) -> Iterator[SimpleNamespace]:
        data = os.read(self.fd, 64 * EVENT.size)
        if not data:
            raise OSError(errno.ENODEV, "No such device")
        for _, _, kind, code, value in EVENT.iter_unpack(data):
            yield SimpleNamespace(type=kind, code=code, value=value)

    def send(self, *events: tuple[int, int, int]) -> None:
        os.write(self._writer, b"".join(EVENT.pack(0, 0, *event) for event in events))

    def unplug(self) -> None:
        machine.plugged.clear()
        os.close(self._writer)

    def close(self) -> None:
        os.close(self.fd)


@pytest.fixture(autouse=True)
def fresh(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    global machine
    machine = SimpleNamespace(
        plugged={"/dev/input/recorded"},
        open=None,
        axes={ecodes.ABS_X: 128, ecodes.ABS_Y: 128},
        keys=[],
        capabilities={
            ecodes.EV_ABS: [ecodes.ABS_X, ecodes.ABS_Y],
            ecodes.EV_KEY: [ecodes.BTN_TRIGGER, ecodes.BTN_THUMB],
        },
    )
    if "uinput" not in request.node.name and "real" not in request.node.name:
        monkeypatch.setattr(evdev, "InputDevice", Recorded)
        monkeypatch.setattr(evdev, "list_devices", lambda: sorted(machine.plugged))


def wait(condition: Callable[[], bool], seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.005)


def test_a_recorded_stream_becomes_names() -> None:
    device = Device(SETTINGS)
    machine.open.send(*RECORDED)
    assert device.read(1.0) == [("BTN_TRIGGER", 1), ("ABS_Y", 0), ("BTN_THUMB", 1), ("ABS_X", 64)]
    assert device.read(0.0) == []
    machine.open.send((ecodes.EV_SYN, ecodes.SYN_DROPPED, 0))
    (lost,) = device.read(1.0)
    assert isinstance(lost, Lost)
    machine.open.unplug()
    with pytest.raises(DeviceError, match="recorded is gone"):
        device.read(1.0)
    device.close()


def test_a_recorded_drive_unplugged_on_the_way() -> None:
    reader = Reader(SETTINGS)
    reader.start()
    wait(lambda: reader.name != "")
    machine.open.send(*RECORDED)
    wait(lambda: reader.wish().v == pytest.approx(0.4) and reader.wish().omega > 0.2 and reader.wish().hold)
    machine.axes.update({ecodes.ABS_Y: 0})
    machine.keys += [ecodes.BTN_TRIGGER, ecodes.BTN_THUMB]
    machine.open.unplug()
    wait(lambda: reader.wish().v == 0.0 and not reader.wish().hold and "plugged in" in reader.wish().why)
    machine.plugged.add("/dev/input/recorded")
    wait(lambda: reader.name != "")
    assert reader.wish().v == 0.0 and not reader.wish().hold, "it was held while it was plugged in"
    reader.stop()


def test_lost_events_ask_for_the_state() -> None:
    reader = Reader(SETTINGS)
    reader.start()
    wait(lambda: reader.name != "")
    machine.open.send(*RECORDED)
    wait(lambda: reader.wish().v > 0.3)
    machine.axes.update({ecodes.ABS_Y: 128})  # the event of letting go is among those that were lost
    machine.keys.append(ecodes.BTN_TRIGGER)
    machine.open.send((ecodes.EV_SYN, ecodes.SYN_DROPPED, 0), (ecodes.EV_ABS, ecodes.ABS_Y, 0))
    wait(lambda: reader.wish().v == 0.0)
    machine.open.send((ecodes.EV_ABS, ecodes.ABS_X, 0))
    wait(lambda: reader.wish().omega == pytest.approx(0.6))
    assert reader.wish().v == 0.0, "what came with the lost events is older than the state"
    reader.stop()
    assert reader.wish().why == "the node ends"


def test_what_cannot_be_had_is_named() -> None:
    machine.plugged.clear()
    with pytest.raises(DeviceError, match="is the joystick plugged in"):
        Device(SETTINGS)
    with pytest.raises(DeviceError, match="none of 0 readable input devices has ABS_X, ABS_Y, BTN_THUMB, BTN_TRIGGER"):
        Device(JoystickSettings())
    machine.plugged.add("/dev/input/recorded")
    Device(JoystickSettings()).close()
    machine.capabilities[ecodes.EV_KEY] = [ecodes.BTN_THUMB]
    with pytest.raises(DeviceError, match="has no BTN_TRIGGER"):
        Device(SETTINGS)
    with pytest.raises(DeviceError, match="BTN_NO_SUCH: evtest"):
        Device(JoystickSettings(hold="BTN_NO_SUCH"))


def test_a_thread_that_fails_is_a_joystick_that_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("threading.excepthook", lambda arguments: None)

    def broken(settings: JoystickSettings) -> Device:
        raise KeyError("nobody has thought of it")

    reader = Reader(SETTINGS, broken)
    reader.start()
    wait(lambda: not reader.alive)
    assert reader.wish().v == 0.0 and "has failed, KeyError" in reader.wish().why


@pytest.mark.skipif(not os.access("/dev/uinput", os.W_OK), reason="no /dev/uinput")
def test_a_joystick_of_uinput() -> None:
    axis = evdev.AbsInfo(128, 0, 255, 0, 0, 0)
    capabilities = {
        ecodes.EV_ABS: [(ecodes.ABS_X, axis), (ecodes.ABS_Y, axis)],
        ecodes.EV_KEY: [ecodes.BTN_TRIGGER, ecodes.BTN_THUMB],
    }
    with evdev.UInput(capabilities, name="seater test") as made:
        wait(lambda: made.device is not None and Path(made.device.path).exists())
        reader = Reader(JoystickSettings(device=made.device.path))
        reader.start()
        wait(lambda: reader.name != "")
        for event in RECORDED:
            made.write(*event)
        wait(lambda: reader.wish().v == pytest.approx(0.4) and reader.wish().hold)
    wait(lambda: "plugged in" in reader.wish().why)
    reader.stop()


def test_a_real_joystick_that_is_let_go(request: pytest.FixtureRequest) -> None:
    devices = [
        told.partition(":")[2] for told in request.config.getoption("--hardware") if told.startswith("joystick:")
    ]
    if not devices:
        pytest.skip("no --hardware joystick:DEVICE")
    for path in devices:
        found = evdev.InputDevice(path)
        axes = {ecodes.ABS[code]: info for code, info in found.capabilities().get(ecodes.EV_ABS, [])}
        found.close()
        print(axes)  # with pytest -s: the numbers for joystick.yaml
        device = Device(JoystickSettings(device=path, dead_man="", hold=""))
        raw, pressed = device.state()
        assert raw.keys() == {"ABS_X", "ABS_Y"} and pressed == set()
        device.close()
