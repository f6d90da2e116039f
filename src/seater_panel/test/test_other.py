"""A second panel finds the one that runs, and none that was killed."""

import threading
from xmlrpc.server import SimpleXMLRPCServer

import rosgraph

from seater_panel.ros.other import answers


class Master:
    def __init__(self, **nodes: str) -> None:
        self.nodes = nodes

    def lookupNode(self, name: str) -> str:
        if name not in self.nodes:
            raise rosgraph.MasterError(f"unknown node {name}")
        return self.nodes[name]


def test_only_a_panel_that_answers_is_one() -> None:
    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        server.register_function(lambda _: (1, "", 4711), "getPid")
        address = f"http://127.0.0.1:{server.server_address[1]}/"
        threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        assert answers(Master(panel=address), "panel")
        server.shutdown()
    assert not answers(Master(panel=address), "panel")
    assert not answers(Master(), "panel")
