"""A goal whose client is gone is noticed; one whose client lives, or that nobody is to watch, is left alone."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from seater_nmpc.ros import goals
from seater_nmpc.ros.goals import ClientWatch

GOAL = SimpleNamespace(_connection_header={"callerid": "/client"})


class Clock:
    """Each sleep of the watching thread is a turn of the test's: who lives in it is said before."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now, self.alive, self.asked = 100.0, True, []
        monkeypatch.setattr(goals, "time", SimpleNamespace(monotonic=lambda: self.now, sleep=lambda _: None))
        self._thread: Any = None
        monkeypatch.setattr(goals, "threading", SimpleNamespace(Thread=self._keep))
        self._turns = iter(())
        monkeypatch.setattr(goals.rospy, "is_shutdown", lambda: next(self._turns, True))

    def _keep(self, target: Any, daemon: bool) -> Any:
        self._thread = target
        return SimpleNamespace(start=lambda: None)

    def lives(self, name: str) -> bool:
        self.asked.append(name)
        return self.alive

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / goals.PING_PERIOD)):
            self.now += goals.PING_PERIOD
            if self._thread is not None:
                self._turns = iter((False,))
                self._thread()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


def test_a_client_that_is_gone_is_noticed_in_time(clock: Clock) -> None:
    watch = ClientWatch(3.0, clock.lives)
    watch.begin(GOAL)
    clock.run(60.0)
    assert watch.lost() == "" and set(clock.asked) == {"/client"}
    clock.alive = False
    clock.run(3.0)
    assert watch.lost() == ""
    clock.run(0.5)
    assert watch.lost() == "/client, which gave the goal, has not answered for 3.5 s"
    watch.end()
    assert watch.lost() == ""
    watch.begin(GOAL)
    assert watch.lost() == ""


def test_without_the_option_nobody_is_asked(clock: Clock) -> None:
    watch = ClientWatch(0.0, clock.lives)
    watch.begin(GOAL)
    clock.run(60.0)
    assert watch.lost() == "" and clock.asked == []


def test_a_time_out_shorter_than_an_answer_is_refused() -> None:
    with pytest.raises(ValueError, match=r"client_timeout: is 0\.5, must be 0 or at least 2"):
        ClientWatch(0.5)
