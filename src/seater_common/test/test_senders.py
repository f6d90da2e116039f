"""Two nodes that send on one topic in turns are noticed; one that takes over from another is none of the two."""

from types import SimpleNamespace

import pytest

from seater_common.inputs.senders import MEMORY, Senders, sender_of


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def senders(clock: Clock) -> Senders:
    return Senders("/obstacles", clock)


def hear(senders: Senders, clock: Clock, names: str, period: float = 0.1) -> None:
    for name in names:
        senders.heard(f"/{name}")
        clock.now += period


@pytest.mark.parametrize("names", ["aaaaba", "ababab", "aaabbaab"])
def test_two_that_speak_in_turns_are_named(senders: Senders, clock: Clock, names: str) -> None:
    """As soon as the first speaks again: one message that somebody types is enough."""
    hear(senders, clock, names)
    assert senders.trouble() == "2 nodes publish /obstacles in turns, /a and /b: one is allowed"
    hear(senders, clock, "a" * 25)
    assert senders.trouble() == ""  # the other one has gone


@pytest.mark.parametrize("names", ["aaaa", "aaabbbb", "aaabbbccc"])
def test_one_that_takes_over_is_no_second_one(senders: Senders, clock: Clock, names: str) -> None:
    hear(senders, clock, names)
    assert senders.trouble() == ""


def test_one_that_was_silent_for_long_has_ended(senders: Senders, clock: Clock) -> None:
    hear(senders, clock, "a")
    hear(senders, clock, "b" * 5, 0.5 * MEMORY)
    hear(senders, clock, "a")
    assert senders.trouble() == ""


def test_the_sender_of_a_message() -> None:
    assert sender_of(SimpleNamespace(_connection_header={"callerid": "/camera"})) == "/camera"
    assert sender_of(SimpleNamespace(_connection_header=None)) == sender_of(object()) == ""
