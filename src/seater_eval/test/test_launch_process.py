"""The port of a launch's own master."""

import socket
from pathlib import Path

import pytest

from seater_eval.ros import launch_process
from seater_eval.ros.launch_process import LaunchProcess, free_port


def test_ports_are_free_and_none_that_the_system_hands_out() -> None:
    """Of those it gave 35765 to another program before the master had started."""
    ports = [free_port() for _ in range(20)]
    assert len(set(ports)) > 15 and all(1024 < port < 32768 for port in ports)
    for port in ports:
        with socket.socket() as probe:
            probe.bind(("localhost", port))


def test_a_port_in_use_is_passed_over(monkeypatch) -> None:
    with socket.socket() as taken:
        taken.bind(("localhost", 0))
        port = taken.getsockname()[1]
        monkeypatch.setattr(launch_process, "_PORTS", range(port, port + 1))
        with pytest.raises(OSError, match="no free TCP port"):
            free_port()


def test_what_nodes_have_complained_about_is_found_in_all_that_they_say(tmp_path: Path) -> None:
    log = tmp_path / "launch.log"
    log.write_text(
        "\x1b[0m[ INFO] [1795947240.319]: Subscribing to undock/cancel\x1b[0m\n"
        "[FATAL] [1795947265.199743, 0.000000]: /sim: wrong parameters:\n  /sim/seed: is -1, must be >= 0\n"
        "\x1b[31m====REQUIRED process [sim-2] has died!\nprocess has died [pid 23086]\n"
        "\x1b[31m[ERROR] [1795947265.3]: no camera\x1b[0m\n\x1b[33m[ WARN] [17.5]: late\x1b[0m\n"
    )
    launch = LaunchProcess("package", "x.launch", {}, log)
    assert launch.errors() == ["/sim: wrong parameters:\n  /sim/seed: is -1, must be >= 0", "no camera"]
