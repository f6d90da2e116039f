"""The other end of worker.py."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_eval.peers.catalogue import PEERS, knows

Image = NDArray[np.uint8]
WORKER = Path(__file__).with_name("worker.py")


class PeerError(Exception):
    """A peer cannot be used; the text says why and what to do."""


@dataclass(frozen=True)
class PeerAnswer:
    """What a peer found in one image."""

    found: list[tuple[int, NDArray[np.float64]]]  # id, corners (4, 2) [px] as worker.py says
    milliseconds: float  # of processor time, all its threads


class PeerProcess:
    """A detector of `PEERS` for one dictionary. It ends with the process that made it."""

    def __init__(self, folder: Path, name: str, dictionary: str) -> None:
        """`folder`: what tools/make_peers.sh made. Raises PeerError."""
        if name not in PEERS:
            raise PeerError(f"peer: is '{name}', must be one of {', '.join(PEERS)}")
        self._name = name
        command = [str(_interpreter(folder)), "-I", str(WORKER), name, dictionary]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        fault = self._answer()["fault"]
        if fault:
            raise PeerError(f"{name} in {folder} does not work: {fault}; make it anew by tools/make_peers.sh")

    def look(self, image: Image) -> PeerAnswer:
        """Raises PeerError when the process has ended."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(f"{image.shape[0]} {image.shape[1]}\n".encode())
            self._process.stdin.write(np.ascontiguousarray(image).data)
            self._process.stdin.flush()
        except OSError as error:
            raise self._ended() from error
        answer = self._answer()
        found = [(int(i), np.array(corners)) for i, corners in answer["found"]]
        return PeerAnswer(found, float(answer["milliseconds"]))

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise self._ended()
        return dict(json.loads(line))

    def _ended(self) -> PeerError:
        return PeerError(f"the process of {self._name} ended (code {self._process.poll()})")


def _interpreter(folder: Path) -> Path:
    """Not resolved: the link tells Python which environment it is in. Raises PeerError."""
    path = folder.absolute() / "bin" / "python3"
    if not path.exists():
        raise PeerError(f"{path} is missing: make the folder by tools/make_peers.sh {folder}")
    return path


def peers_for(dictionary: str, folder: Path | None) -> tuple[str, ...]:
    """Names of those that find markers of this dictionary; none without a `folder`, what tools/make_peers.sh made.
    Raises PeerError when that is something else."""
    if folder is None:
        return ()
    _interpreter(folder)
    return tuple(name for name in PEERS if knows(name, dictionary))


@lru_cache(maxsize=32)
def peer_process(folder: Path, name: str, dictionary: str) -> PeerProcess:
    """One for each kind in this process, kept to its end: they take half a second to start. Raises PeerError."""
    return PeerProcess(folder, name, dictionary)
