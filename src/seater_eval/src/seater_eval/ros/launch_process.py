"""A roslaunch of its own: own master on a free port, output in a file, ended by the signal that Ctrl-C sends."""

from __future__ import annotations

import os
import random
import re
import signal
import socket
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path

# Below what systems hand out by themselves (Linux: from 32768 on): a connection that any program opens until the master
# has started would get the port that was free a moment ago.
_PORTS = range(12000, 32000)
_TRIES = 100
_COLOUR = re.compile("\x1b\\[[0-9]*m")
_ERROR = re.compile(r"^ ?\[(?:ERROR|FATAL)\] \[[0-9., ]*\]: (.*(?:\n  .*)*)", re.MULTILINE)


def free_port() -> int:
    """A TCP port that nobody uses right now, or is handed by the system soon.

    Raises:
        OSError: after many ports that are all in use.
    """
    draw = random.SystemRandom()  # another process that was started with the same seed draws other ones
    for port in (draw.choice(_PORTS) for _ in range(_TRIES)):
        with socket.socket() as probe:
            try:
                probe.bind(("localhost", port))
            except OSError:
                continue
            return port
    raise OSError(f"no free TCP port among {_TRIES} of {_PORTS.start} to {_PORTS.stop - 1}")


class LaunchProcess:
    """`with LaunchProcess(...)`: roslaunch runs inside and is ended at the end, whatever happens."""

    def __init__(
        self, package: str, launch_file: str, arguments: Mapping[str, object], log_file: Path, port: int | None = None
    ) -> None:
        """`port`: of a master that somebody else has started, or will."""
        self.port = port or free_port()
        self.log_file = log_file
        self._command = ["roslaunch", "-p", str(self.port), package, launch_file]
        self._command += ["--wait"] if port else []
        self._command += [f"{name}:={value}" for name, value in arguments.items()]
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def master_uri(self) -> str:
        return f"http://localhost:{self.port}"

    def __enter__(self) -> LaunchProcess:
        self.log_file.parent.mkdir(parents=True, exist_ok=True)
        environment = dict(os.environ)
        environment.update(
            ROS_MASTER_URI=self.master_uri,
            ROS_HOSTNAME="localhost",
            ROS_LOG_DIR=str(self.log_file.parent),
            ROSCONSOLE_STDOUT_LINE_BUFFERED="1",
            PYTHONUNBUFFERED="1",
        )
        environment.pop("ROS_IP", None)
        with self.log_file.open("wb") as log:
            # Its own process group: Ctrl-C on the terminal reaches us alone, and we end it in order.
            self._process = subprocess.Popen(
                self._command, stdout=log, stderr=subprocess.STDOUT, env=environment, start_new_session=True
            )
        return self

    def running(self) -> bool:
        return self._process is not None and self._process.poll() is None

    def wait(self, timeout: float) -> bool:
        """Wall time [s]; true when it has ended by itself."""
        end = time.monotonic() + timeout
        while self.running() and time.monotonic() < end:
            time.sleep(0.05)
        return not self.running()

    def stop(self) -> None:
        """Ends it as Ctrl-C does, harder only when it does not listen."""
        if self._process is None:
            return
        for name, patience in ((signal.SIGINT, 30.0), (signal.SIGTERM, 10.0), (signal.SIGKILL, 5.0)):
            if not self.running():
                return
            os.killpg(self._process.pid, name) if name == signal.SIGKILL else self._process.send_signal(name)
            self.wait(patience)

    def __exit__(self, *_: object) -> None:
        self.stop()

    def errors(self) -> list[str]:
        """What its nodes have said at the levels ERROR and FATAL, in order."""
        return [found[1] for found in _ERROR.finditer(_COLOUR.sub("", self.log_file.read_text(errors="replace")))]

    def last_lines(self, count: int = 25) -> str:
        """The end of its output."""
        return "\n".join(self.log_file.read_text(errors="replace").splitlines()[-count:])
