"""A joystick of Linux' input system, by evdev."""

from __future__ import annotations

import select
from typing import Any

import evdev
from evdev import ecodes

from seater_controls.settings import JoystickSettings


class DeviceError(Exception):
    """There is no such joystick, or it is gone; in words, with the remedy."""


class Lost:
    """Among the events: some were lost, ask for the state."""


Event = tuple[str, int]  # name of axis or button, raw number (button: 1 pressed, 0 up)


class Device:
    """Open from the start. Raises DeviceError, also what follows."""

    def __init__(self, settings: JoystickSettings) -> None:
        names = {settings.drive.code, settings.turn.code, settings.dead_man, settings.hold} - {""}
        unknown = sorted(name for name in names if name not in ecodes.ecodes)
        if unknown:
            raise DeviceError(f"no axis or button is called {', '.join(unknown)}: evtest shows the names")
        self._codes = {(_type(name), ecodes.ecodes[name]): name for name in names}
        self._axes = [settings.drive.code, settings.turn.code]
        try:
            self._device: Any = evdev.InputDevice(settings.device) if settings.device else self._first()
        except PermissionError as error:
            raise DeviceError(
                f"{settings.device}: no permission: sudo usermod -aG input $USER, then log in anew"
            ) from error
        except OSError as error:
            raise DeviceError(f"{settings.device} cannot be opened ({error}): is the joystick plugged in?") from error
        missing = self._missing(self._device)
        if missing:
            self._device.close()
            raise DeviceError(f"{self._device.path} ({self._device.name}) has no {', '.join(missing)}")

    @property
    def name(self) -> str:
        """As the device says."""
        return f"{self._device.name} ({self._device.path})"

    def _first(self) -> Any:
        found = [evdev.InputDevice(path) for path in sorted(evdev.list_devices())]
        fitting = next((device for device in found if not self._missing(device)), None)
        for device in found:
            if device is not fitting:
                device.close()
        if fitting is None:
            wanted = ", ".join(sorted(self._codes.values()))
            raise DeviceError(f"none of {len(found)} readable input devices has {wanted}: is the joystick plugged in?")
        return fitting

    def _missing(self, device: Any) -> list[str]:
        has = device.capabilities(absinfo=False)
        return sorted(name for (kind, code), name in self._codes.items() if code not in has.get(kind, ()))

    def state(self) -> tuple[dict[str, int], set[str]]:
        """Raw numbers of the axes, names of the pressed buttons."""
        try:
            raw = {name: self._device.absinfo(ecodes.ecodes[name]).value for name in self._axes}
            keys = self._device.active_keys()
        except OSError as error:
            raise self._gone(error) from error
        return raw, {name for (kind, code), name in self._codes.items() if kind == ecodes.EV_KEY and code in keys}

    def read(self, timeout: float) -> list[Event | Lost]:
        """What has come, after `timeout` [s] at the latest."""
        try:
            if not select.select([self._device.fd], [], [], timeout)[0]:
                return []
            return self.named((event.type, event.code, event.value) for event in self._device.read())
        except BlockingIOError:
            return []
        except (OSError, ValueError) as error:
            raise self._gone(error) from error

    def named(self, events: Any) -> list[Event | Lost]:
        """Of (type, code, value), those that are of use."""
        found: list[Event | Lost] = []
        for kind, code, value in events:
            if (kind, code) == (ecodes.EV_SYN, ecodes.SYN_DROPPED):
                found.append(Lost())
            elif (kind, code) in self._codes and value != 2:  # 2: a button repeats itself
                found.append((self._codes[kind, code], value))
        return found

    def _gone(self, error: Exception) -> DeviceError:
        return DeviceError(f"{self._device.path} is gone ({error}): is the joystick plugged in?")

    def close(self) -> None:
        """Once."""
        self._device.close()


def _type(name: str) -> int:
    return int(ecodes.EV_ABS if name.startswith("ABS_") else ecodes.EV_KEY)
