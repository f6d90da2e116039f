"""The driver: one thread commands, another listens; the port is opened anew when it is gone."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from seater_base.commander import Commander, Request
from seater_base.deflection.inverse import Deflections
from seater_base.odometry import Driven, WheelOdometry
from seater_base.port import Port, PortError
from seater_base.protocol import (
    ASK,
    SPOKEN,
    VERSION,
    Command,
    Deflection,
    Flags,
    Identity,
    Lines,
    Message,
    Reading,
    encode,
)
from seater_base.settings import BaseSettings

_PAUSE = 0.5  # [s] before the port is opened anew
_ASK_PERIOD = 1.0  # [s] between two questions who the base is
_LISTEN = 0.1  # [s] that a read waits
_ZEROS = 3  # commands of zero, without power, at the end


class Driver:
    """`velocity` and `power` may be called from any thread; `on_driven` and, with every reading, `on_flags` are called
    in the listening one. With `deflections` the base is told voltages of a joystick, not speeds.

    `on_failure` hears of what nobody has thought of: that thread has ended then, and the base stops by itself.
    """

    def __init__(
        self,
        settings: BaseSettings,
        on_driven: Callable[[Driven], None],
        on_failure: Callable[[Exception], None] = lambda error: None,
        on_flags: Callable[[Flags], None] = lambda flags: None,
        deflections: Deflections | None = None,
    ) -> None:
        self._settings, self._on_driven, self._on_failure, self._on_flags = settings, on_driven, on_failure, on_flags
        self._deflections = deflections
        self.commander, self.odometry = Commander(settings), WheelOdometry(settings)
        self._telling = threading.Lock()  # of the commander
        self._port: Port | None = None
        self._writing = threading.Lock()
        self._sequence = 0
        self._stop = threading.Event()
        self._lines = Lines()
        self.identity: Identity | None = None
        self.flags = Flags(0)
        self.heard = 0.0  # steady time of the last reading [s]
        self.trouble = "the port has not been opened yet"  # empty: none
        self.request = Request(0.0, 0.0, False, "not started")
        self._threads = [
            threading.Thread(target=self._run, args=(work,), daemon=True) for work in (self._listen, self._command)
        ]

    @property
    def damaged(self) -> int:
        """Lines that could not be read."""
        return self._lines.damaged

    @property
    def _understood(self) -> bool:
        """The base has said who it is, and speaks what it has to be told."""
        return self.identity is not None and not self._why_not_driven(self.identity.version)

    def _why_not_driven(self, version: int) -> str:
        if version not in SPOKEN:
            return f"the base speaks protocol {version}, not {VERSION}"
        if version < 2 and self._deflections is not None:
            return f"the base speaks protocol {version}: a joystick's voltages need protocol 2"
        return ""

    @property
    def tells_charging(self) -> bool:
        """The base has a word about contact and charger."""
        return self.identity is not None and self.identity.version >= 2

    def start(self) -> None:
        """From now on."""
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Zero, and the power off; then the port is closed."""
        self._stop.set()
        for thread in self._threads:
            thread.join(2.0)
        for _ in range(_ZEROS):
            self._send(Request(0.0, 0.0, False, "the driver ends"))
        self._close()

    def velocity(self, v: float, omega: float, sender: str) -> None:
        """A message on cmd_vel."""
        with self._telling:
            self.commander.velocity(v, omega, sender, time.monotonic())

    def power(self, on: bool) -> None:
        """A message on motor_enable."""
        with self._telling:
            self.commander.power(on, time.monotonic())

    def _run(self, work: Callable[[], None]) -> None:
        try:
            work()
        except Exception as error:
            self._on_failure(error)

    def _command(self) -> None:
        period, due = 1.0 / self._settings.rate, time.monotonic()
        while not self._stop.is_set():
            with self._telling:
                self.request = self.commander.request(time.monotonic())
            self._send(self.request)
            due = max(due + period, time.monotonic())
            self._stop.wait(max(0.0, due - time.monotonic()))

    def _send(self, request: Request) -> None:
        """To nobody while the port is gone, or speaks another language."""
        with self._writing:
            if self._port is None or not self._understood:
                return
            self._sequence = (self._sequence + 1) % 2**32
            try:
                self._port.write(encode(self._command_of(request).text()))
            except PortError:
                return  # the listening thread finds it, too

    def _command_of(self, request: Request) -> Command | Deflection:
        if self._deflections is None:
            return Command(self._sequence, request.v, request.omega, request.power)
        volts = self._deflections.volts(request.v, request.omega)
        return Deflection(self._sequence, *volts, request.power)

    def _listen(self) -> None:
        while not self._stop.is_set():
            try:
                port = Port(self._settings.port, self._settings.baud)
                with self._writing:
                    self._port, self.identity = port, None
                self.trouble = "the base does not answer"
                self._converse(port)
            except PortError as error:
                self.trouble = str(error)
                self._close()
                self._stop.wait(_PAUSE)

    def _converse(self, port: Port) -> None:
        asked = -_ASK_PERIOD
        self._lines = Lines()
        self.odometry.disconnected()
        while not self._stop.is_set():
            if self.identity is None and time.monotonic() - asked >= _ASK_PERIOD:
                asked = time.monotonic()
                port.write(encode(ASK))
            for message in self._lines.feed(port.read(_LISTEN)):
                self._take(message, time.monotonic())
            if self._understood and time.monotonic() - self.heard > self._settings.silence:
                self.trouble = "the base is silent"

    def _take(self, message: Message, now: float) -> None:
        if isinstance(message, Identity):  # it has started, too, perhaps: its counts begin anew
            self.identity = message
            with self._telling:
                self.commander.base_started()
            self.odometry.disconnected()
            self.trouble = self._why_not_driven(message.version)
        if isinstance(message, Reading) and self._understood:
            self.flags, self.heard, self.trouble = message.flags, now, ""
            with self._telling:
                self.commander.emergency_stop(bool(message.flags & Flags.EMERGENCY_STOP))
            self._on_flags(message.flags)
            driven = self.odometry.add(message, now)
            if driven is not None:
                self._on_driven(driven)

    def _close(self) -> None:
        with self._writing:
            port, self._port = self._port, None
        if port is not None:
            port.close()
