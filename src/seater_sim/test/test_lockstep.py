"""The waiting side of the lock-step."""

import threading
import time

from seater_sim.loop.lockstep import KEEP, Answers


def test_an_answer_that_is_there_is_taken_at_once() -> None:
    answers: Answers[str] = Answers()
    answers.put("odom", 5, "done")
    assert answers.wait("odom", 5, 0.0, lambda: False) == "done"


def test_wait_ends_with_the_right_answer_only() -> None:
    answers: Answers[str] = Answers()

    def answer() -> None:
        answers.put("odom", 4, "old")
        answers.put("image", 5, "other")
        time.sleep(0.05)
        answers.put("odom", 5, "done")

    thread = threading.Thread(target=answer)
    thread.start()
    assert answers.wait("odom", 5, 10.0, lambda: True) == "done"
    thread.join()
    assert not answers.missed


def test_who_has_gone_is_not_waited_for() -> None:
    answers: Answers[str] = Answers()
    looks = iter([True, False])
    began = time.monotonic()
    assert answers.wait("odom", 5, 60.0, lambda: next(looks)) is None
    assert time.monotonic() - began < 5.0
    assert not answers.missed


def test_a_missing_answer_is_counted() -> None:
    answers: Answers[str] = Answers()
    assert answers.wait("odom", 5, 0.05, lambda: True) is None
    assert answers.missed == {"odom": 1}


def test_closing_ends_a_wait() -> None:
    answers: Answers[str] = Answers()
    timer = threading.Timer(0.05, answers.close)
    timer.start()
    began = time.monotonic()
    assert answers.wait("odom", 5, 60.0, lambda: True) is None
    assert time.monotonic() - began < 5.0
    assert not answers.missed


def test_old_answers_are_forgotten() -> None:
    answers: Answers[int] = Answers()
    for stamp in range(KEEP + 1):
        answers.put("odom", stamp, stamp + 1)
    assert answers.get("odom", 0) is None
    assert answers.get("odom", 1) == 2
