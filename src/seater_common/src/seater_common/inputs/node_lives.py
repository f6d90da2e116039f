"""Whether a ROS node lives: it is asked as `rosnode ping` does. The master also knows those that were killed."""

from __future__ import annotations

from http.client import HTTPException
from typing import Any
from xmlrpc.client import Fault, ProtocolError, ServerProxy, Transport

PATIENCE = 1.0  # [s] for the answer of a node that stands still


class _Prompt(Transport):
    """Gives up in time."""

    def __init__(self, patience: float) -> None:
        super().__init__()
        self._patience = patience

    def make_connection(self, host: Any) -> Any:
        connection = super().make_connection(host)
        connection.timeout = self._patience
        return connection


def node_lives(name: str, caller: str, patience: float = PATIENCE) -> bool:
    """Whether the node of this name answers within `patience` [s], as far as the ROS master knows it; `caller` asks."""
    import rosgraph

    try:
        return answers(rosgraph.Master(caller).lookupNode(name), caller, patience)
    except (rosgraph.MasterException, OSError):
        return False


def answers(uri: str, caller: str, patience: float = PATIENCE) -> bool:
    """Whether a node's XML-RPC server answers."""
    try:
        ServerProxy(uri, transport=_Prompt(patience)).getPid(caller)
    except Fault:  # an answer, too
        return True
    except (OSError, HTTPException, ProtocolError):
        return False
    return True
