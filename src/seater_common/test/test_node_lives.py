"""Nodes that answer, and nodes that the master knows no more, or still."""

from __future__ import annotations

import socket
import threading
from types import SimpleNamespace
from xmlrpc.server import SimpleXMLRPCServer

import pytest
import rosgraph

from seater_common.inputs.node_lives import answers, node_lives


@pytest.fixture
def master(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Nodes by name, with their addresses, as the ROS master has them."""
    nodes: dict[str, str] = {}

    def look_up(name: str) -> str:
        if name not in nodes:
            raise rosgraph.MasterError("unknown node")
        return nodes[name]

    monkeypatch.setattr(rosgraph, "Master", lambda _: SimpleNamespace(lookupNode=look_up))
    return nodes


def address_of(server: SimpleXMLRPCServer) -> str:
    return f"http://127.0.0.1:{server.server_address[1]}/"


def test_who_answers_lives() -> None:
    """A node's server, one that only knows other calls, one that has ended, and one that stands still."""
    for known in (True, False):
        server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        if known:
            server.register_function(lambda caller: [1, caller, 42], "getPid")
        uri = address_of(server)
        threading.Thread(target=server.handle_request, daemon=True).start()
        assert answers(uri, "/test")
        server.server_close()
        assert not answers(uri, "/test")
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        assert not answers(f"http://127.0.0.1:{silent.getsockname()[1]}/", "/test", patience=0.3)


def test_only_a_panel_that_answers_is_one(master: dict[str, str]) -> None:
    """A second one finds the one that runs, and none that was killed."""

    def ask() -> bool:
        return node_lives("/panel", "/panel_to_be", patience=2.0)

    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        server.register_function(lambda _: (1, "", 4711), "getPid")
        master["/panel"] = address_of(server)
        threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        assert ask()
        server.shutdown()
    assert not ask()
    master.clear()
    assert not ask()


def test_who_is_not_known_to_the_master_is_gone(master: dict[str, str]) -> None:
    assert not node_lives("/client", "/test")
