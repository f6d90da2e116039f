"""Detectors with the processor time that they take."""

from __future__ import annotations

import multiprocessing
import os
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_eval.peers.process import PeerProcess
from seater_eval.perception.peers import Detector, make_peer

Image = NDArray[np.uint8]


class Timed:
    """A detector in this process, with the processor time it took."""

    def __init__(self, detect: Detector) -> None:
        self._detect = detect

    def __call__(self, image: Image) -> tuple[set[int], float]:
        """Ids found and processor time [ms]."""
        start = time.thread_time()
        seen = self._detect(image)
        return {s.id for s in seen}, 1e3 * (time.thread_time() - start)

    def end(self) -> None:
        """Nothing to do here."""


class TimedElsewhere(Timed):
    """The same in a process of its own: what pupil-apriltags does to its heap when it is destroyed stays there."""

    def __init__(self, name: str, K: NDArray[np.float64], size: float) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, name, K, size), daemon=True)
        self._process.start()
        theirs.close()

    def __call__(self, image: Image) -> tuple[set[int], float]:
        self._pipe.send(image)
        ids, taken = self._pipe.recv()
        return ids, taken

    def end(self) -> None:
        self._pipe.send(None)
        self._process.join(5.0)


class TimedPeer(Timed):
    """A package from PyPI, which tells its own time."""

    def __init__(self, process: PeerProcess) -> None:
        self._process = process

    def __call__(self, image: Image) -> tuple[set[int], float]:
        answer = self._process.look(image)
        return {i for i, _ in answer.found}, answer.milliseconds


def _serve(pipe: Any, name: str, K: NDArray[np.float64], size: float) -> None:
    detector = Timed(make_peer(name, K, size))
    while (image := pipe.recv()) is not None:
        pipe.send(detector(image))
    os._exit(0)  # without any destructor
