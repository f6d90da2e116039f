"""The port of a launch's own master."""

import socket

import pytest

from seater_eval.ros import launch_process
from seater_eval.ros.launch_process import free_port


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
