"""A thread that listens to the joystick, and opens it anew when it is gone."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol

from seater_controls.background import Background
from seater_controls.joystick.device import Device, DeviceError, Event, Lost
from seater_controls.joystick.stick import Stick, Wish
from seater_controls.settings import JoystickSettings

_PAUSE = 0.5  # [s] before it is opened anew
_LISTEN = 0.1  # [s] that a read waits


class Readable(Protocol):
    """Device, or another one in tests."""

    @property
    def name(self) -> str: ...
    def state(self) -> tuple[dict[str, int], set[str]]: ...
    def read(self, timeout: float) -> list[Event | Lost]: ...
    def close(self) -> None: ...


class Reader(Background):
    """`wish` may be called from any thread. When the thread fails in a way that nobody has thought of, the joystick
    counts as gone, for good."""

    def __init__(
        self, settings: JoystickSettings, open_device: Callable[[JoystickSettings], Readable] = Device
    ) -> None:
        super().__init__()
        self._settings, self._open = settings, open_device
        self._stick, self._lock = Stick(settings), threading.Lock()
        self.name = ""  # of the device that is open

    def wish(self) -> Wish:
        """What the person asks for now."""
        with self._lock:
            return self._stick.wish(time.monotonic())

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                self._listen()
            except DeviceError as error:
                self._gone(str(error))
            except Exception as error:
                self._gone(f"the joystick's thread has failed, {type(error).__name__}: {error}")
                raise
            self._stop.wait(_PAUSE)
        self._gone("the node ends")

    def _listen(self) -> None:
        device = self._open(self._settings)
        try:
            self.name = device.name
            self._take_state(device)
            while not self._stop.is_set():
                for event in device.read(_LISTEN):
                    if isinstance(event, Lost):
                        self._take_state(device)
                        break  # what else came is older than this state
                    with self._lock:
                        self._stick.event(*event, time.monotonic())
        finally:
            device.close()

    def _take_state(self, device: Readable) -> None:
        raw, pressed = device.state()
        with self._lock:
            self._stick.plugged(raw, pressed, time.monotonic())

    def _gone(self, why: str) -> None:
        with self._lock:
            self._stick.unplugged(why)
        self.name = ""
